#!/usr/bin/env python3
"""The bench launches the programs that `raycube render` launches, and says so when it does not.
usage: bench_programs_test.py RAYCUBE RAYCUBE_BENCH"""

import json
import pathlib
import sys
import tempfile

import patience
from driver import Program, record, scene

program = Program(sys.argv[1])
run, check = program.run, program.check
with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    small = scene(work, "small")

    def bench(run_json):
        return patience.run([sys.argv[2], "--scene", small, "--check-run", run_json], capture_output=True, text=True)

    run("render", small, "-o", work / "out")
    (made,) = work.glob("out/*/run.json")
    made_by = record(made.parent)
    same = bench(made)
    check(same.returncode == 0, same.stderr)
    for key in ("program_hash", "trace_program_hash"):
        check(len(made_by[key]) == 64 and same.stdout.count(made_by[key]) == 2, same.stdout)
        # Another program of the same name: one digit of its hash differs.
        (work / "other.json").write_text(
            json.dumps({**made_by, key: made_by[key][:-1] + ("0" if made_by[key][-1] != "0" else "1")})
        )
        differs = bench(work / "other.json")
        check(differs.returncode == 1 and key in differs.stderr and made_by[key] in differs.stderr, differs.stderr)
    (work / "other.json").write_text("{}")
    unknown = bench(work / "other.json")
    check(unknown.returncode == 2 and "program_hash" in unknown.stderr, unknown.stderr)

    # A scene with other samples a pixel runs other programs.
    finer = scene(work, "finer", grid=4)
    run("render", finer, "-o", work / "finer_out")
    (made,) = work.glob("finer_out/*/run.json")
    differs = bench(made)
    check(differs.returncode == 1 and "program_hash" in differs.stderr, differs.stderr)
print(f"bench_programs: {program.checks} checks")

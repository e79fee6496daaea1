#!/usr/bin/env python3
"""stability: a LIDAR survey when the machine or the user stops it (REQUIREMENTS section 4, Machine; cubes:
render_failures): a full disk, a read-only folder, two runs into one folder, Ctrl-C, kill -9. One clear error with its
way out, the documented exit status, nothing half-written under a final name, and the next run whole. And a cube on a
device of 256 MB, which is oclgrind, with --full. usage: stability_machine_test.py RAYCUBE [--full]"""

import json
import os
import pathlib
import resource
import shutil
import signal
import sys
import tempfile

import patience
from driver import FULL, Program, gate, pulse_and_receiver, record, scene

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused
WRITES = (
    4 << 20
)  # bytes a file may grow to on the disk that is full: room for the driver's own files, not for the waveforms


def survey(folder, name, pulses):
    path = pathlib.Path(folder) / name
    path.write_text(f"""format = 1
material = [{{ name = "soil", reflectance = 0.30 }}]
plane = [{{ material = "soil", size_m = [400.0, 400.0] }}]
atmosphere = {{ model = "none" }}
[[lidar]]
name = "survey"
position_m = [0.0, 0.0, 500.0]
prf_khz = 10.0
pulses = {pulses}
""" + pulse_and_receiver("20e-6", divergence_mrad=0.5, fov_mrad=1.0) + gate(490.0, 520.0))
    return path


def files(folder):
    return sorted(path for path in pathlib.Path(folder).rglob("*") if not path.is_dir())


def stopped(arguments, status, says, **more):
    """A run that ends with one error line and leaves no file, hidden or not."""
    done = patience.run([program.path, *arguments], capture_output=True, text=True, **more)
    errors = [line for line in done.stderr.splitlines() if line.startswith("raycube: error: ")]
    check(done.returncode == status and len(errors) == 1, done)
    for part in says:
        check(part in done.stderr, part, done.stderr)


def begun(file, out):
    """A survey that has begun to write and would go on for long, halted."""
    return program.mid_write((out, "**/.*"), "render", file, "-o", out, "-q")


def full_disk():
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (WRITES, WRITES))


with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    small, long = survey(work, "small.toml", 40), survey(work, "long.toml", 3_000_000)
    run("render", small, "-o", work / "good")
    good = {path.relative_to(work / "good") for path in files(work / "good")}
    digest = record(work / "good" / "survey")["digest"]
    # The full disk.
    stopped(
        ["render", survey(work, "more.toml", 60000), "-o", work / "full"],
        3,
        ["File too large", "file-size limit"],
        preexec_fn=full_disk,
    )
    check(files(work / "full") == [] if (work / "full").exists() else True, files(work))
    stopped(["render", small, "-o", "/proc/raycube-out"], 3, ["/proc/raycube-out", "-o"])
    stopped(["render", small, "-o", work / "good"], 2, ["is there already", "--overwrite"])

    for number in (signal.SIGINT, signal.SIGTERM):
        process = begun(long, work / "long")
        if number == signal.SIGINT:
            refused(
                "render", small, "-o", work / "long", status=3, says=["another run is writing", "choose another -o"]
            )
        out, err = patience.signalled(process, number)
        check(
            process.returncode == 130 and err.count("error: ") == 1 and "interrupted" in err,
            process.returncode,
            out,
            err,
        )
        check(files(work / "long") == [], files(work / "long"))

    process = begun(long, work / "long")
    process.kill()
    patience.end_of(process)
    check(all(path.name.startswith(".") for path in files(work / "long")), files(work / "long"))
    run("render", small, "-o", work / "long")
    check({path.relative_to(work / "long") for path in files(work / "long")} == good)
    check(record(work / "long" / "survey")["digest"] == digest)

    # A device of 256 MB (with --full): what fits is computed, a scene that does not is refused before it is copied.
    # oclgrind's kernels have no prefetch, and it runs no program with sanitizers.
    if FULL and shutil.which("oclgrind") and "RAYCUBE_SANITIZED" not in os.environ:
        limited = ["oclgrind", "--global-mem-size", str(256 << 20), "--build-options", "-DRC_NO_PREFETCH", program.path]
        listed = json.loads(patience.run([*limited, "devices", "--json"], capture_output=True, text=True).stdout)
        check(str(256 << 20) in json.dumps(listed), listed)
        tiny = scene(work, "tiny.toml", pixels=4, lines=2, grid=1)
        done = patience.run([*limited, "render", tiny, "-o", work / "limited", "-q"], capture_output=True, text=True)
        check(done.returncode == 0, done.stderr[:2000])
    elif FULL:
        print(
            "stability machine: SKIPPED the device of 256 MB: oclgrind is not there, or the program carries sanitizers",
            flush=True,
        )
print(f"stability machine: {program.checks} checks")

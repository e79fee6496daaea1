#!/usr/bin/env python3
"""ci/soak says "passed" only of runs that passed: a test that fails, one that hangs and a worker that somebody kills
end it with status 1. usage: soak_test.py SOURCE_DIR"""

import os
import pathlib
import shutil
import sys
import tempfile

import patience

checks = 0

# What the kernel does when memory is short: the shell that runs this test is gone, and nobody says anything.
KILLS_ITS_WORKER = """pid=$PPID
while [ "$pid" -gt 1 ] && ! tr '\\0' ' ' <"/proc/$pid/cmdline" | grep -q '^xargs '; do
  worker=$pid; pid=$(awk '{print $4}' "/proc/$pid/stat")
done
kill -9 "$worker"
"""


def soak(source, test, *arguments, status, says, patience_s=patience.LIMIT_S):
    """ci/soak in a tree of its own, where tests/test_render_x is the script `test`."""
    global checks
    with tempfile.TemporaryDirectory() as tree:
        tree = pathlib.Path(tree)
        (tree / "ci").mkdir()
        (tree / "build/tests").mkdir(parents=True)
        shutil.copy(source / "ci/soak", tree / "ci/soak")
        program = tree / "build/tests/test_render_x"
        program.write_text("#!/bin/bash\n" + test)
        program.chmod(0o755)
        done = patience.run(
            [tree / "ci/soak", *arguments, "render_x"],
            capture_output=True,
            text=True,
            env={**os.environ, "RAYCUBE_SOAK_PATIENCE_S": f"{patience_s:.0f}"},
        )
    checks += 1
    assert done.returncode == status and says in done.stdout + done.stderr, (test, done)
    assert status == 0 or "tests passed" not in done.stdout, done


source = pathlib.Path(sys.argv[1])
soak(source, "exit 0\n", "--runs", "8", status=0, says="8 runs of 1 tests passed")
soak(source, "exit 77\n", "--runs", "3", status=1, says="3 runs were skipped and show nothing (0 passed): render_x")
soak(source, "exit 0\n", "--runs", "1", "--seconds", "3600", status=0, says="1 runs of 1 tests passed")
soak(source, "echo it failed; exit 5\n", "--runs", "8", status=1, says="FAILED with status 5")
soak(source, "exec sleep 3600\n", "--runs", "2", status=1, says="FAILED with status 124", patience_s=2)
for more in ((), ("--seconds", "3600")):
    soak(source, KILLS_ITS_WORKER, "--runs", "4", *more, status=1, says="were ended without a word")
print(f"soak: {checks} checks")

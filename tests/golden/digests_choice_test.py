#!/usr/bin/env python3
"""Which record digests_test.py holds a device to, and that it never skips: on processors that this machine need not be.
The program is a stand-in that answers as PoCL on such a processor and "renders" a file of its scene's text.
usage: digests_choice_test.py DIGESTS_TEST"""

import os
import pathlib
import subprocess
import sys
import tempfile

STAND_IN = """#!/bin/sh
rank() { case "$1" in sse2) echo 1;; avx) echo 2;; avx2) echo 3;; avx512) echo 4;; *) echo 9;; esac; }
form=$STAND_IN_BEST
[ "$(rank "${POCL_KERNELLIB_NAME:-none}")" -le "$(rank "$form")" ] && form=$POCL_KERNELLIB_NAME
case "$1" in
devices)
  case "$form" in
  sse2) name=athlon64;; avx) name=sandybridge;; avx2) name=haswell;; avx512) name=skylake-avx512;;
  esac
  platform="Portable Computing Language" cpu=true version="OpenCL 3.0 PoCL HSTR: pthread-x86_64-pc-linux-gnu-$name"
  [ "$STAND_IN_BEST" = gpu ] && name=gpu platform=CUDA cpu=false version="OpenCL 3.0"
  printf '{"devices": [{"number": 0, "driver": "1", "name": "%s", "platform": "%s", "cpu": %s, "version": "%s"}]}\\n' \
    "$name" "$platform" "$cpu" "$version";;
--version) echo "raycube 0.1.0 (commit 0; GNU 12.2.0, Release)";;
new) mkdir "$2"; cd "$2"; touch tree.obj trees.csv grass.csv leaf.csv;;
render)
  mkdir -p "$4/camera"
  { cat "$2"
    case " $* $form " in *" $STAND_IN_FAULT "*) echo fault;; esac
  } > "$4/camera/cube.img"
  touch "$4/camera/run.json";;
esac
"""


def run(work, best, *options, fault="none", status=0):
    """Last lines of the test on a device whose best instruction set is `best`."""
    done = subprocess.run(
        [sys.executable, sys.argv[1], work / "raycube", work / "records", *options],
        env={**os.environ, "STAND_IN_BEST": best, "STAND_IN_FAULT": fault},
        capture_output=True,
        text=True,
    )
    assert done.returncode == status, (best, options, done.returncode, done.stdout, done.stderr)
    return [line for line in done.stdout.splitlines() if not line.endswith(" s")]


def says(lines, *parts):
    """One line for each part, which it begins with or has in it, and no other line."""
    assert len(lines) == len(parts) and all(part in line for part, line in zip(parts, lines)), (lines, parts)


with tempfile.TemporaryDirectory() as folder:
    work = pathlib.Path(folder)
    (work / "raycube").write_text(STAND_IN)
    (work / "raycube").chmod(0o755)
    (work / "records").mkdir()
    avx2 = work / "records" / "avx2.csv"
    for best, ways in (
        ("avx2", "small tiles, one thread, vectors of sse2: 0 differ"),
        ("sse2", "small tiles, one thread: 0 differ"),
        ("gpu", "small tiles: 0 differ"),
    ):
        says(run(work, best), ways)  # no record at all
    faulty = run(work, "sse2", fault="--threads", status=1)
    assert "(one thread)" in faulty[0] and "no record for sse2" in faulty[-1], faulty
    says(run(work, "avx512", "--set", "avx2", "--write"), "written to")
    assert avx2.read_text().startswith("# avx2: kernels that PoCL compiles for haswell\n# PoCL 1, LLVM "), avx2
    says(run(work, "avx2"), ", 0 moved (haswell)")
    says(run(work, "avx512"), ", 0 moved (haswell)", ", 0 moved (skylake-avx512)")
    says(run(work, "avx"), "no record for avx, which")
    faulty = run(work, "avx512", fault="avx512", status=1)
    assert "products of avx512 are not as those of avx2, which" in faulty[-1], faulty
    assert "(vectors of avx2)" in faulty[-2], faulty
    says(run(work, "avx512", "--write"), "written to")
    says(run(work, "avx512"), ", 0 moved (haswell)", ", 0 moved (skylake-avx512)")
    says(run(work, "avx2", "--within"), "as --within asks")
    says(run(work, "gpu", "--set", "avx2"), "no record for a device that is no x86-64 processor")
    lines = avx2.read_text().splitlines(keepends=True)
    lines[1] = "# PoCL 0, LLVM 0, glibc 0, compiler GNU 0\n"
    lines[3] = lines[3][:-9] + "00000000\n"
    avx2.write_text("".join(lines))
    says(
        run(work, "avx2", status=1),
        "moved, or not in both: grid: cube.img",
        "recorded with PoCL 0, LLVM 0, glibc 0, compiler GNU 0; here PoCL 1",
        "1 moved",
    )
print("digests_choice: passed")

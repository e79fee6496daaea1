#!/usr/bin/env python3
"""S62: peak memory of a whole `raycube render` grows neither with the samples of a pixel nor with the lines of the
image.
Figure: VmHWM of the process, as run.json states it and as the kernel says it of the finished child; a run on one thread
and one heap (peak_memory.py), which differ by 0.2 MiB: a twentieth of the least bound.
Bounds. Samples: a bit for each sample more, 8.7 MiB here; nine counts from 16 to 3844 came to between 187.6 and 191.6
MiB (and once 193.3) without a trend, as each count is a program of its own whose code differs. Lines: 4 MiB, 9 bytes
for each pixel more.
The PNG quicklook alone keeps up to 2^20 pixels: 18 bytes of sums and counts, 7 while it is written; it is switched off
where lines are compared, and bounded apart.
usage: render_memory_test.py RAYCUBE [--full]. With --full the median of three runs, and samples under 2 GiB too."""

import pathlib
import sys
import tempfile

import peak_memory
from driver import FULL, Program, record, scene

program = Program(sys.argv[1])
check = program.check
MIB = 1 << 20
BOUND = 4 * MIB


def peak(work, name, memory, **what):
    path = scene(work, name + ".toml", air='{ model = "clear_sky", aod_550 = 0.2 }', **what)
    out = work / name
    command = [program.path, "render", path, "-o", out, "-q", "--overwrite", "--memory", memory, "--threads", 1]

    def as_stated(found):  # the end of the run comes after the record
        stated = record(out / "camera")["memory"]["peak_bytes"]
        check(abs(found - stated) < 2 * MIB, found, stated)

    found = peak_memory.typical(command, as_stated, runs=3 if FULL else 1)
    print(f"{name}: peak {found / MIB:.1f} MiB under --memory {memory}", flush=True)
    return found


with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    for memory in ("48M", "2G") if FULL else ("48M",):
        few = peak(work, f"samples-16-{memory}", memory, pixels=320, lines=240, grid=4)
        many = peak(work, f"samples-961-{memory}", memory, pixels=320, lines=240, grid=31)
        bit_a_sample = 320 * 240 * (961 - 16) // 8
        print(f"961 samples against 16: {(many - few) / MIB:+.1f} MiB")
        check(many < few + bit_a_sample, few, many)
    plain = "png = false\n"
    short = peak(work, "lines-250", "48M", pixels=256, lines=250, grid=4, instrument=plain)
    long = peak(work, "lines-2000", "48M", pixels=256, lines=2000, grid=4, instrument=plain)
    print(f"8 times the lines: {(long - short) / MIB:+.1f} MiB")
    check(long < short + BOUND, short, long)
    pictured = peak(work, "lines-2000-png", "48M", pixels=256, lines=2000, grid=4)
    print(f"with the quicklook: {(pictured - long) / MIB:+.1f} MiB")
    check(pictured < long + BOUND + 25 * 256 * 2000, long, pictured)
print(f"render_memory: {program.checks} checks passed")

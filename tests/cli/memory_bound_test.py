#!/usr/bin/env python3
"""--memory: what it bounds is kept, what it cannot keep is refused with the least that works, and no file depends on
it. usage: memory_bound_test.py RAYCUBE [--full]. With --full peaks are medians of three runs."""

import pathlib
import sys
import tempfile

import peak_memory
from driver import FULL, PULSE_AND_RECEIVER, Program, record, scene

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused
MIB = 1 << 20


def files(folder):
    """Content of every file but the record, which says the budget and the time, and without the day of writing of LAS
    files: midnight may come between two runs."""
    found = {path.name: path.read_bytes() for path in pathlib.Path(folder).iterdir() if path.name != "run.json"}
    return {name: raw[:90] + raw[94:] if name.endswith(".las") else raw for name, raw in found.items()}


def peak_bytes(file, out, memory):
    command = [program.path, "render", file, "-o", out, "-q", "--overwrite", "--memory", memory, "--threads", 1]
    return peak_memory.typical(command, runs=3 if FULL else 1)


def least(file, out):
    done = refused(
        "render", file, "-o", out, "--memory", "4K", status=2, says=["--memory is too small for ", "raise --memory"]
    )
    need = int(done.stderr.split("need ")[1].split(" bytes")[0])
    refused(
        "render",
        file,
        "-o",
        out,
        "--memory",
        str(need - 1),
        "--dry-run",
        status=2,
        says=[f"need {need} bytes, found {need - 1}"],
    )
    refused(
        "render", file, "-o", out, "--memory", str(need - 1), status=2, says=[f"need {need} bytes, found {need - 1}"]
    )
    check(not pathlib.Path(out).exists())
    return need


with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    # Strips of many lines, of few, and parts of lines: every product, byte for byte.
    more = 'standard_error = "bands"\n'
    file = scene(work, "a.toml", pixels=301, lines=83, grid=4, instrument=more)
    need = least(file, work / "least")
    outputs = []
    for memory in (need, 2 * need, "24M", "2G"):
        run("render", file, "-o", work / "a", "--overwrite", "--memory", str(memory))
        outputs.append(files(work / "a/camera"))
        check(outputs[-1].keys() == outputs[0].keys() >= {"preview.exr", "quicklook.png", "standard_error.img"})
        for name, content in outputs[-1].items():
            check(content == outputs[0][name], name, memory)
    check(len({record(work / "a/camera")["rows"]["tile_lines"]}) == 1)

    # A line too wide for its strips is refused by what it needs, not rendered beyond the bound.
    wide = scene(work, "wide.toml", pixels=60000, lines=1, grid=1)
    done = refused(
        "render",
        wide,
        "-o",
        work / "w",
        "--memory",
        "1M",
        status=2,
        says=["--memory is too small for the strips of one line"],
    )

    # The bound is kept: what a large image takes beyond a tiny one is within it, and 32 MiB for buffers of writers and
    # what malloc leaves: 2, 6 and 13 MiB were found, and runs of one budget differ by up to 3.4, a fifth of the rest.
    tiny = peak_bytes(scene(work, "tiny.toml", grid=4, instrument="png = false\nexr = false\n"), work / "t", "2G")
    print(f"the program alone: {tiny / MIB:.0f} MiB")
    large = scene(work, "large.toml", pixels=600, lines=600, grid=4, instrument="png = false\nexr = false\n")
    for memory in (6, 24, 96):
        peak = peak_bytes(large, work / "l", memory * MIB)
        print(f"--memory {memory}M: {(peak - tiny) / MIB:+.1f} MiB beyond it")
        check(peak - tiny < (memory + 32) * MIB, memory, peak, tiny)

    # LIDARs: the same files, and one pulse's rows are the least.
    lidar = work / "als.toml"
    lidar.write_text(
        file.read_text().split("[[instrument]]")[0]
        + '[[lidar]]\nname = "als"\naltitude_agl_m = 600.0\nprf_khz = 10.0\npulses = 300\n'
        + PULSE_AND_RECEIVER
        + "[lidar.sampling]\nsubrays = 4\n[lidar.gate]\nstart_range_m = 585.0\nbins = 400\n[lidar.products]\n"
        "png = false\n"
    )
    outputs = []
    for memory in ("1M", "2G"):
        run("render", lidar, "-o", work / "lidar", "--overwrite", "--memory", memory)
        outputs.append(files(work / "lidar/als"))
    check(outputs[0] == outputs[1], [name for name in outputs[0] if outputs[0][name] != outputs[1].get(name)])
    done = refused("render", lidar, "-o", work / "few", "--memory", "4K", status=2, says=["--memory"])
print(f"memory bound: {program.checks} checks")

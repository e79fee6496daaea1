#!/usr/bin/python3
"""raycube tune: sizes are found, kept for the device, used from then on, and change no bit of a cube or of pulses.
usage: tune_cli_test.py RAYCUBE"""
import json
import os
import pathlib
import sys
import tempfile

from driver import Program, record, scene

program = Program(sys.argv[1])
check = program.check
KERNELS = {"trace_primary", "make_surface", "trace_light", "shade", "resolve", "integrate_bands"}

with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    os.environ["XDG_CACHE_HOME"] = str(work / "cache")
    file = scene(work, "camera.toml", pixels=40, grid=8)
    program.run("render", file, "-o", work / "before", "-q")
    before = record(work / "before/camera")
    check(before["launches"]["tuned"] is False and before["launches"]["local_size_of"] == {}, before["launches"])

    found = json.loads(program.run("tune", file, "--json").stdout)
    kept = pathlib.Path(found["file"])
    check(kept.is_relative_to(work / "cache") and kept.exists(), kept)
    (instrument,) = found["instruments"]
    check(set(instrument["kernels"]) == KERNELS, instrument["kernels"].keys())
    for kernel, choice in instrument["kernels"].items():
        check([c["local_size"] for c in choice["candidates"]] == [1, 2, 4, 8, 16, 32, 64, 128, 256], kernel)
        best = {c["local_size"]: c["seconds"] for c in choice["candidates"]}
        check(choice["seconds"] == best[choice["local_size"]] <= choice["seconds_of_the_preset"], kernel, choice)
    check(2097152 in [c["samples"] for c in instrument["tile"]["candidates"]], instrument["tile"])

    program.run("render", file, "-o", work / "after", "-q")
    after = record(work / "after/camera")
    check(after["launches"]["tuned"] is True, after["launches"])
    check(after["launches"]["local_size_of"] == {k: c["local_size"] for k, c in instrument["kernels"].items()}, after["launches"])
    check(after["launches"]["tile_samples"] == instrument["tile"]["samples"], after["launches"])
    check(after["digest"] == before["digest"], after["digest"])

    # Sizes no clock chose: the same bits, and they are what was launched.
    sizes = json.loads(kept.read_text())
    sizes["local"], sizes["tile_samples"] = {kernel: 3 + i for i, kernel in enumerate(sorted(KERNELS))}, 64 * 40 * 7
    kept.write_text(json.dumps(sizes))
    program.run("render", file, "-o", work / "odd", "-q")
    odd = record(work / "odd/camera")
    check(odd["launches"]["local_size_of"] == sizes["local"] and odd["rows"]["tile_lines"] == 7, odd["launches"], odd["rows"])
    check(odd["digest"] == before["digest"], odd["digest"])
    # One thread is another device: nothing was found for it.
    program.run("render", file, "-o", work / "one", "-q", "--threads", "1")
    check(record(work / "one/camera")["launches"]["tuned"] is False)

    text = program.run("tune", file).stdout
    check(all(kernel in text for kernel in KERNELS) and str(kept) in text, text)
    check("no instrument" in program.run("tune", file, "--instrument", "nosuch", status=2).stderr)
print(f"{program.checks} checks hold")

#!/usr/bin/python3
"""raycube tune: sizes are found, kept for the device, used from then on, and change no bit of a cube or of pulses; no
place to keep them is one error. usage: tune_cli_test.py RAYCUBE"""

import json
import os
import pathlib
import sys
import tempfile

from driver import PULSE_AND_RECEIVER, Program, gate, record, scene

program = Program(sys.argv[1])
check = program.check
KERNELS = {"trace_primary", "make_surface", "trace_sun", "shade", "resolve", "integrate_bands"}

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
        most = (
            120 if kernel in ("trace_primary", "make_surface", "trace_sun") else 480
        )  # groups of four pixels, pixels
        check(
            [c["local_size"] for c in choice["candidates"]]
            == [size for size in (1, 2, 4, 8, 16, 32, 64, 128, 256) if size <= most],
            kernel,
        )
        best = {c["local_size"]: c["seconds"] for c in choice["candidates"]}
        check(choice["seconds"] == best[choice["local_size"]] <= choice["seconds_of_the_preset"], kernel, choice)
    check(524288 in [c["samples"] for c in instrument["tile"]["candidates"]], instrument["tile"])

    program.run("render", file, "-o", work / "after", "-q")
    after = record(work / "after/camera")
    check(after["launches"]["tuned"] is True, after["launches"])
    check(
        after["launches"]["local_size_of"] == {k: c["local_size"] for k, c in instrument["kernels"].items()},
        after["launches"],
    )
    check(after["launches"]["tile_samples"] == instrument["tile"]["samples"], after["launches"])
    check(after["digest"] == before["digest"], after["digest"])

    # Sizes no clock chose: the same bits, and they are what was launched.
    sizes = json.loads(kept.read_text())
    sizes["local"], sizes["tile_samples"] = {kernel: 3 + i for i, kernel in enumerate(sorted(KERNELS))}, 64 * 40 * 7
    kept.write_text(json.dumps(sizes))
    program.run("render", file, "-o", work / "odd", "-q")
    odd = record(work / "odd/camera")
    check(
        odd["launches"]["local_size_of"] == sizes["local"] and odd["rows"]["tile_lines"] == 7,
        odd["launches"],
        odd["rows"],
    )
    check(odd["digest"] == before["digest"], odd["digest"])
    # One thread of several is another device: nothing was found for it.
    if json.loads(program.run("devices", "--json").stdout)["devices"][0]["compute_units"] > 1:
        program.run("render", file, "-o", work / "one", "-q", "--threads", "1")
        check(record(work / "one/camera")["launches"]["tuned"] is False)

    pulses = work / "pulses.toml"
    pulses.write_text(
        file.read_text().partition("[[instrument]]")[0].replace('{ model = "none" }', '{ model = "layered" }') + """
[[lidar]]
name = "profiler"
position_m = [0.0, 0.0, 500.0]
prf_khz = 200.0
pulses = 50
products = { png = false }
""" + PULSE_AND_RECEIVER + gate(450.0, 520.0)
    )
    program.run("render", pulses, "-o", work / "before", "-q", env={"XDG_CACHE_HOME": str(work / "other")})
    text = program.run("tune", pulses).stdout
    check(all(kernel in text for kernel in ("lidar_shots", "lidar_air", "lidar_beam")) and str(kept) in text, text)
    both = json.loads(kept.read_text())["local"]
    check(set(both) == KERNELS | {"lidar_shots", "lidar_air", "lidar_beam"}, both)
    kept.write_text(
        json.dumps({"local": {"lidar_shots": 7, "lidar_air": 16, "lidar_beam": 3}, "tile_samples": 1 << 20})
    )
    program.run("render", pulses, "-o", work / "after", "-q", "--overwrite")
    one, two = record(work / "before/profiler"), record(work / "after/profiler")
    check(two["launches"]["local_size_of"]["lidar_air"] == 16 and not one["launches"]["tuned"], two["launches"])
    check(one["digest"] == two["digest"], one["digest"], two["digest"])

    program.refused("tune", file, "--instrument", "nosuch", status=2, says=["no instrument"])
    (work / "file").write_text("")
    program.refused(
        "tune",
        file,
        status=3,
        says=["could not be kept", "XDG_CACHE_HOME"],
        env={"XDG_CACHE_HOME": str(work / "file"), "POCL_CACHE_DIR": str(work / "pocl")},
    )
print(f"{program.checks} checks hold")

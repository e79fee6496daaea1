"""S20 S18: a long `atmos build` that is stopped leaves nothing behind; a damaged cache is built anew; what help says;
what a plot holds. Usage: atmos_build_test.py RAYCUBE"""

import json
import os
import pathlib
import pty
import re
import signal
import subprocess
import sys
import tempfile

import patience
from driver import Program

program = Program(sys.argv[1])


def mid_build(table, env):
    """A build of a minute that has told on its terminal of some wavelengths that are done, halted there."""
    command = ["atmos", "build", "--model", "layered", "--sun-zenith", "50", "--threads", "1", "-o", table]
    terminal, its_end = pty.openpty()
    started = subprocess.Popen(
        [program.path, *command], stdout=subprocess.DEVNULL, stderr=its_end, env={**os.environ, **env}
    )
    os.close(its_end)
    os.set_blocking(terminal, False)
    shown = b""

    def some_are_done():
        nonlocal shown
        try:
            shown += os.read(terminal, 1 << 16)
        except OSError:  # nothing new, or ended
            pass
        return re.search(rb"[1-9]\d*/\d+ wavelengths", shown)

    patience.until(some_are_done, "the first wavelengths of a table", started)
    return patience.halted(started)


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    cache = folder / "cache"
    env = {"XDG_CACHE_HOME": str(cache)}
    kept = cache / "raycube" / "atmosphere"

    def build(file, *options, **more):
        return program.run(
            "atmos", "build", "--model", "layered", "--sun-zenith", "50", "-o", folder / file, *options, env=env, **more
        )

    # Stopped in the middle, by Ctrl-C and by a signal no program can see: no table, no cached file, and the next run
    # works.
    for how, status in ((signal.SIGINT, 130), (signal.SIGKILL, -9)):
        started = mid_build(folder / "long.rct", env)
        patience.signalled(started, how)
        program.check(started.returncode == status, started.returncode)
        program.check([path.name for path in folder.iterdir() if path != cache] == [], list(folder.iterdir()))
        program.check(not list(cache.rglob("*.rct")), list(cache.rglob("*")))

    # A table of two wavelengths, twice: the second time from the cache, byte for byte.
    small = ("--from", "3.9", "--to", "4.0", "--step", "100", "--highest", "0")
    build("one.rct", *small)
    files = list(kept.glob("*.rct"))
    program.check(len(files) == 1, files)
    said = build("two.rct", *small, "-v").stderr
    program.check("table from the cache" in said, said)
    table = (folder / "one.rct").read_bytes()
    program.check(table == (folder / "two.rct").read_bytes() == files[0].read_bytes())

    # Damaged in the middle, cut short, empty: a warning, built anew, and whole again in the cache.
    for damage in (lambda b: b[:5000] + bytes([b[5000] ^ 1]) + b[5001:], lambda b: b[: len(b) // 2], lambda b: b""):
        files[0].write_bytes(damage(table))
        said = build("again.rct", *small, "--overwrite").stderr
        program.check("warning" in said and files[0].name in said and "built anew" in said, said)
        program.check((folder / "again.rct").read_bytes() == table == files[0].read_bytes())
    program.check(sorted(path.name for path in kept.iterdir()) == [files[0].name])

    # A name that is taken is known before the work, not after it.
    said = build("one.rct", "--from", "0.4", "--to", "2.4", status=2).stderr
    program.check("one.rct" in said and "wavelengths" not in said, said)

    # What a table of both sources draws.
    program.run("atmos", "plot", folder / "one.rct", "-o", folder / "one.png")
    drawn = json.loads((folder / "one.json").read_text())
    for figure in (
        "sun_transmission",
        "view_transmission",
        "two_way_transmission",
        "two_way_factor",
        "two_way_factor_thermal",
        "path_radiance",
        "path_radiance_thermal",
        "sky_up",
        "sky_slant",
        "thermal_sky_up",
        "thermal_sky_slant",
        "spherical_albedo",
        "diffuse_view_transmission",
        "diffuse_return_up",
        "direct_irradiance",
        "diffuse_irradiance",
    ):
        program.check(len(drawn[figure]) == len(drawn["wavelength_um"]) == 2, figure)
    sky = drawn["sky"]
    program.check(50.0 in sky["zenith_deg"] and 0.5 in sky["azimuth_deg"])  # fine around the sun
    at_sun = sky["radiance"][sky["zenith_deg"].index(50.0)][0]
    program.check(at_sun == max(max(ring) for ring in sky["radiance"]))
    thermal = drawn["thermal_sky"]["curves"][0]
    program.check(
        thermal["wavelength_um"] == 4.0 and thermal["radiance"] == sorted(thermal["radiance"])
    )  # brighter towards the horizon

    help_text = program.run("atmos", "build", "--help").stdout
    for option in (
        "--model",
        "--profile",
        "--aerosol",
        "--visibility",
        "--aod",
        "--water",
        "--sun-zenith",
        "--sensor-height",
        "--from",
        "--to",
        "--step",
        "--lowest",
        "--highest",
        "--no-cache",
        "--threads",
        "-o",
    ):
        program.check(option in help_text, option)
    for word in ("um", "deg", "default"):
        program.check(word in help_text, word)
print(f"atmos build: ok, {program.checks} checks")

#!/usr/bin/env python3
"""Inputs that hang, crash or bloat whoever reads them without care: pipes, devices and folders in place of files,
headers cut in a word, keys of tens of thousands of parts, images of 1e10 pixels. One clear error each, in little
memory; Ctrl-C is heard. usage: input_limits_test.py RAYCUBE"""

import os
import pathlib
import resource
import shutil
import signal
import sys
import tempfile
import time

import patience
from driver import PULSE_AND_RECEIVER, Program, scene

program = Program(sys.argv[1])
check = program.check
# 2 GB beyond the stacks of threads, one for each processor of the machine and for each of the OpenCL driver's.
kMemory_bytes = (2 << 30) + 2 * os.cpu_count() * (8 << 20)
kPlane = "plane = ["
kGas = (
    'volume = [{ kind = "grid", values = "X", cell_m = [1.0, 1.0, 1.0], cells = [2, 2, 2], species = "particles" }]\n'
    + kPlane
)

# Key of the simulation file: what to replace in the small scene, by what. X is the path under test.
kKeys = {
    "scene.include": (kPlane, 'scene = { include = ["X"] }\n' + kPlane),
    "material.file": ('reflectance = 0.10', 'file = "X"'),
    "mesh.file obj": (
        kPlane,
        'mesh = [{ name = "m", file = "X.obj", material = "dark" }]\ninstance = [{ mesh = "m" }]\n' + kPlane,
    ),
    "mesh.file ply": (
        kPlane,
        'mesh = [{ name = "m", file = "X.ply", material = "dark" }]\ninstance = [{ mesh = "m" }]\n' + kPlane,
    ),
    "terrain.raster": (kPlane, 'terrain = [{ raster = "X", material = "dark" }]\n' + kPlane),
    "atmosphere.tables": ('{ model = "none" }', '{ tables = "X" }'),
    "atmosphere.profile_file": ('{ model = "none" }', '{ model = "layered", profile_file = "X" }'),
    "atmosphere.lines": ('{ model = "none" }', '{ model = "layered", lines = "X" }'),
    "instrument.poses": ("altitude_agl_m = 500.0", 'poses = "X"'),
    "instrument.bands": ("bands = { first_nm = 450.0, step_nm = 50.0, count = 10, fwhm_nm = 20.0 }", 'bands = "X"'),
}


def kinds(work):
    """A path of every kind that is no plain file, with an ending; opening the pipe would wait for ever, reading the
    device never ends."""
    for ending in ("", ".obj", ".ply", ".rct", ".toml", ".json", ".hdr", ".las", ".rcs"):
        os.mkfifo(work / f"pipe{ending}")
        (work / f"zero{ending}").symlink_to("/dev/zero")
        (work / f"folder{ending}").mkdir()
    return {"pipe": "is a pipe", "zero": "is a device", "folder": "is a folder"}


def limited(*arguments, status, says):
    """One error, and that in little memory that can be written: what libraries map to read does not count, nor do the
    heaps that malloc sets up for each thread."""
    done = program.run(
        *arguments,
        status=status,
        env={"MALLOC_ARENA_MAX": "1"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_DATA, (kMemory_bytes, kMemory_bytes)),
    )
    errors = [line for line in done.stderr.splitlines() if line.startswith("raycube: error: ")]
    check(len(errors) == 1 and done.stdout == "", arguments, done.stderr)
    check(any(part in done.stderr for part in ([says] if isinstance(says, str) else says)), says, done.stderr)


kGltf = """{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "buffers": [{"uri": "special.bin", "byteLength": 36}],
"bufferViews": [{"buffer": 0, "byteLength": 36}], "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3,
"type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}]}"""
kGrid = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 1\n1 1\n"
kVrt = (
    '<VRTDataset rasterXSize="2" rasterYSize="2"><VRTRasterBand dataType="Float32" band="1"><SimpleSource>'
    '<SourceFilename relativeToVRT="1">{}</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand>'
    "</VRTDataset>"
)


def named_in_files(work, small):
    """Pipes and devices that other files name, or that libraries look for beside them."""
    for make, word in ((os.mkfifo, "is a pipe"), (lambda path: path.symlink_to("/dev/zero"), "is a device")):
        folder = pathlib.Path(tempfile.mkdtemp(dir=work))
        for name in ("special.mtl", "special.bin", "beside.prj", "special.tif", "run.json", "special"):
            make(folder / name)
        (folder / "a.obj").write_text("mtllib special.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl k\nf 1 2 3\n")
        (folder / "b.gltf").write_text(kGltf)
        (folder / "beside.asc").write_text(kGrid)
        (folder / "c.vrt").write_text(kVrt.format("special.tif"))
        (folder / "d.vrt").write_text(kVrt.format("c.vrt"))
        (folder / "e.vrt").write_text(kVrt.format("beside.asc"))
        for key, text, names in (
            ("mesh.file obj", "a.obj", "special.mtl"),
            ("mesh.file obj", "b.gltf", "special.bin"),
            ("terrain.raster", "beside.asc", "beside.prj"),
            ("terrain.raster", "c.vrt", "special.tif"),
            ("terrain.raster", "d.vrt", "special.tif"),
            ("terrain.raster", "e.vrt", "beside.prj"),
        ):
            old, new = kKeys[key]
            (folder / "scene.toml").write_text(small.replace(old, new.replace("X.obj", text).replace("X", text), 1))
            limited("scene", "check", folder / "scene.toml", status=2, says=f"{names}, which {word}")
        limited("info", folder, status=2, says=f"run.json: {word}")
        limited("info", folder / "a.obj", status=2, says=f"special.mtl, which {word}")
        (folder / "study.toml").write_text(
            'format = 1\ntitle = "t"\n[[step]]\nname = "s"\nrun = ["true"]\ninputs = ["special"]\n'
        )
        limited("experiment", folder / "study.toml", "-o", folder / "out", status=2, says=f"special: {word}")


with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    small = scene(work, "small.toml").read_text()
    (work / "none.par").write_text("")
    for name, word in kinds(work).items():
        for key, (old, new) in kKeys.items():
            check(old in small, old)
            (work / "bad.toml").write_text(small.replace(old, new.replace("X", name), 1))
            limited("scene", "check", work / "bad.toml", status=2, says=word)
        for arguments in (
            ["render", f"{name}.toml"],
            ["render", work / "small.toml", "--plan", f"{name}.json"],
            ["info", f"{name}.rct"],
            ["info", f"{name}.rcs"],
            ["info", f"{name}.json"],
            ["info", f"{name}.hdr"],
            ["info", f"{name}.las"],
            ["atmos", "info", f"{name}.rct"],
            ["atmos", "import", name, "-o", work / "x.rct"],
            ["scene", "info", f"{name}.rcs"],
        ):
            path = [work / part if str(part).startswith(name) else part for part in arguments]
            limited(*path, status=2, says=[word, "without run.json"])
        # Files that options name, before the air is computed and without opening the pipe.
        build, lidar = ("atmos", "build", "--sun-zenith", 40), ("atmos", "lidar", "--wavelengths", 1064)
        path = work / name
        for arguments in (
            (*build, "--profile", path),
            (*build, "--no-cache", "--profile", path),
            (*build, "--lines", path),
            (*lidar, "--profile", path),
            (*lidar, "--lines", path),
            (*lidar, "--cross-section", f"xy={path},1"),
            (*lidar, "--lines", work / "none.par", "--partition-sums", path),
        ):
            limited(*arguments, "-o", work / "x.rct", status=2, says=f"{path}: {word}")
        check(not (work / "x.rct").exists())
    print(f"input limits: {program.checks} checks of what is no file")

    # Headers of PLY cut or lying: seen before Assimp (5.2.5 goes round in a circle).
    whole = (
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    body = "0 0 1\n1 0 1\n1 1 1\n0 1 1\n4 0 1 2 3\n"
    old, new = kKeys["mesh.file ply"]
    (work / "mesh.toml").write_text(small.replace(old, new.replace("X", "m"), 1))
    for text, says in (
        (
            whole[:47],
            (
                "m.ply:4: PLY header has a line that PLY does not know (found 'property floa')"
                if whole[:47].endswith("\n")
                else "PLY header has no end"
            ),
        ),
        (
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty floa",
            "m.ply:3: PLY header has no end (found 51 bytes without end_header)",
        ),
        (
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty floa\n",
            "m.ply:4: PLY header has a line that PLY does not know (found 'property floa')",
        ),
        (
            whole.replace("vertex 4", "vertex 4000000000") + body,
            "m.ply:3: PLY header counts more than the file holds (found 4000000000 of 'vertex' in ",
        ),
        (
            whole.replace("ascii", "binary_little_endian") + "x" * 48,
            "m.ply:7: PLY header counts more than the file holds",
        ),
    ):
        (work / "m.ply").write_text(text)
        limited("scene", "check", work / "mesh.toml", status=2, says=says)
    for cut in range(4, len(whole), 3):
        (work / "m.ply").write_text(whole[:cut])
        limited("scene", "check", work / "mesh.toml", status=2, says="m.ply")
    for end in ("\n", "\r\n"):
        (work / "m.ply").write_bytes((whole + body).replace("\n", end).encode())
        program.run("scene", "check", work / "mesh.toml")
    # A caller that ignores SIGCHLD, which exec keeps.
    program.run("scene", "check", work / "mesh.toml", preexec_fn=lambda: signal.signal(signal.SIGCHLD, signal.SIG_IGN))
    named_in_files(work, small)

    # A raster whose samples come from a pipe, as a VRT allows.
    old, new = kKeys["terrain.raster"]
    (work / "r.vrt").write_text(
        '<VRTDataset rasterXSize="4" rasterYSize="4"><VRTRasterBand dataType="Byte" band="1" '
        'subClass="VRTRawRasterBand">'
        f'<SourceFilename relativeToVRT="1">none</SourceFilename></VRTRasterBand></VRTDataset>'
    )
    (work / "raster.toml").write_text(small.replace(old, new.replace("X", "r.vrt"), 1))
    limited("scene", "check", work / "raster.toml", status=2, says="r.vrt")

    # Keys of many parts, in every way TOML writes them.
    parts = [".".join(["a"] * 40000), " . ".join(['"a"'] * 40000), ".".join(["'a.b'"] * 40000)]
    for text in (
        [f"{part} = 1" for part in parts]
        + [f"[{part}]" for part in parts]
        + [f"[[{parts[0]}]]", f"x = {{ {parts[0]} = 1 }}", f"a.b = 1 # {parts[0]}\n{parts[0]} = 1"]
    ):
        (work / "deep.toml").write_text("format = 1\n" + text + "\n")
        limited(
            "scene",
            "check",
            work / "deep.toml",
            status=2,
            says="key has too many parts (found more than 32 between dots)",
        )
    many_dots = '# ' + parts[0] + '\n'
    (work / "fine.toml").write_text(small.replace("format = 1\n", 'format = 1\n' + many_dots, 1))
    program.run("scene", "check", work / "fine.toml")

    # 1e10 pixels: what it would take is said without a look at each of them, which would take an hour.
    huge = scene(work, "huge.toml", pixels=100000, lines=100000)
    huge.write_text(huge.read_text().replace("gsd_m = 1.0", "gsd_m = 0.005"))
    done = program.run("render", huge, "--dry-run")
    check("100000 x 100000 pixels" in done.stdout, done.stdout)
    # Ctrl-C at any time of it, and after it.
    for wait in (0, 0.2, 0.7, 1.5, 3):
        process = program.start_listening("render", huge, "--dry-run")
        time.sleep(wait)
        process.send_signal(signal.SIGINT)
        out, err = patience.end_of(process)
        check(process.returncode == 130 or (process.returncode == 0 and "pixels" in out), process.returncode, err)
    # A whiskbroom has a pose for each pixel: that many are refused before they are made.
    broom = scene(work, "broom.toml", pixels=100000, lines=100000)
    broom.write_text(broom.read_text().replace('"framing"', '"whiskbroom"').replace("gsd_m = 1.0", "gsd_m = 0.005"))
    limited("scene", "check", broom, status=2, says="instrument needs more than 1e8 poses")
    # An image that no disk holds is refused before a ray of it is looked along, whatever looks.
    for kind in ("framing", "pushbroom"):
        vast = scene(work, "vast.toml", pixels=1000000, lines=10000000)
        vast.write_text(vast.read_text().replace('"framing"', f'"{kind}"').replace("gsd_m = 1.0", "gsd_m = 1e-7"))
        for verb in (("scene", "check"), ("plan",), ("render", "--dry-run")):
            limited(*verb, vast, status=2, says="at most 2^36 pixels")
    # One that is all flat, of a telescope far away, is bounded by a part of its pixels: an hour's walk otherwise.
    flat = scene(work, "flat.toml", pixels=60000, lines=60000)
    flat.write_text(flat.read_text().replace("gsd_m = 1.0", "gsd_m = 1e-6"))
    check("sound" in program.run("scene", "check", flat).stdout)
    shutil.rmtree(work / "folder")
print(f"input limits: {program.checks} checks")

#!/usr/bin/env python3
"""A folder that came from a stranger: none of its files makes raycube run code, use a network, remove files, or print
more lines than it is worth. usage: strangers_test.py RAYCUBE"""

import pathlib
import socket
import sys
import tempfile

from driver import PULSE_AND_RECEIVER, Program, gate

program = Program(sys.argv[1])
run, check = program.run, program.check

LIDAR = (
    """format = 1
[[material]]
name = "ground"
reflectance = 0.3
[[plane]]
material = "ground"
size_m = [200.0, 200.0]
[atmosphere]
model = "none"
[[lidar]]
name = "scan"
position_m = [0.0, 0.0, 500.0]
prf_khz = 10.0
pulses = 4
"""
    + PULSE_AND_RECEIVER
    + gate("400.0", "600.0")
    + """[lidar.products]
laz = true
"""
)


def code(folder):
    """Modules of the names that scripts import, where the program is started and where PYTHONPATH says."""
    trap = "import pathlib\npathlib.Path(__file__).with_name('ran').write_text('')\n"
    for module in ("numpy", "matplotlib", "laspy", "json", "lazrs"):
        (folder / f"{module}.py").write_text(trap)
    (folder / "scene.toml").write_text(LIDAR)
    run("render", "scene.toml", "-o", "out", cwd=folder, env={"PYTHONPATH": str(folder)})
    check((folder / "out/scan/points.png").stat().st_size > 1000)
    check((folder / "out/scan/returns.laz").stat().st_size > 100)
    check(not (folder / "ran").exists(), "a module of the folder was run")


TERRAIN = """format = 1
atmosphere = {{ model = "none" }}
[[material]]
name = "m"
reflectance = 0.5
[[terrain]]
raster = "{raster}"
material = "m"
cell_m = 10.0
"""


def network(folder):
    """Rasters that name an address: nobody calls there."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(0.2)
        address = f"http://127.0.0.1:{server.getsockname()[1]}/dem"
        source = "<SimpleSource><SourceFilename>{}</SourceFilename><SourceBand>1</SourceBand></SimpleSource>"
        head = '<VRTDataset rasterXSize="4" rasterYSize="4"><VRTRasterBand dataType="Float64" band="1">'
        wms = f'<GDAL_WMS><Service name="WMS"><ServerUrl>{address}</ServerUrl></Service></GDAL_WMS>'
        for name, text in (
            ("curl.vrt", head + source.format(f"/vsicurl/{address}.tif") + "</VRTRasterBand></VRTDataset>"),
            ("plain.vrt", head + source.format(f"{address}.tif") + "</VRTRasterBand></VRTDataset>"),
            ("wms.xml", wms),
            ("code.vrt", head.replace("<VRTRasterBand", '<VRTRasterBand subClass="VRTDerivedRasterBand"')
                + "<PixelFunctionLanguage>Python</PixelFunctionLanguage><PixelFunctionType>f</PixelFunctionType>"
                "<PixelFunctionCode>import pathlib\npathlib.Path('ran').write_text('')\ndef f(*a, **k): pass\n"
                "</PixelFunctionCode></VRTRasterBand></VRTDataset>"),
        ):
            (folder / name).write_text(text)
            (folder / "scene.toml").write_text(TERRAIN.format(raster=name))
            done = run("scene", "check", "scene.toml", cwd=folder, status=2)
            check(name in done.stderr, done.stderr)
            done = run("info", name, cwd=folder, status=2)
            try:
                server.accept()
                check(False, name, "was fetched")
            except TimeoutError:
                check(True)
        check(not (folder / "ran").exists(), "code of a raster was run")


def journals(folder):
    """A list of files to name and to remove, as a run that was cut short leaves it: this one came with the folder."""
    (folder / "thesis.txt").write_text("mine")
    (folder / "new").write_text("new")
    (folder / "run.json").write_text("{}")
    journal = folder / ".raycube-publication"
    journal.write_text('{"replace":true,"files":[["new","run.json",3,1,1]],"remove":["thesis.txt"]}')
    journal.chmod(0o600)
    run("info", folder, status=2)
    check((folder / "thesis.txt").read_text() == "mine" and (folder / "run.json").read_text() == "{}")


def lines(folder):
    """Of many errors of a kind 20 are told, and how many more."""
    rows = "".join(f"{300 + i},x{i}\n" for i in range(50000))
    (folder / "spectrum.csv").write_text("wavelength_nm,reflectance\n" + rows)
    (folder / "scene.toml").write_text(
        'format = 1\n[[material]]\nname = "m"\nfile = "spectrum.csv"\n'
        '[[plane]]\nmaterial = "m"\nsize_m = [1.0, 1.0]\n'
    )
    done = run("scene", "check", "scene.toml", cwd=folder, status=2)
    check(len(done.stderr.splitlines()) < 30, len(done.stderr.splitlines()))
    rows = "".join(f"{300 + i},0.5,0.5\n" for i in range(50000))
    (folder / "spectrum.csv").write_text("wavelength_nm,reflectance\n" + rows)
    done = run("scene", "check", "scene.toml", cwd=folder, status=2)
    check(len(done.stderr.splitlines()) < 30, len(done.stderr.splitlines()))


for case in (code, network, journals, lines):
    with tempfile.TemporaryDirectory() as made:
        case(pathlib.Path(made))
print(f"strangers: {program.checks} checks")

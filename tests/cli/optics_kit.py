"""What tests of cameras over level scenes share: panels, cameras, renders."""

from driver import envi

HEAD = """format = 1
bounces = 0
[atmosphere]
model = "none"
[time.sun]
zenith_deg = 30.0
azimuth_deg = 90.0
day_of_year = 180
[[material]]
name = "dark"
reflectance = 0.05
[[material]]
name = "bright"
reflectance = 0.8
[[material]]
name = "grey"
reflectance = 0.4
[[plane]]
material = "dark"
size_m = [400.0, 400.0]
"""


def with_origin(head):
    """On the map: EPSG:32618, its corner at 276 000, 4 753 000."""
    origin = "[scene]\norigin = { epsg = 32618, easting_m = 276000.0, northing_m = 4753000.0, height_m = 100.0 }\n"
    return head.replace("bounces = 0\n", "bounces = 0\n" + origin)


def panel(material, size, place, yaw=0.0):
    return f"""[[plane]]
material = "{material}"
size_m = [{size[0]}, {size[1]}]
position_m = [{place[0]}, {place[1]}, 0.01]
yaw_deg = {yaw}
"""


def camera(name="camera", pixels=64, lines=64, bands="first_nm = 550.0, step_nm = 100.0, count = 1", **more):
    keys = {"kind": '"framing"', "altitude_agl_m": 2000.0, "gsd_m": 1.0, "samples": "{ grid = [8, 8] }"} | more
    text = "\n".join(f"{key} = {value}" for key, value in keys.items())
    return f"""[[instrument]]
name = "{name}"
pixels = {pixels}
lines = {lines}
bands = {{ {bands}, fwhm_nm = 10.0 }}
{text}
"""


def plane(**keys):
    return "[[instrument.focal_plane]]\n" + "".join(f"{key} = {value}\n" for key, value in keys.items())


def render(program, folder, text, *more, name="camera"):
    """[line][sample][band] as doubles, the instrument's folder."""
    (folder / "scene.toml").write_text(text)
    program.run("render", folder / "scene.toml", "-o", folder / "out", "--overwrite", "-q", "-q", *more)
    return envi(folder / "out" / name, "radiance")[1].astype("f8"), folder / "out" / name

"""S60 S61: `raycube check` as users run it: the shipped park with both instruments, what it prints and writes, and how
it fails. usage: check_cli_test.py RAYCUBE PARK [--full], PARK a folder that scenes/park/generate.py wrote
Without --full: fewer rays and pixels, every twelfth of the imager's bands, and the report of what fails once, as text
and file."""

import json
import pathlib
import re
import shutil
import struct
import sys
import tempfile
import zlib

from driver import FULL, Program

program = Program(sys.argv[1])
run, check = program.run, program.check

kCauses = ["agree", "exact_tie", "edge_tie", "depth_tie", "grazing", "unexplained"]


def png(path):
    """Width, height, rows of RGB triples and texts of an 8-bit PNG without filters; reads no library of ours."""
    data, at, body, text = path.read_bytes(), 8, b"", {}
    check(data.startswith(b"\x89PNG\r\n\x1a\n"))
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at : at + 8])
        chunk = data[at + 8 : at + 8 + size]
        check(zlib.crc32(kind + chunk) == struct.unpack(">I", data[at + 8 + size : at + 12 + size])[0], kind)
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", chunk[:10])
            check((depth, colour) == (8, 2))
        elif kind == b"IDAT":
            body += chunk
        elif kind == b"tEXt":
            key, value = chunk.split(b"\0", 1)
            text[key.decode()] = value.decode("latin-1")
        at += 12 + size
    check(len(zlib.decompress(body)) == height * (1 + 3 * width))
    return width, height, text


def check_hits(hits, rays):
    """The classes make up all rays; no ray is unexplained, lost or found against double."""
    check(hits["rays"] == rays == sum(hits[cause] for cause in kCauses), hits)
    check(hits["unexplained"] == hits["hit_against_miss"] == hits["hit_against_miss_in_double"] == 0, hits)
    check(hits["unexplained_rays"] == [] and hits["agree"] > 0.9 * rays, hits)
    explained = rays - hits["agree"]
    check(abs(hits["explained_share"] - explained / rays) < 1e-12)
    check(hits["explained_device_right"] <= explained and hits["explained_embree_right"] <= explained)


def check_report(report, pixels, rays_per_pixel, bands, rays):
    check(report["passed"] is True and report["failures"] == [], report["failures"])
    check(report["pixels"] == pixels and report["rays"] == pixels * rays_per_pixel)
    check(sum(report["hits_" + cause] for cause in kCauses) == report["rays"] and report["hits_unexplained"] == 0)
    check(
        report["sun_unexplained"]
        == report["sky_unexplained"]
        == report["excluded_pixels"]
        == report["beyond_pixels"]
        == 0
    )
    check(report["sun_rays"] > 0.9 * report["rays"] and report["sky_rays"] > 0)
    # DESIGN section 7, in every band
    check(len(report["band_median"]) == len(report["band_rms"]) == len(report["band_max"]) == bands)
    check(max(report["band_median"]) == report["median_worst_band"] < report["median_limit"] == 1e-6)
    check(
        max(report["band_max"])
        == report["worst"]
        == report["band_max"][report["worst_band"]]
        < report["worst_limit"]
        == 2e-5
    )
    check(min(report["band_max"]) > 0)  # float against double: nothing compared would be 0
    check_hits(report["first_hits"], rays)


with tempfile.TemporaryDirectory() as folder:
    work = pathlib.Path(folder)
    shutil.copytree(sys.argv[2], work / "park")
    park = work / "park" / "park.toml"
    # The quick air: 1670 wavelengths of the layered one would take longer than all else here; ci/demo checks the park
    # with it.
    text = re.sub(r'model = "layered"\nprofile = .*', 'model = "clear_sky"', park.read_text())
    text = re.sub(r"tolerance = 0\.03.*", "tolerance = 0.01\nsky_directions = 1936", text)
    for bands, side in (("spectir_360.csv", 11), ("wasp_rgb.csv", 4)):
        text = text.replace(f'bands = "{bands}"', f'samples = {{ grid = [{side}, {side}] }}\nbands = "{bands}"')
    park.write_text(text)
    assert 'model = "clear_sky"' in text and "sky_directions" in text and text.count("samples = {") == 2

    if not FULL:
        bands = (work / "park/spectir_360.csv").read_text().splitlines(keepends=True)
        rows = [line for line in bands if line[0].isdigit()]
        assert len(rows) == 360
        thin = "".join([line for line in bands if not line[0].isdigit()] + rows[5::12])
        (work / "park/spectir_360.csv").write_text(thin)

    # Both instruments of the park: 320 x 320 pixels of 121 rays in 360 bands, 1000 x 1000 of 16 in 3. Groups of 4
    # pixels.
    least, pixels, model_pixels, many = (100000, 12, 4, 360) if FULL else (2000, 4, 2, 30)
    numbers = ("--rays", least, "--pixels", pixels, "--model-pixels", model_pixels)
    done = run("check", park, *numbers, "--json", "-o", work / "out")
    reports = json.loads(done.stdout)
    check(list(reports) == ["spectir", "wasp"], list(reports))
    for name, rays_per_pixel, bands in (("spectir", 121, many), ("wasp", 16, 3)):
        rays = -(-least // (4 * rays_per_pixel)) * 4 * rays_per_pixel
        check_report(reports[name], pixels, rays_per_pixel, bands, rays)
        check(reports[name]["model"]["pixels"] == model_pixels and 0 < reports[name]["model"]["total"]["figure"] < 0.01)
        written = work / "out" / f"{name}_check"
        check({path.name for path in written.iterdir()} == {"check.json", "difference.png"})
        check(json.loads((written / "check.json").read_text()) == reports[name])
        width, height, text = png(written / "difference.png")
        check(width >= bands and height >= pixels, width, height)
        check("relative difference" in text["Description"], text)

    run("new", work / "garden")
    garden = work / "garden" / "garden.toml"

    # Text: the classes by name; other pixels for another seed.
    text = run("check", garden, "--rays", 20000, "--pixels", 4, "--model-pixels", 0).stdout
    check(
        re.search(
            r"^first hits of 20128 rays: agree \d+, exact tie \d+, edge tie \d+, depth tie \d+, grazing \d+, "
            r"unexplained 0; "
            r"share explained [0-9.e-]+ \(double sides with the device in \d+, with Embree in \d+\); hit against miss: "
            r"Embree 0, double 0$",
            text,
            re.MULTILINE,
        ),
        text,
    )
    check("instrument camera on " in text and "model (" not in text and text.endswith("check: within limits\n"), text)
    other = run(
        "check", garden, "--rays", 0, "--pixels", 4, "--model-pixels", 0, "--instrument", "camera", "--seed", 77
    ).stdout
    check("first hits of" not in other and other.endswith("check: within limits\n"), other)

    # Beyond a limit: 4 sky directions cannot hold a tolerance of 0.5 % below trees, where they err by 2 % and more.
    # Status 1, the reason on a line of its own, the files written all the same.
    toml = garden.read_text()
    noisy, changed = re.subn(r"(?m)^sky_directions\s*=.*$", "sky_directions = 4", toml)
    noisy, lower = re.subn(r"(?m)^tolerance\s*=.*$", "tolerance = 0.005", noisy)
    check(changed == lower == 1, toml)
    (work / "garden" / "noisy.toml").write_text(noisy)
    few = ("--rays", 1000, "--pixels", 100, "--model-pixels", 100)
    done = run("check", work / "garden" / "noisy.toml", *few, "-o", work / "bad", status=1)
    check(
        re.search(
            r"^BEYOND LIMITS: the full tables differ by [0-9.e-]+ in band \d+, tolerance 0\.005$",
            done.stdout,
            re.MULTILINE,
        ),
        done.stdout,
    )
    check(done.stdout.endswith("check: BEYOND LIMITS\n"), done.stdout)
    report = json.loads((work / "bad" / "camera_check" / "check.json").read_text())
    check(
        report["passed"] is False and "full tables" in report["failures"][-1],
        report["failures"],
    )
    check(report["first_hits"]["unexplained"] == 0)
    png(work / "bad" / "camera_check" / "difference.png")
    # Nothing is overwritten unasked.
    words = ("check", garden, *few, "-o", work / "bad")
    program.refused(*words, status=2, says=["camera_check", "--overwrite"])
    if FULL:
        done = run("check", work / "garden" / "noisy.toml", *few, "--json", status=1)
        check(json.loads(done.stdout)["camera"]["passed"] is False)

    # Light between surfaces, by sums over pixels: other paths on either side.
    bounced, changed = re.subn(r"(?m)^seed = .*$", r"\g<0>\nbounces = 2", toml)
    check(changed == 1, toml)
    (work / "garden" / "bounced.toml").write_text(bounced)
    done = run("check", work / "garden" / "bounced.toml", "--rays", 1000, "--pixels", 64, "--model-pixels", 0, "--json")
    report = json.loads(done.stdout)["camera"]
    check(report["passed"], report["failures"])
    paths = report["light_between_surfaces"]
    check(paths["pixels"] == 64 and paths["paths"] == 64 * 256, paths)
    check(len(paths["apart"]) == len(report["band_median"]))
    program.between(0, max(paths["apart"]), 5, "apart")
    check(paths["limit_standard_errors"] == 5)
    check(min(paths["device"]) > 0 and min(paths["standard_error"]) > 0)
    check(max(e / l for e, l in zip(paths["standard_error"], paths["reference"])) < 0.2)
    # Their own paths, ray by ray.
    replayed = report["paths_replayed"]
    check(replayed["pixels"] == 64 and replayed["rays_to_surfaces"] > 0 and replayed["decisions"] > 0, replayed)
    check(replayed["pixels_left_out"] == 0 < replayed["worst"] < replayed["limit"] == 2e-5, replayed)

    # Pixels of more samples than one launch takes.
    dense, changed = re.subn(r"(?m)^samples\s*=.*$", "samples = { grid = [34, 34] }", toml)
    check(changed == 1, toml)
    (work / "garden" / "dense.toml").write_text(dense)
    done = run("check", work / "garden" / "dense.toml", "--rays", 4624, "--pixels", 4, "--model-pixels", 0, "--json")
    report = json.loads(done.stdout)["camera"]
    check(report["rays"] == 4 * 34 * 34 and report["passed"], report["failures"])
    check_hits(report["first_hits"], 4 * 34 * 34)
print(f"check: {program.checks} checks")

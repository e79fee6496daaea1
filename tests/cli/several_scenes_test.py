"""`raycube render` of several files: each in a folder of its own with the products that it has alone, an error of one
told and the others rendered. usage: several_scenes_test.py RAYCUBE"""

import json
import pathlib
import sys
import tempfile

from driver import Program, record, scene

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused

with tempfile.TemporaryDirectory() as temporary:
    folder = pathlib.Path(temporary)
    morning, noon = scene(folder, "morning.toml"), scene(folder, "noon.toml", grid=2)
    run("render", noon, "-o", folder / "alone", "-q")
    done = run("render", morning, noon, "-o", folder / "day")
    check(done.stdout.splitlines() == [str(folder / f"day/{name}/camera/radiance.img") for name in ("morning", "noon")],
          done.stdout)
    check(record(folder / "day/noon/camera")["digest"] == record(folder / "alone/camera")["digest"])
    check(record(folder / "day/morning/camera")["digest"] != record(folder / "day/noon/camera")["digest"])

    # One is refused: one error line, its status, and the others are there; nothing of the refused one.
    bad = folder / "bad.toml"
    bad.write_text(noon.read_text().replace("format = 1\n", "format = 1\ntolerance = 7\n", 1))
    for order in ((bad, noon), (noon, bad)):
        out = folder / f"kept_{order[0].stem}"
        said = run("render", *order, "-o", out, "--json", status=2)
        errors = [line for line in said.stderr.splitlines() if line.startswith("raycube: error: ")]
        check(len(errors) == 1 and "bad.toml:2:13" in errors[0], said.stderr)
        all_of = {pathlib.Path(one["file"]).stem: one for one in json.loads(said.stdout)["simulations"]}
        check("'tolerance'" in all_of["bad"]["error"] and all_of["bad"]["instruments"] == [], all_of)
        check("error" not in all_of["noon"] and all_of["noon"]["instruments"][0]["name"] == "camera", all_of)
        check(sorted(path.name for path in out.iterdir()) == ["noon"], list(out.iterdir()))

    # What is there stays, the other is made all the same.
    before = (folder / "day/noon/camera/run.json").read_bytes()
    evening = scene(folder, "evening.toml")
    said = run("render", noon, evening, "-o", folder / "day", status=2)
    check("--overwrite" in said.stderr and (folder / "day/noon/camera/run.json").read_bytes() == before, said.stderr)
    check((folder / "day/evening/camera/radiance.img").exists())

    # Two of one name, and a plan, which is of one file: one error before anything is rendered.
    (folder / "other").mkdir()
    twin = scene(folder / "other", "noon.toml")
    refused("render", noon, twin, "-o", folder / "x", status=2, says=["noon.toml", "rename one"])
    run("plan", noon, "-o", folder / "plan.json", "-q")
    refused("render", noon, morning, "--plan", folder / "plan.json", "-o", folder / "x", status=2,
            says=["--plan is of one simulation", "2 files"])
    check(not (folder / "x").exists())
    dry = json.loads(run("render", noon, morning, "--dry-run", "--json").stdout)
    check([pathlib.Path(one["file"]).name for one in dry["simulations"]] == ["noon.toml", "morning.toml"], dry)
    check(set(json.loads(run("render", noon, "-o", folder / "one", "--json").stdout)) == {"instruments"})
print(f"several_scenes: {program.checks} checks")

#!/usr/bin/env python3
"""`raycube plan` as users drive it: a table, a file that render replays to the same digest, what the file gives wins
(S60). usage: plan_cli_test.py RAYCUBE"""

import json
import pathlib
import re
import sys
import tempfile

from driver import Program, record, scene

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused


def opened(path, tolerance):
    """The same file with samples left to the planner."""
    text, count = re.subn(r"(?m)^samples = .*\n", "", path.read_text())
    check(count == 1)
    text = text.replace("gsd_m = 1.0", "gsd_m = 0.93")  # else every edge lies between two pixels
    out = path.with_name(f"open_{tolerance}.toml")
    out.write_text(text.replace("format = 1\n", f"format = 1\ntolerance = {tolerance}\n", 1))
    return out


def not_replayed(file, plan, says):
    """Render refuses the plan for this file and leaves no folder behind."""
    out = file.parent / "x"
    refused("render", file, "-o", out, "--plan", plan, status=2, says=says)
    check(not out.exists(), "a refused render left a folder behind")


with tempfile.TemporaryDirectory() as temporary:
    folder = pathlib.Path(temporary)
    given = scene(folder, "given.toml", grid=3)
    open_file = opened(given, 0.03)

    first = run("plan", open_file, "-o", folder / "plan.json").stdout
    for block in (
        "spectral grid",
        "sun",
        "sky",
        "target height",
        "samples",
        "sky directions",
        "estimated error",
        "trial",
    ):
        check(block in first, block, first)
    check(first == run("plan", open_file).stdout, "two runs, two plans")
    plan = json.loads((folder / "plan.json").read_text())
    entry = plan["instruments"][0]
    check(entry["name"] == "camera" and plan["tolerance"] == 0.03, plan)
    check(entry["decision"]["error"]["total"] <= 0.03 and entry["decision"]["within_tolerance"], entry)

    # render chooses the same, says so in its record, and a replay gives the same digest.
    run("render", open_file, "-o", folder / "chosen", "-q")
    run("render", open_file, "-o", folder / "replayed", "-q", "--plan", folder / "plan.json")
    chosen, replayed = (record(folder / name / "camera") for name in ("chosen", "replayed"))
    check(chosen["digest"] == replayed["digest"])
    lines = {line["block"]: line for line in chosen["plan"]["planner"]["lines"]}
    # So small an image is rendered at once, as the mean of a few replicates, which the replay renders anew.
    check(
        lines["samples"]["level"] == "{} x lattice {}".format(entry["replicates"], entry["samples"][0])
        and not lines["samples"]["given"],
        lines,
    )
    check(entry["replicates"] >= 4 and 0 < lines["samples"]["error"] < 0.03, lines)
    in_all = entry["replicates"] * entry["samples"][0] * entry["samples"][1]
    check(chosen["image"]["samples_per_pixel"] == in_all, chosen["image"])
    for made in (chosen, replayed):
        error = made["error"]
        check("replicates" in error["from"] and error["within_tolerance"], error)
        check(abs(error["total"] - entry["decision"]["error"]["total"]) < 1e-9, error, entry)

    # What the file gives stays and is marked; plan estimates it all the same, render does not spend a trial on it.
    table = json.loads(run("plan", given, "--json").stdout)["instruments"][0]
    mine = {line["block"]: line for line in table["decision"]["lines"]}["samples"]
    check(mine["given"] and mine["level"] == "grid 3 x 3" and mine["error"] is not None, mine)
    check("trial" in table["decision"], table)

    # A tolerance nobody can keep is said to be so; render warns of it too.
    dear = opened(given, 1e-6)
    check(re.search("cannot be kept within 30 s|is not kept", run("plan", dear).stderr))

    # Another scene, tolerance and seed: the plan's settings are a first guess. One line says so, and the error is
    # measured on the image's own pixels.
    other = scene(folder, "other.toml", grid=3)
    other.write_text(other.read_text().replace("gsd_m = 1.0", "gsd_m = 0.93"))
    other.write_text(
        other.read_text().replace("0.80", "0.79").replace("format = 1\n", "format = 1\ntolerance = 0.03\n", 1)
    )
    other.write_text(re.sub(r"(?m)^samples = .*\n", "", other.read_text()))
    guessed = run("render", other, "-o", folder / "guessed", "--seed", 77, "--plan", folder / "plan.json")
    for said in ("another scene", "seed 1, not 77", "first guess", "raycube plan SIM -o"):
        check(said in guessed.stderr, said, guessed.stderr)
    guess = record(folder / "guessed/camera")
    check(guess["image"]["samples_per_pixel"] == in_all, guess["image"])
    check(guess["plan"]["planner"]["within_tolerance"] is None, guess["plan"]["planner"])
    error = guess["error"]
    check("spread of the image's" in error["from"], error)
    check(error["within_tolerance"] == (error["total"] <= 0.03), error)
    check(any("first guess" in line for line in guess["warnings"]), guess["warnings"])
    # The same where the air has other nodes.
    plan["instruments"][0]["plan"]["height_nodes"] += 1
    (folder / "nodes.json").write_text(json.dumps(plan))
    nodes = run("render", open_file, "-o", folder / "nodes", "--plan", folder / "nodes.json")
    check("nodes and components" in nodes.stderr, nodes.stderr)

    # Samples or directions that the simulation gives and the plan has not: neither is overridden in silence.
    finer = folder / "finer.toml"
    finer.write_text(
        open_file.read_text().replace("[[instrument]]\n", "[[instrument]]\nsamples = { grid = [31, 31] }\n", 1)
    )
    not_replayed(finer, folder / "plan.json", ["samples = grid 31 x 31", "remove samples"])
    erring = folder / "erring.toml"
    erring.write_text(
        open_file.read_text().replace("[[instrument]]\n", '[[instrument]]\nstandard_error = "worst"\n', 1)
    )
    not_replayed(erring, folder / "plan.json", ["x lattice", "standard errors"])
    lit = scene(folder, "lit.toml", air='{ model = "clear_sky" }')
    run("plan", lit, "-o", folder / "lit.json", "-q")
    lit.write_text(lit.read_text().replace("format = 1\n", "format = 1\nsky_directions = 3999\n", 1))
    not_replayed(lit, folder / "lit.json", ["sky_directions = 3999", "remove sky_directions"])
    followed = scene(folder, "followed.toml", air='{ model = "clear_sky" }')
    keys = "format = 1\nsky_directions = 8\npaths = 16\n"
    followed.write_text(followed.read_text().replace("format = 1\n", keys, 1).replace("bounces = 0\n", "bounces = 1\n"))
    run("plan", followed, "-o", folder / "followed.json", "-q")
    told = json.loads((folder / "followed.json").read_text())["instruments"][0]
    check(told["paths_per_two_directions"] == 4 and told["sky_directions"] == 8, told)
    followed.write_text(followed.read_text().replace("paths = 16", "paths = 32"))
    not_replayed(followed, folder / "followed.json", ["paths = 32", "16 paths", "remove paths"])

    # What a simulation may not ask for a plan may not either.
    for samples, sampler, replicates in (
        ([65536, 1], 0, 1),
        ([257, 257], 1, 1),
        ([65536, 2], 2, 1),
        ([0, 1], 0, 1),
        ([13, 1], 1, 0),
        ([13, 1], 1, 65),
    ):
        wide = json.loads(json.dumps(plan))
        wide["instruments"][0].update(samples=samples, sampler=sampler, replicates=replicates)
        (folder / "wide.json").write_text(json.dumps(wide))
        not_replayed(open_file, folder / "wide.json", ["out of range", "raycube plan SIM -o"])

    # A broken plan, one without the instrument.
    (folder / "broken.json").write_text(json.dumps({"raycube_plan": plan["raycube_plan"]}))
    not_replayed(open_file, folder / "broken.json", ["not a plan of raycube"])
    plan["instruments"][0]["name"] = "eye"
    (folder / "named.json").write_text(json.dumps(plan))
    not_replayed(open_file, folder / "named.json", ["no instrument 'camera'", "eye"])
    not_replayed(open_file, folder / "none.json", ["cannot be read"])


with tempfile.TemporaryDirectory() as temporary:
    # So many surfaces as planning chooses are told, and render as the same number given.
    folder = pathlib.Path(temporary)
    run("new", folder / "garden", "-q")
    garden = folder / "garden/garden.toml"

    def bounced(bounces):
        text = garden.read_text().replace("format = 1\n", f"format = 1\nbounces = {bounces}\n", 1)
        file = garden.with_name("bounced.toml")
        file.write_text(text)
        run("plan", file, "-o", folder / "bounced.json", "--overwrite", "-q")
        run("render", file, "-o", folder / "bounced", "--overwrite", "-q")
        radiance = (folder / "bounced/camera/radiance.img").read_bytes()
        return json.loads((folder / "bounced.json").read_text())["instruments"][0], radiance

    entry, radiance = bounced('"auto"')
    levels = entry["plan"]["bounces"]
    check(levels == 64, levels)
    line = next(line for line in entry["decision"]["lines"] if line["block"] == "between surfaces")
    # A tenth of the tolerance of 2 %; light between surfaces is a few percent beside walls and under crowns.
    check(not line["given"] and line["error"] <= 0.002 and 0.01 < line["error_without"] < 0.2, line)
    check(bounced(levels)[1] == radiance, "chosen and given differ")
    check(bounced(0)[1] != radiance)
    garden.write_text(garden.read_text().replace("format = 1\n", 'format = 1\nbounces = "many"\n', 1))
    refused("plan", garden, status=2, says=["bounces", "many", 'an integer or "auto"'])
    garden.write_text(garden.read_text().replace('bounces = "many"', "bounces = 65"))
    refused("plan", garden, status=2, says=["bounces", "65", '0 .. 64 or "auto"'])

with tempfile.TemporaryDirectory() as temporary:
    # What the tolerance is of: said in the table, kept in the plan's file, replayed, and asked for in one line.
    folder = pathlib.Path(temporary)
    plain = opened(scene(folder, "plain.toml", instrument='standard_error = "worst"'), 0.02)  # which takes a trial

    def asked(name, keys):
        file = folder / f"{name}.toml"
        file.write_text(plain.read_text().replace("format = 1\n", "format = 1\n" + keys, 1))
        return file

    cost = {}
    for figure, said in (("rms", "rms over"), ("p99", "99th percentile over"), ("worst", "worst of the")):
        file = asked(figure, f'tolerance_of = "{figure}"\n')
        text = run("plan", file, "-o", folder / f"{figure}.json").stdout
        check(f"tolerance 2 % ({said} pixels)" in text and "inside the tolerance" in text, text)
        told = json.loads((folder / f"{figure}.json").read_text())
        decision = told["instruments"][0]["decision"]
        check(told["tolerance_of"] == decision["tolerance_of"] == figure and decision["within_tolerance"], told)
        check(told["tolerance_materials"] == [], told)
        cost[figure] = decision["cost"]["nominal_s_per_megapixel"]
    check(cost["rms"] <= cost["p99"] <= cost["worst"], cost)
    default, rms = json.loads(run("plan", plain, "--json").stdout), json.loads((folder / "rms.json").read_text())
    check({**default, "simulation": ""} == {**rms, "simulation": ""}, "the rms is not the default", default, rms)

    listed = asked("listed", 'tolerance_of = "p99"\ntolerance_materials = ["dark", "middle"]\n')
    text = run("plan", listed, "-o", folder / "listed.json").stdout
    check("(99th percentile over pixels of dark, middle)" in text, text)
    check(json.loads((folder / "listed.json").read_text())["tolerance_materials"] == ["dark", "middle"])
    run("render", listed, "-o", folder / "chosen", "-q")
    run("render", listed, "-o", folder / "replayed", "--plan", folder / "listed.json", "-q")
    chosen, replayed = (record(folder / name / "camera") for name in ("chosen", "replayed"))
    check(chosen["digest"] == replayed["digest"], "the replay differs")
    for made in (chosen, replayed):
        error = made["error"]
        check(error["tolerance_of"] == "p99" and error["tolerance_materials"] == ["dark", "middle"], error)
        check(error["within_tolerance"] and "replicates" not in error["from"], error)
    other = run("render", asked("other", 'tolerance_of = "worst"\n'), "-o", folder / "other", "--plan",
                folder / "listed.json")
    check("99th percentile over pixels of dark, middle, not of the worst of the pixels" in other.stderr, other.stderr)
    check(record(folder / "other/camera")["error"]["tolerance_of"] == "worst")

    for name, keys, says in (
        ("figure", 'tolerance_of = "median"\n', ["figure.toml:2:16", "median", "rms, p99, worst"]),
        ("unknown", 'tolerance_materials = ["drak"]\n', ["unknown.toml:2", "unknown material", "'drak'", "dark"]),
        ("none", "tolerance_materials = []\n", ["none.toml:2", "no pixel would count", "remove the key"]),
        ("number", "tolerance_materials = [3]\n", ["number.toml:2", "tolerance_materials"]),
    ):
        refused("plan", asked(name, keys), status=2, says=says)

print(f"plan_cli: {program.checks} checks")

"""`raycube scene schema`: what the readers take the schemas take, and a wrong key in any table both refuse. Every TOML
file that is shipped (scenes, those that the park's generator writes and `raycube new`) and every one that the pages
show is held against its schema by Debian's jsonschema; then once more for each of its tables with a key in it that is
not known. usage: schema_test.py RAYCUBE ROOT PARK, PARK a folder that scenes/park/generate.py wrote."""

import copy
import json
import pathlib
import re
import sys
import tempfile
import tomllib

from driver import Program

try:
    import jsonschema
except ImportError:
    print("schema: python3-jsonschema is not installed: nothing was checked; ci/setup brings it")
    sys.exit(77)

program = Program(sys.argv[1])
ROOT, PARK = pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
KINDS = ("simulation", "sensor", "experiment", "sweep")


def validators():
    out = {}
    for kind in KINDS:
        schema = json.loads(program.run("scene", "schema", kind).stdout)
        jsonschema.Draft202012Validator.check_schema(schema)
        out[kind] = jsonschema.Draft202012Validator(schema)
    return out


VALIDATORS = validators()


def kind_of(name, data):
    if "parameter" in data or "metric" in data:
        return "sweep"
    if "step" in data or "figure" in data:
        return "experiment"
    return "sensor" if "sensors" in name else "simulation"


def lacks_only(error):
    """Whether the fault is that a part of a file does not say what a whole one must."""
    if error.validator == "anyOf" and error.context:
        return all(lacks_only(one) for one in error.context if one.validator != "type")
    return error.validator == "required"


def tables(data, way=()):
    """Ways to all tables of a file but those whose keys are names of the user's own."""
    if isinstance(data, dict):
        yield way
        for key, value in data.items():
            if key not in ("materials", "reflectance_of"):
                yield from tables(value, (*way, key))
    elif isinstance(data, list):
        for i, value in enumerate(data):
            yield from tables(value, (*way, i))


def files():
    with tempfile.TemporaryDirectory() as folder:
        new = pathlib.Path(folder) / "new"
        program.run("new", new)
        for top in (ROOT / "scenes", PARK, new):
            for path in sorted(top.rglob("*.toml")):
                yield str(path.relative_to(top.parent)), path.read_text(), True
    for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))):
        for number, text in enumerate(re.findall(r"```toml\n(.*?)```", page.read_text(), re.S)):
            if "format = 1" in text or text.startswith("["):  # else a few keys of some table
                yield f"{page.name}, example {number}", text, "format = 1" in text


def held(name, text, whole):
    data = tomllib.loads(text)
    kind = kind_of(name, data)
    if not whole:
        data["format"] = 1
    faults = [e for e in VALIDATORS[kind].iter_errors(data) if whole or not lacks_only(e)]
    program.check(not faults, name, kind, [f"{e.json_path}: {e.message}"[:300] for e in faults])
    ways = list(tables(data))
    for way in ways:
        planted = copy.deepcopy(data)
        at = planted
        for part in way:
            at = at[part]
        at["no_such_key"] = 1
        wrong = [e for e in VALIDATORS[kind].iter_errors(planted) if whole or not lacks_only(e)]
        program.check(wrong, name, way, "a key that is not known is taken")
    return kind, len(ways)


def readers_agree():
    """What a reader refuses of a sensor or a study the schema refuses."""
    for kind, text in (
        ("sensor", 'format = 1\nname = "its instrument\'s own"\n'),
        ("sensor", 'format = 1\nsensor = "another"\n'),
        ("sensor", "format = 1\npixels = 0\n"),
        ("experiment", 'format = 1\ntitle = "t"\n'),
        ("experiment", 'format = 1\ntitle = "t"\n[[step]]\nname = "s"\nrun = "a text"\n'),
        ("sweep", 'format = 1\ntitle = "t"\nmethod = "best"\nparameter = []\nmetric = []\n'),
        ("sweep", 'format = 1\ntitle = "t"\nbase_points = 1\nparameter = []\nmetric = []\n'),
    ):
        program.check(not VALIDATORS[kind].is_valid(tomllib.loads(text)), kind, text)
    one = tomllib.loads('format = 1\ntitle = "t"\n[step]\nname = "s"\nrun = [["a"], ["b", "c"]]\n')
    program.check(VALIDATORS["experiment"].is_valid(one))
    one["step"]["no_such_key"] = 1
    program.check(not VALIDATORS["experiment"].is_valid(one))
    lamp = json.loads(program.run("scene", "keys", "sensor", "--json").stdout)["tables"]
    program.check("name" not in [key["key"] for key in lamp[0]["keys"]], lamp[0])
    program.refused("scene", "schema", "scene", status=2, says=["found 'scene'", "simulation, sensor, experiment"])


def pages():
    """docs/studies.md lists the keys as they are; refresh it with `raycube scene keys experiment`, and `sweep`."""
    page = (ROOT / "docs/studies.md").read_text()
    for kind in ("experiment", "sweep"):
        keys = program.run("scene", "keys", kind).stdout.replace("### ", "#### ").strip()
        program.check(keys in page, kind)


count = {kind: 0 for kind in KINDS}
planted = 0
for each in files():
    kind, places = held(*each)
    count[kind] += 1
    planted += places
readers_agree()
pages()
program.check(all(count.values()), count)
print(f"schema: {count}, {planted} planted keys, {program.checks} checks")

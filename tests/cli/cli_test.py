#!/usr/bin/env python3
"""The program as users drive it: exit statuses (DESIGN section 10), streams, --json, refusals, machine failures.
usage: cli_test.py RAYCUBE"""

import array
import json
import os
import pathlib
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile

import patience

raycube = str(pathlib.Path(sys.argv[1]).resolve())
checks = 0


def run(*arguments, status=0, env=None, **more):
    more.setdefault("stdout", subprocess.PIPE)
    done = patience.run(
        [raycube, *map(str, arguments)], stderr=subprocess.PIPE, text=True, env={**os.environ, **(env or {})}, **more
    )
    assert done.returncode == status, f"{arguments}: status {done.returncode}, not {status}\n{done.stdout}{done.stderr}"
    return done


def check(condition, *what):
    global checks
    checks += 1
    assert condition, what


def one_error(done, *parts):
    """stderr holds exactly one error message, with every part in it, and stdout nothing."""
    lines = [line for line in done.stderr.splitlines() if line.startswith("raycube: error: ")]
    check(len(lines) >= 1 and done.stdout in ("", None), done.stderr, done.stdout)
    for part in parts:
        check(part in done.stderr, part, done.stderr)


usage = json.loads(run("--json-usage").stdout)
verbs = {verb["name"]: verb for verb in usage["verbs"]}
check(run("--version").stdout.startswith("raycube "))
help_text = run("--help").stdout
check(run("-h").stdout == help_text)
one_error(run(status=2), "name a verb")
one_error(run("rendr", status=2), "unknown verb \"rendr\"")
one_error(run("--frob", status=2), "no option --frob")
check(run("help").stdout == help_text and run("help", "help").stdout == help_text)
check(run("help", "render").stdout == run("render", "--help").stdout)
check(run("help", "scene", "check").stdout == run("scene", "check", "--help").stdout)
one_error(run("help", "rendr", status=2), "unknown verb \"rendr\"; did you mean render?")
one_error(run("help", "scene", "chek", status=2), "unknown verb \"chek\"; did you mean check?")


def walk(path, verb):
    """Every verb has help, a summary, and refuses an unknown option with status 2."""
    text = run(*path, "--help").stdout
    check(verb["summary"] in text, path)
    for child in verb.get("verbs", []):
        walk([*path, child["name"]], child)
    if verb.get("verbs"):
        one_error(run(*path, status=2), "name a verb of")
        one_error(run(*path, "nosuchverb", status=2), "unknown verb")
        return
    for option in verb["options"]:
        check(option["names"][-1] in text and option["help"] in text, path, option)
    needed = ["x" for option in verb["options"] if option["required"]]
    one_error(run(*path, *needed, "--no-such-option", status=2), "has no option --no-such-option")
    if needed:
        one_error(run(*path, status=2), "is required")
    one_error(run(*path, *needed, "-q", "-v", status=2), "contradict")


for name, verb in verbs.items():
    check(name in help_text)
    walk([name], verb)

with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)

    # info: an image whose statistics are known by algebra: values 0..23 in one band, their negatives in the other.
    values = array.array("f", [sign * v for sign in (1, -1) for v in range(24)])
    (folder / "a.img").write_bytes(values.tobytes())
    (folder / "a.hdr").write_text(
        "ENVI\nsamples = 6\nlines = 4\nbands = 2\ndata type = 4\ninterleave = bsq\nbyte order = 0\n"
        "wavelength units = Nanometers\nwavelength = {450, 650}\ndata ignore value = -23\n"
    )
    for name in ("a.img", "a.hdr"):
        done = run("info", "--json", folder / name)
        info = json.loads(done.stdout)
        first, second = info["band_statistics"]
        check(info["header"]["wavelength_um"] == [0.45, 0.65], info)
        check(
            first["count"] == 24 and first["min"] == 0 and first["max"] == 23 and abs(first["mean"] - 11.5) < 1e-12,
            first,
        )
        check(abs(first["standard_deviation"] - 50**0.5) < 1e-12, first)  # (n^2 - 1) / 12 n / (n - 1) = 50 for n = 24
        check(second["ignored"] == 1 and second["min"] == -22 and abs(second["mean"] + 11) < 1e-12, second)
        every = [v for v in values if v != -23]
        check(info["statistics"]["count"] == 47 and abs(info["statistics"]["mean"] - sum(every) / 47) < 1e-12, info)
        check(abs(info["statistics"]["standard_deviation"] - statistics.stdev(every)) < 1e-12, info)
    check("statistics" not in json.loads(run("info", "--json", "--header", folder / "a.img").stdout))
    text = run("info", folder / "a.img").stdout
    check("6 samples x 4 lines x 2 bands, float32, bsq" in text and "0.45 to 0.65 um" in text, text)

    # info: refusals of bad input, one error each
    (folder / "short.img").write_bytes(b"x" * 95)
    (folder / "short.hdr").write_text("ENVI\nsamples = 6\nlines = 4\nbands = 1\ndata type = 4\ninterleave = bsq\n")
    one_error(run("info", folder / "short.img", status=2), "need 96 bytes (found 95)")
    (folder / "zero.img").write_bytes(b"")
    (folder / "zero.hdr").write_bytes(b"")
    one_error(run("info", folder / "zero.img", status=2), "an empty file")
    one_error(run("info", folder / "nothing.img", status=2), "no such file")
    one_error(run("info", folder, status=2), "without run.json")

    # info: a folder of several runs, in the order of their names
    record = {"format": "raycube run", "files": {}, "sha256": {}}
    for name in ("two", "one"):
        (folder / "runs" / name).mkdir(parents=True)
        (folder / "runs" / name / "run.json").write_text(json.dumps({**record, "instrument": name}))
    text = run("info", folder / "runs").stdout
    check(text.index("instrument    one") < text.index("instrument    two"), text)
    both = json.loads(run("info", "--json", folder / "runs").stdout)
    check(both["kind"] == "runs" and [r["run"]["instrument"] for r in both["runs"]] == ["one", "two"], both)
    (folder / "runs/one/run.json").write_text("{")
    one_error(run("info", folder / "runs", status=2), "not valid JSON")
    shutil.rmtree(folder / "runs")
    for name, content, part in (
        ("bad.json", "{", "not valid JSON"),
        ("other.json", "{}", "no run record"),
        ("odd.json", '{"format": 3}', "wrong type"),
    ):
        (folder / name).write_text(content)
        one_error(run("info", folder / name, status=2), part)
    (folder / "bad.rcs").write_bytes(b"not a scene")
    one_error(run("info", folder / "bad.rcs", status=2), "bad.rcs")
    (folder / "bad.rct").write_bytes(b"not a table")
    one_error(run("info", folder / "bad.rct", status=2), "bad.rct")

    # a run record, as a file and as its folder
    record = {
        "format": "raycube run",
        "command": "raycube render park.toml",
        "digest": "abc",
        "stage_s": {"trace": 1.5},
    }
    (folder / "run.json").write_text(json.dumps(record))
    check("trace" in run("info", folder).stdout)
    check(json.loads(run("info", "--json", folder / "run.json").stdout)["run"] == record)

    # streams: messages to stderr, -q silences them, --log keeps them as JSON lines
    scene = folder / "scenes" / "garden"
    done = run("new", scene, "--log", folder / "log.jsonl")
    check(done.stdout.strip() == str(scene / "garden.toml") and "next:" in done.stderr, done)
    check([json.loads(line) for line in (folder / "log.jsonl").read_text().splitlines()][0]["level"] == "info")
    check(run("new", folder / "quiet", "-q").stderr == "")
    one_error(run("new", folder / "x", "--log", "/proc/no/log", status=3), "--log")

    # new: about thirty commented lines, never overwrites, refuses odd names
    lines = (scene / "garden.toml").read_text().splitlines()
    check(25 <= len(lines) <= 45 and sum("#" in line for line in lines) >= 8, len(lines))
    before = {path: path.read_bytes() for path in scene.iterdir()}
    one_error(run("new", scene, status=2), "never overwrites")
    check(before == {path: path.read_bytes() for path in scene.iterdir()})
    one_error(run("new", folder / "a b", status=2), "letters, digits")
    (folder / "empty").mkdir()
    run("new", folder / "empty")
    if "scene" in verbs:
        check("sound" in run("scene", "check", scene / "garden.toml").stdout)
        run("scene", "compile", scene / "garden.toml", "-o", folder / "garden.rcs")
        as_file, as_scene = (
            json.loads(run(*verb, folder / "garden.rcs", "--json").stdout) for verb in (("info",), ("scene", "info"))
        )
        check(as_file == as_scene and as_file, as_file)
    if "atmos" in verbs:
        run("atmos", "build", scene / "garden.toml", "-o", folder / "garden.rct")
        as_file, as_table = (
            json.loads(run(*verb, folder / "garden.rct", "--json").stdout) for verb in (("info",), ("atmos", "info"))
        )
        check(as_file == as_table and as_file, as_file)

    # machine: read-only place, full disk (file-size limit), full stdout, no OpenCL device
    one_error(run("new", "/proc/raycube-test", status=3), "/proc/raycube-test")
    limited = run(
        "new", folder / "limited", status=3, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))
    )
    one_error(limited, "ulimit -f")
    check(not [p for p in (folder / "limited").glob("*")] and not [p for p in (folder / "limited").glob(".*")])
    with open("/dev/full", "w") as full:
        one_error(run("--json-usage", stdout=full, status=3), "stdout")
    # A log that cannot be written: told once, however quiet, and the run goes on.
    for quiet in ([], ["-q", "-q"]):
        done = run("scene", "check", folder / "none.toml", "--log", "/dev/full", *quiet, status=2)
        check(done.stderr.count("--log /dev/full: cannot be written: No space left on device") == 1, done.stderr)
        check("none.toml" in done.stderr, done.stderr)
    one_error(run("devices", status=4, env={"OCL_ICD_VENDORS": "/nonexistent"}), "no OpenCL device")

devices = json.loads(run("devices", "--json").stdout)["devices"]
check(devices and all(d["name"] and d["max_alloc_bytes"] > 0 for d in devices), devices)
check(devices[0]["name"] in run("devices").stdout)
print(f"cli: {checks} checks, verbs: {' '.join(verbs)}")

"""S56 S57 S59: `raycube experiment` and `sweep`: steps that are kept, reports that hold everything, indices of a
function whose own are known (Ishigami and Homma 1990), and `--set`. usage: studies_test.py RAYCUBE SCENES PARK
[--full], PARK a folder that scenes/park/generate.py wrote. Without --full: that park of four species alone; one of one
species takes 10 s to grow."""

import base64
import csv
import html.parser
import itertools
import json
import math
import os
import pathlib
import re
import shutil
import signal
import sys
import tempfile

import numpy as np
from scipy.stats import qmc

import patience
from driver import FULL, Program
from optics_kit import HEAD, camera

program = Program(sys.argv[1])
PYTHON = sys.executable

WORK = """import json, os, pathlib, sys, time
folder, value = pathlib.Path(sys.argv[1]), float(sys.argv[2])
with open(sys.argv[3] + "/log", "a") as log:
    log.write(sys.argv[4] + "\\n")
(folder / "pid").write_text(str(os.getpid()))
time.sleep(float(sys.argv[5]) if len(sys.argv) > 5 else 0)
(folder / "out.json").write_text(json.dumps({"a": {"b": [value, None, "text"]}, "square": value * value}))
"""
PNG = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)


def write(folder, name, text):
    (folder / name).write_text(text)
    return folder / name


def step(name, value, folder, *more):
    words = [PYTHON, "work.py", "{folder}", str(value), str(folder), name, *more]
    return f"[[step]]\nname = {json.dumps(name)}\nrun = {json.dumps(words)}\n"


def runs(folder):
    """Names of the steps that ran since the last look."""
    log = folder / "log"
    out = log.read_text().split() if log.exists() else []
    log.unlink(missing_ok=True)
    return out


class Page(html.parser.HTMLParser):
    """What a page refers to, and its text."""

    def __init__(self, text):
        super().__init__()
        self.links, self.text, self.open = [], "", []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.links += [value for key, value in attributes if key in ("src", "href")]
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, tag

    def handle_data(self, data):
        self.text += data


def kept(folder):
    """Steps run again where something they are made of has changed, and no others."""
    write(folder, "work.py", WORK)
    write(folder, "picture.py", f"import sys; open(sys.argv[1] + '/p.png', 'wb').write({PNG!r})")
    (folder / "data").mkdir()
    write(folder / "data", "x.txt", "1")
    text = 'format = 1\ntitle = "A <study> & more"\ntext = """One.\n\nTwo."""\nsource = "Somebody 2014"\n'
    first, second = step("first", 2, folder), step("second", 3, folder)
    second += 'inputs = ["data"]\n'
    third = (
        f'[[step]]\nname = "third"\nrun = [[{json.dumps(PYTHON)}, "picture.py", "{{folder}}"], '
        '["cp", "{first}/out.json", "{folder}"]]\n'
    )
    figure = """[[figure]]
of = "Table 2"
title = "Numbers"
text = "What they are."
why = "Because <of> this."
pictures = ["{third}/p.png"]
[[figure.value]]
name = "one"
file = "{third}/out.json"
at = "/a/b/0"
times = 100
unit = "%"
published = "56.5 %"
[[figure.value]]
name = "two"
file = "{second}/out.json"
at = "/square"
digits = 2
[[figure.value]]
name = "nothing"
file = "{second}/out.json"
at = "/a/b/1"
"""
    study = write(folder, "study.toml", text + first + second + third + figure)
    out = folder / "results"

    def go():
        program.run("experiment", study, "-o", out)
        return runs(folder)

    done = program.run("experiment", study, "-o", out, "--dry-run")
    program.check(done.stdout.split("\n")[:3] == [f"{n}: to run" for n in ("first", "second", "third")], done.stdout)
    program.check(go() == ["first", "second"])
    program.check(go() == [])
    done = program.run("experiment", study, "-o", out, "--dry-run")
    program.check(done.stdout.count("kept") == 3, done.stdout)
    page = Page((out / "report.html").read_text())
    for words in (
        "A <study> & more",
        "Table 2",
        "Because <of> this.",
        "200 %",
        "56.5 %",
        "Somebody 2014",
        "second",
        "none",
    ):
        program.check(words in page.text, words)
    program.check(not page.open, page.open)
    program.check(all(link.startswith(("data:image/png;base64,", "#")) for link in page.links), page.links)
    picture = next(link for link in page.links if link.startswith("data:"))
    program.check(base64.b64decode(picture.split(",")[1]) == PNG)
    numbers = json.loads((out / "numbers.json").read_text())
    values = numbers["figures"][0]["values"]
    program.check([v["value"] for v in values] == [200, 9, None] and values[0]["published"] == "56.5 %", values)
    program.check([s["name"] for s in numbers["steps"]] == ["first", "second", "third"], numbers["steps"])

    write(folder / "data", "x.txt", "2")
    program.check(go() == ["second"])
    write(folder, "study.toml", text + first.replace('"2"', '"4"') + second + third + figure)
    program.check(go() == ["first"])
    program.check("400 %" in Page((out / "report.html").read_text()).text)
    (out / "steps/second/step.json").unlink()
    program.check(go() == ["second"])
    third = out / "steps/third/step.json"
    os.utime(third, (0, 0))  # file systems tell times to a few milliseconds, or seconds
    (out / "steps/first/step.json").unlink()  # what builds on it is made of its very run
    program.check(go() == ["first"] and third.stat().st_mtime_ns > 0)
    write(folder, "work.py", WORK + "# changed\n")
    program.check(go() == ["first", "second"])
    return text, first


def pid_of(step_folder):
    """Number of the process of a step that has begun, once it is written; it is written before the step waits."""
    file = step_folder / "pid"
    return file.read_text() if file.exists() else ""


def killed(folder):
    """After kill -9 in the third step the first two are not run again, and the third's rest is gone."""
    study = write(
        folder,
        "slow.toml",
        'format = 1\ntitle = "slow"\n'
        + "".join(step(f"s{i}", i, folder, "0" if i < 3 else "3600") for i in (1, 2, 3)),
    )
    out = folder / "slow"
    running = program.start("experiment", study, "-o", out)
    orphan = int(patience.until(lambda: pid_of(out / "steps/s3"), "the third step", running))
    again = program.run("experiment", study, "-o", out, status=3)
    program.check("another run" in again.stderr, again.stderr)
    (out / "steps/s3/half").write_text("x")
    running.kill()
    patience.until(lambda: running.poll() is not None, "the end by SIGKILL")
    patience.until(lambda: patience.status_of(orphan, "State")[:1] in ("", "Z", "X"), "the end of a dead run's step")
    program.check(runs(folder) == ["s1", "s2", "s3"])
    write(folder, "slow.toml", study.read_text().replace('"3600"', '"0"'))
    program.run("experiment", study, "-o", out)
    program.check(runs(folder) == ["s3"] and not (out / "steps/s3/half").exists())
    running = program.start_listening(
        "experiment",
        write(folder, "long.toml", 'format = 1\ntitle = "l"\n' + step("s", 1, folder, "3600")),
        "-o",
        folder / "long",
    )
    patience.until(lambda: (folder / "log").exists(), "the step", running)
    running.send_signal(signal.SIGINT)
    patience.end_of(running)
    program.check(running.returncode == 130, running.returncode)
    program.check(not (folder / "long/report.html").exists() and not (folder / "long/steps/s/step.json").exists())
    runs(folder)


def refused(folder, text, first):
    for more, says in (
        ("[[step]]\nname = 'x'\nrun = ['cp', '{nobody}/a', '{folder}']\n", "{nobody}"),
        ("[[step]]\nname = 'a b'\nrun = ['true']\n", "letters"),
        (first, "one name"),
        ("[[step]]\nname = 'x'\nrun = ['false']\n", "status 1"),
        ("[[step]]\nname = 'x'\nrun = ['no-such-program']\n", "no-such-program"),
        ("[[step]]\nname = '../x'\nrun = ['true']\n", "letters"),
        ("[[figure]]\ntitle = 't'\npictures = ['{later}/p.png']\n", "{later}"),
        ("[[figure]]\ntitle = 't'\n[[figure.value]]\nname='v'\nfile='{first}/out.json'\nat='/a~2'\n", "no place"),
        ("[[step]]\nname = 'x'\nruns = ['true']\n", "unknown key"),
        ("[[figure]]\ntitle = 't'\npictures = ['{first}/none.png']\n", "none.png"),
        ("[[figure]]\ntitle = 't'\npictures = ['{first}/out.json']\n", "no PNG"),
        ("[[figure]]\ntitle = 't'\n[[figure.value]]\nname='v'\nfile='{first}/out.json'\nat='/none'\n", "/none"),
        ("[[step]]\nname = 'x'\nrun = ['true']\ninputs = ['gone']\n", "gone"),
    ):
        write(folder, "bad.toml", text + first + more)
        done = program.run("experiment", folder / "bad.toml", "-o", folder / "bad", status=1 if "status" in says else 2)
        program.check(says in done.stderr, says, done.stderr)
    (folder / "mine").mkdir()
    write(folder / "mine", "thesis.txt", "x")
    done = program.run("experiment", folder / "study.toml", "-o", folder / "mine", status=2)
    program.check("other things" in done.stderr and (folder / "mine/thesis.txt").exists(), done.stderr)
    runs(folder)


ISHIGAMI = """import csv, math, sys
rows = list(csv.DictReader(open(sys.argv[1])))
with open(sys.argv[2], "w") as out:
    out.write("y,z\\n")
    for r in rows:
        a, b, c = (float(r[k]) for k in ("x1", "x2", "x3"))
        out.write(f"{math.sin(a) + 7 * math.sin(b) ** 2 + 0.1 * c**4 * math.sin(a)!r},{2 * a}\\n")
"""


def indices(folder):
    """Sobol's points are scipy's; indices of Ishigami's function close to 2 % of its variance."""
    write(folder, "ishigami.py", ISHIGAMI)
    parameters = "".join(f'[[parameter]]\nname = "x{i}"\nfrom = {-math.pi!r}\nto = {math.pi!r}\n' for i in (1, 2, 3))
    text = f"""format = 1
title = "Ishigami"
method = "sobol"
base_points = 4096
{parameters}
[batch]
run = ["{PYTHON}", "ishigami.py", "{{points}}", "{{results}}"]
[[metric]]
name = "y"
[[metric]]
name = "z"
"""
    sweep = write(folder, "ishigami.toml", text)
    program.run("sweep", sweep, "-o", folder / "ishigami")
    told = json.loads((folder / "ishigami/sweep.json").read_text())
    n, k = 4096, 3
    points = np.array(told["points"])
    base = qmc.Sobol(2 * k, scramble=False).random(2 * n)[1 : n + 1]
    a, b = base[:, :k], base[:, k:]
    rows = [a, b]
    for i in range(k):
        rows.append(a.copy())
        rows[-1][:, i] = b[:, i]
    program.check(np.allclose(points, -math.pi + 2 * math.pi * np.vstack(rows), atol=1e-12))
    one = 0.1 * math.pi**4
    parts = [0.5 * (1 + one / 5) ** 2, 49 / 8, 0.0]
    both = one * one / 18 - one * one / 50
    variance = sum(parts) + both
    for i, index in enumerate(told["metrics"][0]["indices"]):
        first, total = parts[i] / variance, (parts[i] + (both if i != 1 else 0)) / variance
        program.check(abs(index["first"] - first) < 0.02 and abs(index["total"] - total) < 0.02, index, first, total)
        program.check(index["first_95"][0] < first < index["first_95"][1], index, first)
    linear = told["metrics"][1]["indices"]
    program.check(abs(linear[0]["first"] - 1) < 0.02 and abs(linear[1]["total"]) < 1e-12, linear)
    program.check((folder / "ishigami/sweep.png").read_bytes()[:4] == b"\x89PNG")
    with open(folder / "ishigami/sweep.csv") as file:
        table = list(csv.DictReader(file))
    program.check(len(table) == n * (k + 2) and set(table[0]) == {"x1", "x2", "x3", "y", "z"})
    return max(abs(i["first"] - p / variance) for i, p in zip(told["metrics"][0]["indices"], parts))


def batches(folder):
    """Other points are another batch; text for a number is refused; a metric that hardly varies has no odd interval."""
    write(
        folder,
        "double.py",
        "import csv, sys\n"
        "rows = list(csv.DictReader(open(sys.argv[1])))\n"
        "x = [float(row['x']) for row in rows]\n"
        "lines = [f'{2 * v},{int(v > 3.9)}' for v in x]\n"
        "open(sys.argv[2], 'w').write('\\n'.join(['y,rare', *lines, '']))\n",
    )
    text = f"""format = 1
title = "batch"
method = "sobol"
base_points = 8
[[parameter]]
name = "x"
from = 0
to = 4
[batch]
run = ["{PYTHON}", "double.py", "{{points}}", "{{results}}"]
[[metric]]
name = "y"
[[metric]]
name = "rare"
"""
    for far in (4, 400):
        path = write(folder, "batch.toml", text.replace("to = 4", f"to = {far}"))
        program.run("sweep", path, "-o", folder / "batch", "--no-picture")
        with open(folder / "batch/sweep.csv") as file:
            rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
        program.check(all(row["y"] == 2 * row["x"] for row in rows) and max(r["x"] for r in rows) > far / 2, rows)
        for metric in json.loads((folder / "batch/sweep.json").read_text())["metrics"]:
            low, high = metric["indices"][0]["first_95"]
            program.check((low is None) == (high is None) and (low is None or low <= high), metric["indices"])
    write(folder, "double.py", "import sys\nopen(sys.argv[2], 'w').write('y,rare\\n' + 'n/a,0\\n' * 24)\n")
    done = program.run("sweep", path, "-o", folder / "batch", "--no-picture", status=2)
    program.check("'n/a'" in done.stderr, done.stderr)
    done = program.run("experiment", folder / "study.toml", "-o", folder / "batch", status=2)
    program.check("batch.toml" in done.stderr, done.stderr)  # another study's


def combinations(folder):
    """A step without a parameter is run once; points that were there are not run again."""
    slow = step("shared", "{a}", folder)
    last = f"""[[step]]
name = "last"
run = ["{PYTHON}", "work.py", "{{folder}}", "{{b}}", "{folder}", "last", "0", "{{shared}}"]
"""
    head = 'format = 1\ntitle = "t"\nmethod = "%s"\n'
    parameters = """[[parameter]]
name = "a"
values = [1, 2, 5]
[[parameter]]
name = "b"
from = 1
to = 100
scale = "log"
levels = 3
"""
    metrics = """[[metric]]
name = "m"
file = "{last}/out.json"
at = "/square"
[[metric]]
name = "s"
file = "{shared}/out.json"
at = "/a/b/0"
times = 2
"""
    sweep = write(folder, "grid.toml", head % "factorial" + parameters + slow + last + metrics)
    program.run("sweep", sweep, "-o", folder / "grid", "--no-picture")
    ran = runs(folder)
    program.check(ran.count("shared") == 3 and ran.count("last") == 9, ran)
    told = json.loads((folder / "grid/sweep.json").read_text())
    wanted = list(itertools.product((1, 2, 5), (1, 10, 100)))
    program.check(np.allclose(told["points"], wanted), told["points"])
    program.check(np.allclose(told["metrics"][0]["values"], [b * b for _, b in wanted]))
    program.check(np.allclose(told["metrics"][1]["values"], [2 * a for a, _ in wanted]))
    write(folder, "grid.toml", head % "one_at_a_time" + parameters + slow + last + metrics)
    program.run("sweep", sweep, "-o", folder / "grid")
    program.check(runs(folder) == [])
    told = json.loads((folder / "grid/sweep.json").read_text())
    program.check(
        [tuple(round(v, 9) for v in p) for p in told["points"]] == [(2, 10), (1, 10), (5, 10), (2, 1), (2, 100)]
    )
    program.check(told["metrics"][0]["spans"][1] == {"parameter": "b", "low": 1.0, "high": 10000.0}, told["metrics"][0])
    for more, says in (
        ("[[parameter]]\nname = 'a'\nvalues = [1]\n", "one name"),
        ("[[parameter]]\nname = 'c'\n", "either values"),
        ("[[parameter]]\nname = 'c'\nfrom = 0\nto = 3\nscale = 'log'\n", "above 0"),
        ("[batch]\nrun = ['true']\n", "steps or a batch"),
    ):
        write(folder, "bad.toml", head % "factorial" + parameters + slow + last + metrics + more)
        done = program.run("sweep", folder / "bad.toml", "-o", folder / "bad", status=2)
        program.check(says in done.stderr, says, done.stderr)
    write(folder, "bad.toml", head % "factorial" + parameters + slow + last.replace('"{b}"', '"x{b}"') + metrics)
    done = program.run("sweep", folder / "bad.toml", "-o", folder / "bad2", status=1)
    program.check("at a = 1, b = 1" in done.stderr, done.stderr)
    runs(folder)


PLAIN = HEAD + camera(pixels=6, lines=5, altitude_agl_m=500.0, samples="{ grid = [2, 2] }")
NAMED = '[[instrument]]\nname = "camera"\n'


def settings(folder):
    """--set is as good as an edited file, in it, in what it includes and in a sensor's file."""

    def image(text, *more, status=0):
        path = write(folder, "set.toml", text)
        done = program.run("render", path, "-o", folder / "set", "--overwrite", "-q", "-q", *more, status=status)
        return (folder / "set/camera/radiance.img").read_bytes() if status == 0 else done.stderr

    plain, sensor = PLAIN, PLAIN.split(NAMED)[1]
    apart = HEAD + NAMED + 'sensor = "sensor.toml"\n'
    edited = image(plain.replace("reflectance = 0.05", "reflectance = 0.4").replace("pixels = 6", "pixels = 9"))
    over = ("--set", "material.dark.reflectance=0.4")
    program.check(image(plain, *over, "--set", "instrument.camera.pixels=9") == edited)
    program.check(image(plain, *over, "--set", "instrument.0.pixels = 9") == edited)
    write(folder, "sensor.toml", "format = 1\n" + sensor)
    program.check(image(apart, *over, "--set", "instrument.camera.pixels=9") == edited)
    bands = ("--set", "instrument.camera.bands.count=2")
    program.check(len(image(apart, *bands)) == 2 * 6 * 5 * 4)
    write(folder, "part.toml", "format = 1\n[time.sun]\nzenith_deg = 30.0\nazimuth_deg = 90.0\nday_of_year = 180\n")
    included = plain.replace(
        "[time.sun]\nzenith_deg = 30.0\nazimuth_deg = 90.0\nday_of_year = 180\n", '[scene]\ninclude = ["part.toml"]\n'
    )
    turned = image(plain.replace("zenith_deg = 30.0", "zenith_deg = 60.0"))
    program.check(image(included, "--set", "time.sun.zenith_deg=60.0") == turned)
    told = json.loads((folder / "set/camera/run.json").read_text())["configuration"]
    image(plain, "--set", "tolerance=0.02")
    after = json.loads((folder / "set/camera/run.json").read_text())["configuration"]
    program.check((told["tolerance"], after["tolerance"]) == (0.01, 0.02), after["tolerance"])
    for value, says in (
        ("material.grass.reflectance=0.4", "material.grass"),
        ("instrument.camera.colour=3", "colour"),
        ("instrument.camera.pixels=many", "integer"),
        ("pixels", "KEY=VALUE"),
        ("tolerance=9", "tolerance"),
    ):
        said = image(plain, "--set", value, status=2)
        program.check(says in said, value, said)


def shipped(folder, scenes, park):
    """The experiment of scenes/avon is read to its end, its scene is sound, its sweeps have their points."""
    avon = scenes / "avon"
    done = program.run("experiment", avon / "experiment.toml", "-o", folder / "avon", "--dry-run")
    program.check(done.stdout.count(": to run") == len(done.stdout.splitlines()) >= 20, done.stdout)
    for name, points in (("ace", 9), ("indices", 8 * 5)):
        done = program.run("sweep", avon / f"{name}.toml", "--dry-run")
        program.check(len(done.stdout.splitlines()) == points + 1, name, done.stdout)
    shutil.copytree(park, folder / "4")
    if FULL:
        patience.run([PYTHON, scenes / "park/generate.py", folder / "1", "--species", "1"], check=True)
    for species in ("1", "4") if FULL else ("4",):
        (folder / species / "avon.toml").write_bytes((avon / "avon.toml").read_bytes())
        done = program.run("scene", "check", folder / species / "avon.toml")
        program.check("6 instruments" in done.stdout, done.stdout)


with tempfile.TemporaryDirectory() as scratch:
    top = pathlib.Path(scratch)
    text, first = kept(top)
    killed(top)
    refused(top, text, first)
    batches(top)
    combinations(top)
    settings(top)
    shipped(top, pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3]))
    print(f"studies: indices of Ishigami's function within {indices(top):.4f}, {program.checks} checks")

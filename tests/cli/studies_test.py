"""S56 S59: `raycube experiment`: steps that are kept, reports that hold everything, and `--set`. usage: studies_test.py
RAYCUBE SCENES PARK [--full], PARK a folder that scenes/park/generate.py wrote. Without --full: that park of four
species alone; one of one species takes 10 s to grow."""

import base64
import html.parser
import json
import os
import pathlib
import re
import shutil
import signal
import sys
import tempfile

import patience
from driver import FULL, Program
from optics_kit import HEAD, camera
from study_kit import PYTHON, WORK, runs, step, write

program = Program(sys.argv[1])

PNG = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)


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
    settings(top)
    shipped(top, pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3]))
    print(f"studies: {program.checks} checks")

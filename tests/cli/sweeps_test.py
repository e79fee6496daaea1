"""S57: `raycube sweep`: points by their parameters, steps that points share, indices of a function whose own are known
(Ishigami and Homma 1990). usage: sweeps_test.py RAYCUBE"""

import csv
import itertools
import json
import math
import pathlib
import sys
import tempfile

import numpy as np
from scipy.stats import qmc

from driver import Program
from study_kit import PYTHON, WORK, runs, step, write

program = Program(sys.argv[1])


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
    points = np.array([[p[f"x{i}"] for i in (1, 2, 3)] for p in told["points"]])
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
    backwards = (  # which the column of x tells
        "import sys\n"
        "x = open(sys.argv[1]).read().split()[:0:-1]\n"
        "lines = [v + ',1,0' for v in x]\n"
        "open(sys.argv[2], 'w').write('\\n'.join(['x,y,rare', *lines, '']))\n"
    )
    write(folder, "double.py", backwards)
    says = ["results.csv, row 1: x is ", "where the point has ", "in the order of the points"]
    program.refused("sweep", path, "-o", folder / "batch", "--no-picture", status=2, says=says)
    write(folder, "double.py", "import sys\nopen(sys.argv[2], 'w').write('y,rare\\n' + 'n/a,0\\n' * 24)\n")
    done = program.run("sweep", path, "-o", folder / "batch", "--no-picture", status=2)
    program.check("'n/a'" in done.stderr, done.stderr)
    other = write(folder, "other.toml", path.read_text())
    done = program.run("sweep", other, "-o", folder / "batch", "--no-picture", status=2)
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
    program.check(told["points"] == [{"a": a, "b": b, "m": b * b, "s": 2 * a} for a, b in wanted], told["points"])
    write(folder, "grid.toml", head % "one_at_a_time" + parameters + slow + last + metrics)
    program.run("sweep", sweep, "-o", folder / "grid")
    program.check(runs(folder) == [])
    told = json.loads((folder / "grid/sweep.json").read_text())
    program.check([(p["a"], p["b"]) for p in told["points"]] == [(2, 10), (1, 10), (5, 10), (2, 1), (2, 100)])
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


def changed_levels(folder):
    """What a figure takes of a sweep is its point by the parameters, whatever the levels: the same number while they
    are among them, and a refusal when they are not; never another point's."""
    last = step("power", "{x}", folder, "0", "{y}")
    metric = '[[metric]]\nname = "of all"\nfile = "{power}/out.json"\nat = "/square"\n'
    sweep = folder / "levels.toml"

    def levels(x, y="values = [7, 8]", method="factorial"):
        sweep.write_text(
            f'format = 1\ntitle = "t"\nmethod = "{method}"\n'
            + f'[[parameter]]\nname = "x"\n{x}\n[[parameter]]\nname = "y"\n{y}\n'
            + last
            + metric
        )

    def study(at):
        run = [str(program.path), "sweep", str(sweep), "--no-picture", "-o", "{folder}/sweep"]
        write(
            folder,
            "shown.toml",
            f'format = 1\ntitle = "t"\n[[step]]\nname = "grid"\nrun = {json.dumps(run)}\n[[figure]]\ntitle = "f"\n'
            f'[[figure.value]]\nname = "x = 3"\nfile = "{{grid}}/sweep/sweep.json"\nat = "{at}"\n',
        )
        return folder / "shown.toml", "-o", folder / "shown"

    def shown(at):
        out = program.run("experiment", *study(at), "--json")
        return json.loads(out.stdout)["figures"][0]["values"][0]["value"]

    levels("values = [1, 3]")
    program.check(shown("/points[x=3, y=7]/of all") == 9)
    program.check(sorted(runs(folder)) == ["power"] * 4)
    levels("values = [1, 2, 3, 4]")
    program.check(shown("/points[x=3, y=7]/of all") == 9)
    program.check(sorted(runs(folder)) == ["power"] * 4)  # those of 2 and of 4
    levels("from = 0.5\nto = 3\nlevels = 6", "values = [8]")
    program.check(shown("/points[ x=3.0,y = 8 ]/of all") == 9)
    program.check(len(runs(folder)) == 3)  # 0.5, 1.5 and 2.5; 1, 2 and 3 were levels before
    # 0.1 + 0.2 is 0.30000000000000004; a level of a range is the number that one types.
    levels("values = [0.3]")
    shown("/points[x=0.3, y=7]/of all")
    program.check(len(runs(folder)) == 2)
    levels("from = 0.1\nto = 0.5\nlevels = 5", "values = [7]")
    shown("/points[x=0.3]/of all")
    program.check(len(runs(folder)) == 4, "0.3 is there")
    kept = [json.loads(file.read_text()) for file in (folder / "shown/steps/grid/sweep/steps").glob("*/step.json")]
    program.check({"x": "0.3", "y": "7"} in [one["parameters"] for one in kept], kept)
    for at, says in (
        ("/points[x=3, y=7]/of all", ["0 elements of points are so; there are [x=0.1, y=7] [x=0.2, y=7]"]),
        ("/points[y=7]/of all", ["5 elements of points are so"]),
        ("/points[z=7]/of all", ["0 elements of points", "none of these keys"]),
        ("/points/1/of all", ["counts elements of a sweep's lists", "/points[x=VALUE, ...]/METRIC"]),
        ("/metrics/0/name", ["counts elements of a sweep's lists"]),
        ("/parameters/1/rest", ["counts elements of a sweep's lists"]),
    ):
        done = program.refused("experiment", *study(at), status=2, says=says)
        program.check(not (folder / "shown/report.html").exists(), done.stderr)
    program.check(shown("/parameters[name=y]/rest") == 7)
    # A run that fails leaves no table or chart of the levels before it.
    (folder / "apart").mkdir()
    program.run("sweep", sweep, "-o", folder / "apart")
    sweep.write_text(sweep.read_text().replace('"{x}"', '"no{x}"'))
    program.run("sweep", sweep, "-o", folder / "apart", status=1)
    program.check([f.name for f in (folder / "apart").glob("sweep.*")] == [])
    for values, says in (
        ("values = [1, 2, 1]", "given twice (found 1)"),
        ("values = [1, nan]", "not a finite number"),
        ("from = 1", "a range has two ends (found no 'to'); give it"),
        ("from = 1\nto = 2\nlevels = 2.5", "whole number"),
        ("from = 1\nto = 2\nlevels = 1001", "'levels' is out of range (found 1001); give a number 2 .. 1000"),
        ("from = 1\nto = 2\nlevel = 3", "unknown key in [[parameter]] (found 'level'); did you mean 'levels'?"),
        ("from = 1\nto = 2\nscale = 'cubic'", "choose of linear, log"),
    ):
        levels(values)
        program.refused("sweep", sweep, "--dry-run", status=2, says=[says])
    levels("values = [1]")
    sweep.write_text(sweep.read_text().replace('"of all"', '"y"'))
    program.refused("sweep", sweep, "--dry-run", status=2, says=["no other metric or parameter has it"])
    runs(folder)


with tempfile.TemporaryDirectory() as scratch:
    top = pathlib.Path(scratch)
    write(top, "work.py", WORK)
    batches(top)
    combinations(top)
    changed_levels(top)
    print(f"sweeps: indices of Ishigami's function within {indices(top):.4f}, {program.checks} checks")

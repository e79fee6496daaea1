"""What tests of experiments and sweeps share: a program that is a step, and who ran."""

import json
import sys

PYTHON = sys.executable

WORK = """import json, os, pathlib, sys, time
folder, value = pathlib.Path(sys.argv[1]), float(sys.argv[2])
with open(sys.argv[3] + "/log", "a") as log:
    log.write(sys.argv[4] + "\\n")
(folder / "pid").write_text(str(os.getpid()))
time.sleep(float(sys.argv[5]) if len(sys.argv) > 5 else 0)
(folder / "out.json").write_text(json.dumps({"a": {"b": [value, None, "text"]}, "square": value * value}))
"""


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

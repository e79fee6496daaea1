#!/usr/bin/env python3
"""What raycube starts ends with it, however that ends: by kill -9 and by two signals at once no process of a step goes
on, of its children neither, also where they do not hear SIGTERM; and a render that two signals end leaves no file and
no folder. usage: step_ends_test.py RAYCUBE"""

import os
import pathlib
import signal
import sys
import tempfile

import patience
from driver import Program, own_cache, scene

program = Program(sys.argv[1])
check = program.check

# A step's program and a child of it, in one process group; their numbers are written before they wait.
SCRIPT = "{trap}sleep 3600 & echo $! > child.new; mv child.new child; echo $$ > pid.new; mv pid.new pid; wait; wait"


def study(folder, trap):
    script = SCRIPT.format(trap=trap).replace('"', '\\"')
    path = folder / "study.toml"
    path.write_text(f"""format = 1
title = "ends"
[[step]]
name = "long"
run = ["sh", "-c", "cd {folder} && {script}"]
""")
    return path


def is_gone(pid):
    return patience.status_of(pid, "State")[:1] in ("", "Z", "X")


def steps(folder, trap, signals):
    """The study is ended by some signals at once, or by kill -9."""
    running = program.start("experiment", study(folder, trap), "-o", folder / "out")
    try:
        patience.until(lambda: (folder / "pid").exists(), "the step", running)
    except patience.Waited:
        running.kill()
        raise
    pids = [int((folder / name).read_text()) for name in ("pid", "child")]
    check(not any(map(is_gone, pids)))
    running.send_signal(signal.SIGSTOP)  # so that they arrive together
    for number in signals:
        running.send_signal(number)
    running.send_signal(signal.SIGCONT)
    out, err = patience.end_of(running)
    check(running.returncode == (-signal.SIGKILL if signal.SIGKILL in signals else 130), running.returncode, err)
    for pid in pids:
        patience.until(lambda: is_gone(pid), f"the end of a step's process after {signals}")
    check(True)


def render(folder, signals):
    """A render in the middle of its cube: no file, no folder that it made, no kernels' folder of its own."""
    cache = own_cache(folder)
    environment = {"XDG_CACHE_HOME": cache}
    file = scene(folder, "long.toml", pixels=2000, lines=2000, grid=11)
    process = program.mid_render(file, folder / "made/by/it", env=environment)
    store = pathlib.Path(cache) / "raycube/kernels"
    check(any(store.glob("run-*")), "the folder that is to go")
    for number in signals:
        process.send_signal(number)
    process.send_signal(signal.SIGCONT)
    out, err = patience.end_of(process)
    check(process.returncode == 130, process.returncode, err)
    check(not any(store.glob("run-*")), list(store.iterdir()))
    check(not (folder / "made").exists(), list((folder / "made").rglob("*")))


for trap in ("", "trap '' TERM; "):
    for signals in (
        (signal.SIGKILL,),
        (signal.SIGINT, signal.SIGTERM),
        (signal.SIGINT, signal.SIGTERM, signal.SIGHUP),
    ):
        if trap and len(signals) == 3:
            continue
        with tempfile.TemporaryDirectory() as made:
            steps(pathlib.Path(made), trap, signals)
for signals in ((signal.SIGINT,), (signal.SIGINT, signal.SIGTERM)):
    with tempfile.TemporaryDirectory() as made:
        render(pathlib.Path(made), signals)
print(f"step ends: {program.checks} checks")

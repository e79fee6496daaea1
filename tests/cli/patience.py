"""Waiting in tests: for what is to come, never for a while; and who waits in vain says for what, how long, and what was
last heard. A limit is there to end a test that hangs, not to measure: a machine that is slow or busy stays far from it.
"""

import os
import signal
import subprocess
import time

#: Seconds that one thing is waited for. Beside the other work of a test it is within CTest's limit on the whole test
#: (tests/CMakeLists.txt), which could not say what was waited for.
LIMIT_S = float(os.environ.get("RAYCUBE_TEST_PATIENCE_S", 600))
LAST_CHARACTERS = 2000


class Waited(AssertionError):
    """Something did not come in time."""


def _text(output):
    return output.decode(errors="replace") if isinstance(output, bytes) else output or ""


def _vain(what, seconds, *outputs):
    heard = "".join(f"\n{_text(output)[-LAST_CHARACTERS:]}" for output in outputs if output)
    return Waited(f"waited {seconds:.0f} s in vain for {what}; last output:{heard or ' none'}")


def _words(command):
    return " ".join(map(str, command))


def run(command, **more):
    """subprocess.run of a list of words, with the limit."""
    command = [str(word) for word in command]
    more.setdefault("timeout", LIMIT_S)
    try:
        return subprocess.run(command, **more)
    except subprocess.TimeoutExpired as expired:
        raise _vain(f"the end of `{_words(command)}`", more["timeout"], expired.stdout, expired.stderr) from None


def end_of(process):
    """(stdout, stderr) of a started process once it has ended."""
    try:
        return process.communicate(timeout=LIMIT_S)
    except subprocess.TimeoutExpired as expired:
        process.kill()
        raise _vain(f"the end of `{_words(process.args)}`", LIMIT_S, expired.stdout, expired.stderr) from None


def _left_by(process):
    """What a process has said, which is ended if it was not; children of it that live may hold its streams open."""
    process.kill()
    try:
        return process.communicate(timeout=10)
    except subprocess.TimeoutExpired as expired:
        return expired.stdout, expired.stderr


def until(condition, what, process=None, glance_s=0.01):
    """What `condition` returns once that is true; an error at once when `process`, which is to bring it about, ends
    before."""
    begin = time.monotonic()
    while True:
        ended = process is not None and process.poll() is not None
        if found := condition():
            return found
        if ended:
            heard = "".join(map(_text, _left_by(process)))[-LAST_CHARACTERS:]
            raise Waited(f"`{_words(process.args)}` ended with {process.returncode} before {what}\n{heard}")
        if time.monotonic() - begin > LIMIT_S:
            raise _vain(what, LIMIT_S, *(_left_by(process) if process is not None else ()))
        time.sleep(glance_s)


def status_of(pid, field):
    """A line of /proc/PID/status; empty when there is no such process."""
    try:
        with open(f"/proc/{pid}/status") as file:
            return next((line.split(None, 1)[1].strip() for line in file if line.startswith(field + ":")), "")
    except OSError:
        return ""


def halted(process):
    """Stops a process where it is, unless it has ended: signals that follow reach it with SIGCONT."""
    process.send_signal(signal.SIGSTOP)
    until(
        lambda: process.poll() is not None or status_of(process.pid, "State").startswith("T"), "the process to stop"
    )
    return process


def signalled(process, number):
    """(stdout, stderr) of a halted process that goes on with this signal, and ends."""
    process.send_signal(number)
    process.send_signal(signal.SIGCONT)
    return end_of(process)

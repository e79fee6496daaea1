"""Peak memory of a program, so that two of its runs can be compared whatever else the machine does."""

import os
import statistics
import subprocess

import patience

#: One heap for all threads, of which large blocks are no part: how many heaps there are, and what is left of them,
#: otherwise hangs on the number of processors and on which thread comes first.
STEADY = {"MALLOC_ARENA_MAX": "1", "MALLOC_MMAP_THRESHOLD_": "131072", "MALLOC_TRIM_THRESHOLD_": "131072"}


def _end_of(child):
    def ended():
        pid, status, usage = os.wait4(child.pid, os.WNOHANG)
        return (status, usage) if pid else None

    try:
        return patience.until(ended, f"the end of `{' '.join(child.args)}`")
    except patience.Waited:
        child.kill()
        raise


def typical(command, each=lambda found: None, runs=3):
    """Bytes: the median of some runs, since a run sees more or less of its libraries' files in memory by how full of
    other files the machine's is. A run before them fills the kernel cache: a compiler in the process costs memory of
    its own. `each` is told of every run's. The caller fixes the number of threads, each of which has its buffers."""
    found = []
    for _ in range(1 + runs):
        child = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, env={**os.environ, **STEADY})
        status, usage = _end_of(child)
        assert status == 0, (command, status)
        found.append(usage.ru_maxrss * 1024)
        each(found[-1])
    print(*(f"{peak / (1 << 20):.1f}" for peak in found[1:]), "MiB", end=": ")
    return statistics.median(found[1:])

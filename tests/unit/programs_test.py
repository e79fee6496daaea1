#!/usr/bin/env python3
"""Counts the OpenCL programs that the tests compiled, and names the tests that asked for each: most of the time of a
first run is PoCL compiling kernels, so a program more is minutes more on every machine.
usage: programs_test.py FOLDER --begin            empties the folder, before the tests
       programs_test.py FOLDER [--build FILE] [--most N] [--json FILE]  after them: fails when they compiled more than N
                                                                        programs
FOLDER holds a file TEST.tsv for each test, which its processes wrote (RAYCUBE_PROGRAM_LOG, host/cl/program.cpp): name,
hash, "compiled" or "kept", options. FILE is the same of the build (cmake/CompileKernels.cmake). Two programs are the
same when name and options are: one that is compiled for several devices (digests, for two sets of instructions where a
processor has AVX-512; oclgrind) counts once, and how many times it is one more is told. Sources of a few lines that
tests of the cache and of error messages make up are listed apart: they take milliseconds."""

import argparse
import collections
import json
import pathlib
import shutil
import sys

TRIFLES = {"add_one", "broken", "double_and_add", "probe_structs"}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--begin", action="store_true")
    parser.add_argument("--build", type=pathlib.Path)
    parser.add_argument("--most", type=int, default=40)
    parser.add_argument("--json", type=pathlib.Path)
    given = parser.parse_args()
    if given.begin:
        shutil.rmtree(given.folder, ignore_errors=True)
        given.folder.mkdir(parents=True)
        return 0
    tests = collections.defaultdict(list)  # by program, in the tests' order of names
    hashes, compiled = collections.defaultdict(list), 0
    built = [given.build] if given.build and given.build.exists() else []
    for file in built + sorted(given.folder.glob("*.tsv")):
        for line in file.read_text().splitlines():
            name, key, how, asked = line.split("\t")
            compiled += how == "compiled"
            program = name, " ".join(asked.split())
            if key not in hashes[program]:
                hashes[program].append(key)
            if file.stem not in tests[program]:
                tests[program].append(file.stem)
    programs = sorted(p for p in tests if p[0] not in TRIFLES)
    trifles = len(tests) - len(programs)
    for program in programs:
        asking = tests[program]
        shown = ", ".join(asking[:4]) + (f" and {len(asking) - 4} more" if len(asking) > 4 else "")
        print(f"{program[0]} {' '.join(key[:8] for key in hashes[program])} [{program[1]}]: {shown}")
    again = sum(len(hashes[program]) - 1 for program in programs)
    print(
        f"{len(programs)} programs (at most {given.most}), {again} times one of them for another device, and {trifles} "
        f"of a few lines; compiled {compiled} times"
    )
    if given.json:
        given.json.write_text(json.dumps({
            "programs": len(programs), "trifles": trifles, "compilations": compiled,
            "for_other_devices": again,
            "list": [{"name": p[0], "options": p[1], "hashes": hashes[p], "tests": tests[p]} for p in programs]}))
    if len(programs) > given.most:
        print(f"FAILED: {len(programs)} programs are more than {given.most}. Make what differs an argument of the "
              "kernel (TileShape in kernels/shared/structs.def), or give the test the sizes that others have.")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

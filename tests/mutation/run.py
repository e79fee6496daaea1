#!/usr/bin/python3
"""Builds every fault of mutations.toml in turn and shows which named test catches it.

    tests/mutation/run.py [NAME ...]            (all when none is named; takes minutes: each is a build and a test)

Exit status 1 when a fault survives its test. The table it prints goes into docs/mutations.md.
"""
import os
import pathlib
import subprocess
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parents[2]


def run(*command, **more):
    return subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more)


def main():
    mutations = tomllib.loads((ROOT / "tests/mutation/mutations.toml").read_text())["mutation"]
    wanted = sys.argv[1:]
    unknown = set(wanted) - {m["name"] for m in mutations}
    if unknown:
        sys.exit(f"no mutation called {', '.join(sorted(unknown))}")
    build = ROOT / "build-mutation"
    survivors = []
    print("| fault | file | caught by | verdict |\n|---|---|---|---|", flush=True)
    for mutation in [{"name": "none", "file": "-", "test": "|".join(sorted({m["test"] for m in mutations}))}] + [
            m for m in mutations if not wanted or m["name"] in wanted]:
        configured = run("cmake", "-S", ROOT, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                         f"-DRAYCUBE_MUTATION={mutation['name']}")
        target = [t for name in mutation["test"].split("|") for t in ("--target", "test_" + name)]
        made = run("cmake", "--build", build, *target) if configured.returncode == 0 else configured
        if made.returncode != 0:
            sys.exit(f"{mutation['name']}: the build failed\n{made.stdout[-3000:]}")
        tested = run("ctest", "--test-dir", build, "--no-tests=error", "-R", f"^({mutation['test']})$", env=os.environ)
        caught = tested.returncode != 0
        expected = mutation["name"] != "none"
        if caught != expected:
            survivors.append(mutation["name"])
        verdict = ("caught" if caught else "SURVIVED") if expected else ("FAILS UNCHANGED" if caught else "all pass")
        print(f"| {mutation['name']} | {mutation['file']} | {mutation['test'] if expected else '-'} | {verdict} |", flush=True)
        if not expected and caught:
            sys.exit(tested.stdout[-3000:])
    if survivors:
        sys.exit("not as expected: " + ", ".join(survivors))


if __name__ == "__main__":
    main()

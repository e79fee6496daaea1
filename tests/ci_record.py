#!/usr/bin/env python3
"""Writes build/ci-test.json at the end of ci/test: which tree passed, and what it took. Prints nothing.
usage: ci_record.py BUILD --status N [--full] PART=SECONDS ..."""

import argparse
import json
import pathlib
import platform
import subprocess
import time
import xml.etree.ElementTree


def git(*words):
    done = subprocess.run(["git", *words], capture_output=True, text=True, check=False)
    return done.stdout.strip() if done.returncode == 0 else None


def instruction_set():
    flags = set()
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("flags"):
            flags = set(line.split())
            break
    return "avx512" if "avx512f" in flags else "avx2" if "avx2" in flags else platform.machine()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--status", type=int, required=True)
    parser.add_argument("--full", action="store_true")
    parser.add_argument("parts", nargs="+")
    given = parser.parse_args()
    seconds = {name: int(value) for name, value in (part.split("=") for part in given.parts)}
    changed = git("status", "--porcelain")
    record = {
        "commit": git("rev-parse", "HEAD"), "clean": None if changed is None else changed == "",
        "finished": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()), "full": given.full, "passed": given.status == 0,
        "seconds": seconds | {"total": sum(seconds.values())}, "instruction_set": instruction_set(),
    }
    results = given.build / "ci-test.xml"
    if results.exists():
        cases = list(xml.etree.ElementTree.parse(results).getroot().iter("testcase"))
        status = {case.get("name"): case.get("status") for case in cases}
        record["tests"] = {
            "passed": sum(value == "run" for value in status.values()),
            "failed": sorted(name for name, value in status.items() if value == "fail"),
            "skipped": sorted(name for name, value in status.items() if value not in ("run", "fail")),
            "seconds": {case.get("name"): round(float(case.get("time")), 2)
                        for case in sorted(cases, key=lambda case: -float(case.get("time")))},
        }
    programs = given.build / "tests/programs.json"
    if programs.exists():
        counted = json.loads(programs.read_text())
        record["programs"] = {"different": counted["programs"], "compiled": counted["compilations"]}
    (given.build / "ci-test.json").write_text(json.dumps(record, indent=1) + "\n")


if __name__ == "__main__":
    main()

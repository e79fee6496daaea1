#!/usr/bin/python3
"""Builds every fault of mutations.toml in turn and shows which named test catches it.

    tests/mutation/run.py [--output FILE.md] [NAME ...]     (all when none is named: ten minutes on two cores once
    built)

A fault counts as caught when every one of its tests fails by an assertion of its own; a kernel that no longer builds,
an exception, a skipped test or a timeout do not count. Before the faults, their tests must all pass on the unchanged
source.
Exit status 1 when anything is not as expected. Builds in build-mutation/, which is kept.
"""

import argparse
import datetime
import pathlib
import subprocess
import sys
import time
import tomllib
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build-mutation"
TIMEOUT_S = 1500


def run(*command):
    return subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def build(mutation, tests):
    """Plants the fault and builds the tests; the program's end with the last lines when that fails."""
    steps = [
        (
            "cmake",
            "-S",
            ROOT,
            "-B",
            BUILD,
            "-G",
            "Ninja",
            "-DCMAKE_BUILD_TYPE=Release",
            "-DRAYCUBE_UNITY=OFF",  # a fault is one file
            f"-DRAYCUBE_MUTATION={mutation}",
        ),
        ("cmake", "--build", BUILD, *(word for test in tests for word in ("--target", "test_" + test))),
    ]
    for step in steps:
        done = run(*step)
        if done.returncode != 0:
            sys.exit(f"{mutation}: {step[1]} failed\n{done.stdout[-3000:]}")


def case_of(output):
    """Name of the first doctest case with a failed assertion, or None. Exceptions and crashes are no assertions."""
    case = None
    for line in output.splitlines():
        if line.startswith("TEST CASE:"):
            case = line.removeprefix("TEST CASE:").strip()
        elif case and "ERROR:" in line and "THREW exception" not in line and "CRASHED" not in line:
            return case
    return None


def ask(tests):
    """Of each test: None when it passed, else (caught by an assertion, case or what happened)."""
    report = BUILD / "mutation-tests.xml"
    report.unlink(missing_ok=True)
    done = run(
        "ctest",
        "--test-dir",
        BUILD,
        "--no-tests=error",
        "--timeout",
        TIMEOUT_S,
        "--output-junit",
        report,
        "-R",
        f"^({'|'.join(tests)})$",
    )
    if not report.is_file():
        sys.exit(f"ctest wrote no report\n{done.stdout[-3000:]}")
    answers = {}
    for case in xml.etree.ElementTree.parse(report).getroot().iter("testcase"):
        output = case.findtext("system-out") or ""
        if case.get("status") == "run":
            answers[case.get("name")] = None
        else:
            found = case_of(output)
            answers[case.get("name")] = (
                found is not None,
                found or f"{case.get('status')}: " + " ".join(output.split())[-300:],
            )
    return {test: answers.get(test, (False, "did not run")) for test in tests}


def cell(text):
    return text.replace("|", "/")


PAGE_HEAD = """# Planted faults

Each entry of `mutations.toml` is one wrong line of code; `cmake -DRAYCUBE_MUTATION=NAME` builds a copy of the source
with it planted. A fault counts as caught when every test named with it fails by an assertion of its own; on the
unchanged source all of these tests pass. The verdict names commit and day of the fault's last run. Written by
`tests/mutation/run.py --output tests/mutation/caught.md [NAME ...]`; rows of faults that are not run stay.

"""


def write_table(path, lines, names, whole):
    """The page of a whole run, or the page with the rows of the faults that were run anew."""
    rows = {}
    if path.is_file() and not whole:
        rows = {line.split("|")[1].strip(): line for line in path.read_text().splitlines() if line.startswith("| ")}
    rows.update({line.split("|")[1].strip(): line for line in lines[2:]})
    table = lines[:2] + [rows[name] for name in names if name in rows]
    path.write_text(PAGE_HEAD + "\n".join(table) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--output", type=pathlib.Path, help="also write the table to this file; rows of faults not run stay"
    )
    parser.add_argument("names", nargs="*", metavar="NAME")
    arguments = parser.parse_args()
    mutations = tomllib.loads((ROOT / "tests/mutation/mutations.toml").read_text())["mutation"]
    unknown = set(arguments.names) - {m["name"] for m in mutations}
    if unknown:
        sys.exit(f"no mutation called {', '.join(sorted(unknown))}")
    chosen = [m for m in mutations if not arguments.names or m["name"] in arguments.names]
    start = time.monotonic()
    commit = run("git", "-C", ROOT, "describe", "--always", "--dirty").stdout.strip()

    all_tests = sorted({test for m in chosen for test in m["test"].split("|")})
    build("none", all_tests)
    for test, answer in ask(all_tests).items():
        if answer:
            sys.exit(f"{test} does not pass on the unchanged source: {answer[1]}")
    print(f"unchanged: all {len(all_tests)} tests pass", flush=True)

    lines = ["| fault | what is wrong | file | test and the case that fails first | verdict |", "|---|---|---|---|---|"]
    print("\n".join(lines), flush=True)
    survivors = []
    for mutation in chosen:
        tests = mutation["test"].split("|")
        build(mutation["name"], tests)
        answers = ask(tests)
        caught = all(answer and answer[0] for answer in answers.values())
        if not caught:
            survivors.append(mutation["name"])
        by = "; ".join(f"`{test}`: {answer[1] if answer else 'PASSES'}" for test, answer in answers.items())
        lines.append(
            "| "
            + " | ".join(
                cell(text)
                for text in (
                    mutation["name"],
                    mutation["why"],
                    mutation["file"],
                    by,
                    f"{'caught' if caught else 'SURVIVED'} ({commit}, {datetime.date.today()})",
                )
            )
            + " |"
        )
        print(lines[-1], flush=True)

    summary = (
        f"{len(chosen) - len(survivors)} of {len(chosen)} faults caught in {(time.monotonic() - start) / 60:.0f} "
        f"minutes."
    )
    print(summary)
    if arguments.output:
        write_table(arguments.output, lines, [m["name"] for m in mutations], whole=not arguments.names)
    if survivors:
        sys.exit("not caught: " + ", ".join(survivors))


if __name__ == "__main__":
    main()

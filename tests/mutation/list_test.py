#!/usr/bin/python3
"""Checks that mutations.toml fits the sources: list_test.py SOURCE_DIR

Every fault's original text occurs exactly once in its file and on one line, its tests exist as targets test_<name>, and
tests/mutation/caught.md shows each fault caught. Whether the tests really catch them, run.py tells.
"""

import pathlib
import re
import sys
import tomllib

KEYS = {"name", "file", "from", "to", "test", "why"}
FEWEST = 18


def test_targets(root):
    """Names that tests/*.cmake give to raycube_test: each is a target test_<name> and a ctest name."""
    return {
        name
        for part in (root / "tests").glob("*.cmake")
        for name in re.findall(r"^\s*raycube_test\((\w+)", part.read_text(), re.M)
    }


def problems(root):
    mutations = tomllib.loads((root / "tests/mutation/mutations.toml").read_text())["mutation"]
    targets = test_targets(root)
    shown = dict(re.findall(r"^\| (\w+) \|.*\| (\w+)[^|]*\|$", (root / "tests/mutation/caught.md").read_text(), re.M))
    names = [m.get("name", "?") for m in mutations]
    for name in sorted({n for n in names if names.count(n) > 1}):
        yield f"{name}: occurs {names.count(name)} times; give each fault its own name"
    if len(mutations) < FEWEST:
        yield f"{len(mutations)} faults, at least {FEWEST} are asked for"
    for name in sorted(set(shown) - set(names) - {"fault", "none"}):
        yield f"{name}: tests/mutation/caught.md shows it, mutations.toml has no such fault; run run.py anew"
    for m in mutations:
        name = m.get("name", "?")
        if set(m) != KEYS or not all(isinstance(value, str) for value in m.values()):
            yield f"{name}: has keys {sorted(m)}, must have {sorted(KEYS)}, all text"
            continue
        path = root / m["file"]
        count = path.read_text().count(m["from"]) if path.is_file() else 0
        if count != 1:
            yield f"{name}: its original text occurs {count} times in {m['file']}, must be once: {m['from']}"
        if "\n" in m["from"] + m["to"] or m["from"] == m["to"]:
            yield f"{name}: must change one line"
        for test in m["test"].split("|"):
            if test not in targets:
                yield f"{name}: no raycube_test({test} ...) in tests/*.cmake"
        if shown.get(name) != "caught":
            yield f"{name}: tests/mutation/caught.md does not show it caught; run run.py --output on it"


def main():
    found = list(problems(pathlib.Path(sys.argv[1])))
    print("\n".join(found) if found else "the list of faults fits the sources")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()

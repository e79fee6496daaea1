#!/usr/bin/python3
"""Checks docs/requirements.md: requirement_list_test.py SOURCE_DIR

Every number (S15, A-13, L-29, S4.9, AIR 9, DESIGN 5a ...) that occurs in a tracked file is defined there once; every
test that a row names exists; and every row either is used somewhere and names a test, or says "not yet".
"""

import importlib.util
import pathlib
import re
import sys

PAGE = "docs/requirements.md"
ROW = re.compile(r"^\| ([A-Z][^|]*?) \| (.*) \| (.*) \|$", re.M)
# Other things of these names: words of SHA-256, amplitudes of Mie's theory.
OTHER_THINGS = {"host/base/sha256.cpp", "atmos_tables/optics/mie_angles.cpp", "atmos_tables/optics/mie_angles.h"}
NUMBER = re.compile(
    r"(?<![\w.-])(?:(?P<plain>S[1-9]\d?(?:\.\d+)?|[AL]-\d\d)(?![\w-])"
    r"|(?P<book>AIR|DESIGN|LIDAR|LIGHT|REQUIREMENTS|PERFORMANCE)(?:\.md)?(?: sections?)? "
    r"(?P<chapter>\d+[ab]?(?:\.\d+)?)(?![\w-])(?: and (?P<second>\d+[ab]?)(?![\w-]))?)"
)
INVARIANT = re.compile(r"(?<![\w.-])I[1-8](?![\w.-])")


def numbers(name, text):
    """What a file cites. Chapters of the LIDAR specification are written with a dot, so that "LIDAR 2" is none."""
    text = re.sub(r"\n\s*(?://+|#|\*)?\s*", " ", text)
    for found in NUMBER.finditer(text):
        if found["plain"]:
            yield found["plain"]
        elif found["book"] != "LIDAR" or "." in found["chapter"]:
            yield f"{found['book']} {found['chapter']}"
            if found["second"]:
                yield f"{found['book']} {found['second']}"
    if re.match(r"tests/\w+/lidar_", name):
        yield from (found[0] for found in INVARIANT.finditer(text))


def module(root, name):
    spec = importlib.util.spec_from_file_location(name, root / f"tests/unit/{name}.py")
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


def used_numbers(root):
    """Number -> the first file that cites it; data and generated pages cite nothing."""
    width, used = module(root, "line_width_test"), {}
    for name in sorted(width.tracked(root)):
        if not width.written_by_hand(name) or name == PAGE or name in OTHER_THINGS or name.endswith(".inc"):
            continue
        for number in numbers(name, (root / name).read_text(encoding="utf-8")):
            used.setdefault(number, name)
    return used


def problems(root):
    rows = ROW.findall((root / PAGE).read_text())
    defined = [row[0] for row in rows]
    used = used_numbers(root)
    known = module(root, "stability_list_test").ctest_names(root)
    for number in sorted({n for n in defined if defined.count(n) > 1}):
        yield f"{PAGE} defines {number} {defined.count(number)} times"
    for number in sorted(set(used) - set(defined)):
        yield f"{used[number]} cites {number}, which {PAGE} does not define"
    for number, text, tests in rows:
        names = re.findall(r"`(\w+)`", tests)
        for test in names:
            if test not in known:
                yield f"{PAGE}: {number} names '{test}', and tests/*.cmake have no such test"
        if "not yet" not in text and not names:
            yield f"{PAGE}: {number} names no test and does not say 'not yet'"
        if "not yet" not in text and number not in used:
            yield f"{PAGE}: {number} is cited nowhere and does not say 'not yet'"


def main():
    root = pathlib.Path(sys.argv[1])
    found = list(problems(root))
    count = len(ROW.findall((root / PAGE).read_text()))
    print("\n".join(found) if found else f"{PAGE}: {count} numbers, each defined, used and shown, or not yet")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()

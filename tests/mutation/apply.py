#!/usr/bin/python3
"""Copies the source tree and plants one named fault in the copy.

    apply.py NAME SOURCE_DIR COPY_DIR

The faults stand in mutations.toml, one line of code each. A file of the copy is rewritten only when its contents
change, so that building one fault after the other in the same build directory compiles only what differs.
"""

import pathlib
import shutil
import subprocess
import sys
import tomllib


def planted(mutation, text, path):
    """The text with the fault planted; the original must occur exactly once."""
    count = text.count(mutation["from"])
    if count != 1:
        sys.exit(
            f"mutation {mutation['name']}: its original text occurs {count} times in {path}, not once; mend "
            f"mutations.toml"
        )
    return text.replace(mutation["from"], mutation["to"])


def main():
    name, source, copy = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    mutations = tomllib.loads((source / "tests/mutation/mutations.toml").read_text())["mutation"]
    chosen = next((m for m in mutations if m["name"] == name), None)
    if chosen is None and name != "none":
        sys.exit(f"no mutation '{name}'; there are: none, " + ", ".join(m["name"] for m in mutations))
    tracked = subprocess.run(
        ["git", "-C", source, "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        check=True,
        capture_output=True,
    ).stdout
    for relative in filter(None, tracked.decode().split("\0")):
        origin, target = source / relative, copy / relative
        if not origin.is_file():
            continue
        data = origin.read_bytes()
        if chosen and relative == chosen["file"]:
            data = planted(chosen, data.decode(), relative).encode()
        if target.is_file() and target.read_bytes() == data:
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(data)
        shutil.copymode(origin, target)


if __name__ == "__main__":
    main()

#!/usr/bin/python3
"""Files that the pages name are there: page_paths_test.py ROOT

Reads what stands in backticks in README.md, CONTRIBUTING.md and docs/*.md. A word that begins with a folder of the
repository must be a file or a folder of it; NAME, * and {a,b} stand for anything, {h,cpp} for each of the two. What a
page describes as a user's own (build/..., out/...) is not asked for.
"""
import glob
import itertools
import pathlib
import re
import sys

FOLDERS = ("atmos_tables", "bench", "ci", "cmake", "docs", "host", "kernels", "scene_compiler", "scenes", "tests")


def choices(word):
    """a.{h,cpp} as a.h and a.cpp."""
    parts = re.split(r"\{([^{}]*)\}", word)
    lists = [[part] if i % 2 == 0 else part.split(",") for i, part in enumerate(parts)]
    return ["".join(chosen) for chosen in itertools.product(*lists)]


def missing(root, page):
    for number, line in enumerate(page.read_text().split("\n"), 1):
        for words in re.findall(r"`([^`]+)`", line):
            for word in words.split():
                word = word.rstrip(".,;:")
                if not re.match(rf"(?:{'|'.join(FOLDERS)})/[\w./{{}},*-]+$", word):
                    continue
                for one in choices(word):
                    pattern = re.sub(r"[A-Z]{2,}", "*", one) if not (root / one).exists() else one
                    if not glob.glob(str(root / pattern)):
                        yield f"{page.relative_to(root)}:{number}: names {word}, which is not there"


def main():
    root = pathlib.Path(sys.argv[1])
    pages = [root / "README.md", root / "CONTRIBUTING.md", *sorted((root / "docs").glob("*.md"))]
    faults = [fault for page in pages for fault in missing(root, page)]
    print("\n".join(faults) or f"{len(pages)} pages name files that are there")
    sys.exit(1 if faults else 0)


main()

#!/usr/bin/python3
"""docs/tutorial.md works as it is printed: every block is written or run in order in an empty folder, and what the page
shows of the output is what comes. usage: tutorial_test.py RAYCUBE TUTORIAL.md

Blocks by their first line: ```toml NAME and ```csv NAME are files; ```sh and ```python are run; ```text must be found
line by line in what the block before it printed, words equal and numbers within 3 %.
"""

import os
import pathlib
import re
import sys
import tempfile

import patience

BLOCK = re.compile(r"^```(\w+)(?: (\S+))?\n(.*?)^```$", re.M | re.S)
WITHIN = 0.03


def same(shown, found):
    words, others = shown.split(), found.split()
    return len(words) == len(others) and all(map(same_word, words, others))


def same_word(shown, found):
    try:
        return abs(float(shown) - float(found)) <= WITHIN * abs(float(shown))
    except ValueError:
        return shown == found


def run(command, folder, path):
    environment = dict(os.environ, PATH=f"{path}:{os.environ['PATH']}")
    done = patience.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{command}: status {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def main():
    program, page = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).read_text()
    blocks = BLOCK.findall(page)
    counts = {kind: sum(block[0] == kind for block in blocks) for kind in ("toml", "csv", "sh", "python", "text")}
    if sum(counts.values()) != len(blocks) or not all(counts.values()) or page.count("\n```") != 2 * len(blocks):
        sys.exit(f"blocks of the page: {counts}, {len(blocks)} in all, {page.count(chr(10) + '```')} marks")
    output = ""
    with tempfile.TemporaryDirectory() as folder:
        for kind, name, text in blocks:
            if kind in ("toml", "csv"):
                (pathlib.Path(folder) / name).write_text(text)
            elif kind == "sh":
                output = run(["bash", "-euc", text], folder, program.parent)
            elif kind == "python":
                output = run([sys.executable, "-c", text], folder, program.parent)
            else:
                for line in text.splitlines() or [""]:
                    if not any(same(line, found) for found in output.splitlines()):
                        sys.exit(f"the page shows\n  {line}\nand what comes is\n{output}")
    print(f"{len(blocks)} blocks of the tutorial work as printed")


if __name__ == "__main__":
    main()

"""No source is compiled for two targets: what several programs need is a library that they link.

Reads the build's compile_commands.json (first argument); each entry's object lies in its target's folder. A command of
a unity build stands for the sources that its file includes.
"""

import collections
import json
import pathlib
import re
import sys


def sources_of(file):
    """The sources that a command compiles: its file, or what CMake's unity file includes."""
    if not re.search(r"/Unity/unity_\d+_cxx\.cxx$", file):
        return [file]
    return re.findall(r'#include "(.+\.cpp)"', pathlib.Path(file).read_text())


def targets_of(commands):
    """{source: [targets]}, a target as often as it compiles the source."""
    targets = collections.defaultdict(list)
    for command in commands:
        target = re.search(r"CMakeFiles/([^/ ]+)\.dir/", command["command"])
        for source in sources_of(command["file"]):
            targets[source].append(target.group(1) if target else "?")
    return targets


def compiled_again(commands):
    """{source: [targets]} of sources that more than one command compiles."""
    targets = targets_of(commands)
    return {source: names for source, names in targets.items() if len(names) > 1}


def main():
    example = [
        {"file": "a.cpp", "command": "c++ -o x/CMakeFiles/one.dir/a.cpp.o -c a.cpp"},
        {"file": "b.cpp", "command": "c++ -o x/CMakeFiles/one.dir/b.cpp.o -c b.cpp"},
        {"file": "a.cpp", "command": "c++ -o x/CMakeFiles/two.dir/a.cpp.o -c a.cpp"},
    ]
    assert compiled_again(example) == {"a.cpp": ["one", "two"]}, "the search misses a source compiled twice"
    commands = json.loads(pathlib.Path(sys.argv[1]).read_text())
    sources = len(targets_of(commands))
    assert sources > 400, f"{sys.argv[1]} lists {sources} sources: not a whole build"
    again = compiled_again(commands)
    for source, names in sorted(again.items()):
        print(f"{source}: compiled for {', '.join(names)}; make it a library that they link")
    print(f"{sources} sources, {len(again)} of them compiled again")
    return 1 if again else 0


sys.exit(main())

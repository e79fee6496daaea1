#!/usr/bin/python3
"""No function past 100 lines, no file of code past 500, no kernel entry past 150: function_length_test.py SOURCE_DIR

Held to it are the C++, OpenCL C and Python of the tree, methods and cases of tests as much as functions. A function
counts from the first line of its header, without the comment before it, to its closing brace; a function inside
another counts for both. Tables have files of their own (.inc, .def) and are exempt. Braces are found by the
indentation that clang-format gives them: what opens at a column closes there, and members of a class stand two
columns further in.
"""

import ast
import importlib.util
import pathlib
import re
import sys

FUNCTION, FILE, ENTRY = 100, 500, 150
C_LIKE = {".cpp", ".h", ".cl"}
NOT_CODE = re.compile(
    r'(?s)R"(?P<mark>\w*)\(.*?\)(?P=mark)"|/\*.*?\*/|//[^\n]*'
    r'|"(?:\\.|[^"\\\n])*"'
    r"|(?<!\w)'(?:\\.|[^'\\\n])+'"
)
ATTRIBUTE = re.compile(r"(?:__attribute__|alignas)\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*\)")
TYPE = re.compile(r"(template\s*)?(typedef )?(class|struct|union|enum)\b")
SAME_COLUMN = re.compile(r'((inline )?namespace\b|extern "")[^(]*$')  # what is inside stands no further in


def without_text(source):
    """The same lines without what stands between quotes and without comments, of which a line of its own keeps a
    stroke: it does not end a header as an empty line does."""

    def rest(found):
        ends = "\n" * found[0].count("\n")
        if not found[0].startswith("/"):
            return '""' + ends
        alone = not source[source.rfind("\n", 0, found.start()) + 1 : found.start()].strip()
        return ("/" if alone else "") + ends

    return NOT_CODE.sub(rest, source)


def without_templates(header):
    """Without attributes and template arguments, so that the first bracket opens a function's parameters."""
    longer, shorter = "", ATTRIBUTE.sub("", header)
    while shorter != longer:
        longer, shorter = shorter, re.sub(r"<[^<>]*>", "", shorter)
    return shorter.strip()


def name_of(header):
    found = re.search(r"((?:\w+::)*(?:operator\s*[^\s\w(]+|operator\s+\w+|operator\(\)|~?\w+))\s*(?:\(|= \[)", header)
    return found[1] if found else header


def indentation(line):
    return len(line) - len(line.lstrip(" "))


def is_initializer(header):
    """A list in braces, not a body: behind an equals sign, or behind a name alone."""
    if re.search(r"(?<!operator)=\s*\{+$|\{\{$", header):
        return True
    return not re.search(r"[(\[]", header) and not TYPE.match(header)


def past_initializer(lines, at, last):
    """The line behind the one where the braces balance; a list may close at the end of its last row."""
    depth = 0
    while at < last:
        depth += lines[at].count("{") - lines[at].count("}")
        at += 1
        if depth <= 0:
            break
    return at


def c_functions(lines, first=0, last=None, indent=0):
    """(name, first line from 0, number of lines) of each function in lines[first:last] that starts at this column."""
    last = len(lines) if last is None else last
    at = first
    while at < last:
        start, line = at, lines[at]
        at += 1
        if line.startswith("#"):
            while lines[at - 1].endswith("\\") and at < last:
                at += 1
            continue
        if not line.strip() or indentation(line) != indent or line[indent] in "}/":
            continue
        # A header ends with its brace; anything else that stands here ends before.
        while at < last and not lines[at - 1].endswith(("{", ";", "}")) and lines[at].strip():
            at += 1
        header = without_templates(" ".join(part.strip() for part in lines[start:at]))
        if not lines[at - 1].endswith("{"):
            if lines[at - 1].endswith("}") and "(" in header:
                yield name_of(header), start, at - start  # a body on the header's last line
            continue
        if SAME_COLUMN.match(header):
            continue
        body = at
        if is_initializer(header):
            at = past_initializer(lines, start, last)
            continue
        while at < last and not (indentation(lines[at]) == indent and lines[at].startswith("}", indent)):
            at += 1
        at += 1
        if "(" in header or "[" in header:
            yield name_of(header), start, at - start
        elif TYPE.match(header):
            yield from c_functions(lines, body, at - 1, indent + 2)


def python_functions(source):
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            yield node.name, node.lineno - 1, node.end_lineno - node.lineno + 1


def functions(name, source):
    """As c_functions; a case of a test has the name in its quotes."""
    if name.endswith(".py"):
        yield from python_functions(source)
        return
    written = source.split("\n")
    for function, start, length in c_functions([line.rstrip() for line in without_text(source).split("\n")]):
        if function.startswith("TEST_CASE"):
            case = re.search(r'"([^"]*)"', "\n".join(written[start : start + 3]))
            function = f"{function} '{case[1]}'" if case else function
        yield function, start, length


def tracked(root):
    spec = importlib.util.spec_from_file_location("line_width_test", root / "tests/unit/line_width_test.py")
    width = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(width)
    return [name for name in width.tracked(root) if pathlib.PurePath(name).suffix in C_LIKE | {".py"}]


def main():
    root = pathlib.Path(sys.argv[1])
    names, found, count = tracked(root), [], 0
    for name in names:
        source = (root / name).read_text(encoding="utf-8")
        lines = source.count("\n")
        most = ENTRY if re.fullmatch(r"kernels/entry/[^/]*\.cl", name) else FILE
        if lines > most:
            found.append(f"{name}: {lines} lines, at most {most}")
        for function, start, length in functions(name, source):
            count += 1
            if length > FUNCTION:
                found.append(f"{name}:{start + 1}: {function}, {length} lines, at most {FUNCTION}")
    print("\n".join(found) if found else f"{count} functions in {len(names)} files, none too long")
    sys.exit(1 if found or not count else 0)


if __name__ == "__main__":
    main()

"""Sizes of rooms: a file over 400 lines or a function over 60 has two purposes."""

import ast
import re
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = ("src", "core", "tests", "benchmarks", "examples", "tools")
FILE_LINES, FUNCTION_LINES = 400, 60


def sources(*suffixes):
    return sorted(p for folder in FOLDERS for p in (ROOT / folder).rglob("*") if p.suffix in suffixes)


def python_functions(text):
    """Name and length [lines] of each function of a Python file."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.name, node.end_lineno - node.lineno + 1


COMMENT_OR_STRING = re.compile(
    r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'|^\s*#[^\n]*', re.S | re.M
)
FUNCTION_HEAD = re.compile(r"(\w+)\s*\([^{};]*\)\s*(const|noexcept|override|->[^{}()]*|\s)*$", re.S)
NOT_A_FUNCTION = {"if", "for", "while", "switch", "catch"}


def cpp_functions(text):
    """Name and length [lines] of each function of a C++ file, told by `name(...) {` and its brace."""
    text = COMMENT_OR_STRING.sub(lambda m: "\n" * m.group().count("\n"), text)
    opened, head = [], 0
    for place in re.finditer(r"[{};]", text):
        i, sign = place.start(), place.group()
        if sign == "{":
            match = FUNCTION_HEAD.search(text, head, i)
            name = match.group(1) if match and match.group(1) not in NOT_A_FUNCTION else None
            opened.append((name, text.count("\n", 0, match.start() if match else i)))
        elif sign == "}" and opened:
            name, first = opened.pop()
            if name:
                yield name, text.count("\n", 0, i) - first + 1
        head = i + 1


@pytest.mark.parametrize("path", sources(".py", ".hpp", ".cpp"), ids=lambda p: str(p.relative_to(ROOT)))
def test_file_is_one_room(path):
    """Files have at most 400 lines, functions at most 60."""
    text = path.read_text(encoding="utf-8")
    functions = python_functions(text) if path.suffix == ".py" else cpp_functions(text)
    assert [f"{name}: {lines} lines" for name, lines in functions if lines > FUNCTION_LINES] == []
    assert len(text.splitlines()) <= FILE_LINES


def test_functions_are_found_in_cpp():
    """The C++ reader sees functions and methods, and is not fooled by loops, comments or strings."""
    text = "struct S {\n  int f(int a) const {\n    for (;;) {\n    }\n    return a;  // }\n  }\n};\n"
    text += 'void g() { say("{"); }\n'
    assert list(cpp_functions(text)) == [("f", 5), ("g", 1)]


ROOMS = ("src/neve", "core", "tests")
ROOM_FILES = 14
BUILT = "src/neve/drive/page"


def crowded(root, most=ROOM_FILES):
    """Folders with more source files than `most`, not counting `__init__.py`, and how many they have."""
    files = (p for p in root.rglob("*") if p.suffix in {".py", ".hpp", ".cpp", ".js", ".html", ".css"})
    count = Counter(p.parent for p in files if p.name != "__init__.py" and "__pycache__" not in p.parts)
    return {folder: n for folder, n in count.items() if n > most}


def test_no_folder_is_crowded():
    """A folder with more than fourteen source files has two purposes."""
    found = [item for room in ROOMS for item in crowded(ROOT / room).items()]
    names = {folder.relative_to(ROOT).as_posix(): n for folder, n in found}
    assert {name for name in names if not name.startswith(BUILT)} == set()


def test_a_crowded_folder_is_found(tmp_path):
    """Source files count, one by one; `__init__.py` and other files do not."""
    for name in ("__init__.py", "a.py", "b.hpp", "c.js", "d.txt"):
        (tmp_path / name).touch()
    assert crowded(tmp_path, 3) == {}
    assert crowded(tmp_path, 2) == {tmp_path: 3}

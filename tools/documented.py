"""Find the commands and the Python that a page of the documentation asks its reader to type.

`.ci/run` and the tests type them from there, so that what is tested is what is printed:

    python tools/documented.py README.md first      # the first block of commands, a line each
    python tools/documented.py README.md commands   # all of them
    python tools/documented.py README.md python     # the blocks of Python
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

FENCE = re.compile(r"^```(\w*)\n(.*?)^```", re.M | re.S)
INDENTED = re.compile(r"(?:^ {4}.*\n)+", re.M)
COMMAND = re.compile(r"\(?(?:neve|pip|python|pytest|npm|npx|cmake|cd|source|\.ci/\w+)\b")
SHELLS = {"sh", "bash", "console", "shell"}


def fenced(text: str, language: str) -> list[str]:
    """Return the fenced blocks of a language, in order."""
    return [body for name, body in FENCE.findall(text) if name == language]


def command_blocks(text: str) -> list[list[str]]:
    """Return the blocks of shell commands, a list of lines each, without their comments."""
    indented = INDENTED.findall(FENCE.sub("", text))
    blocks = [*indented, *(body for name, body in FENCE.findall(text) if name in SHELLS)]
    lines = [[re.sub(r"\s+# .*", "", line).strip() for line in block.splitlines()] for block in blocks]
    shells = len(indented)  # what comes after them is fenced, and says that it is for a shell
    return [block for k, block in enumerate(lines) if k >= shells or COMMAND.match(block[0])]


def main(path: str, what: str) -> None:
    """Print what a page has: its `first` block of commands, all `commands`, or the blocks of a language."""
    text = Path(path).read_text(encoding="utf-8")
    if what in ("first", "commands"):
        blocks = command_blocks(text)
        print("\n".join(line for block in blocks[: 1 if what == "first" else None] for line in block))
    else:
        print("\n".join(fenced(text, what)))


if __name__ == "__main__":
    if len(sys.argv) != 3 or not Path(sys.argv[1]).is_file():
        sys.exit("documented.py: name a page and what of it: first, commands or a language, such as python")
    main(*sys.argv[1:])

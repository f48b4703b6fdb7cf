"""What a function's assembly says: what it reaches, what goes through the stack, what goes piece by piece.

The text is x86-64 in AT&T syntax, as GCC and Clang write it on Linux.
"""

import re
from typing import NamedTuple

REGISTER = {"x86-64-v3": "y", "x86-64-v4": "z"}  # ymm, zmm: what a pack of the level is made of

LABEL = re.compile(r"([\w.$]+):")
FRAME = re.compile(r"(?:movq?|leaq?)\s.*%rsp.*,\s*%rbp$")  # from here on %rbp points into the stack
JUMP = re.compile(r"(?:call|jmp)q?\s+([\w.$]+)")
SCALAR = re.compile(r"v?(?:sqrt|round|rndscale|div|mul|add|sub|fn?m(?:add|sub)\d+)s[sd]\s")
PACKED = re.compile(r"v?(?:sqrt|round|rndscale|div|mul|add|sub|fn?m(?:add|sub)\d+)p[sd]\s")
FUSED = re.compile(r"vfn?m(?:add|sub)\d+p[sd]\s")
STRING = re.compile(r"rep;?\s+(?:movs|stos)")
HALF_STORE = re.compile(r"vmov(?:[ua]p[sd]|dq[ua]\d*)\s+%xmm\d+,")


class Line(NamedTuple):
    """One instruction, and whether it reads or writes the stack."""

    text: str
    stack: bool


def functions(assembly):
    """Return the instructions of each function, without those that the compiler has put aside as unlikely."""
    found, lines, unlikely, framed = {}, None, False, False
    for row in assembly.splitlines():
        text = row.partition("#")[0].strip()
        if text.startswith((".section", ".text")):
            unlikely = ".text.unlikely" in text
        elif text.startswith(".size"):
            lines = None
        elif (label := LABEL.match(row)) and not label[1].startswith("."):
            lines, framed = [], False
            if not unlikely:
                found[label[1]] = lines
        elif lines is not None and text and text[0] not in "." and not text.endswith(":"):
            framed = framed or FRAME.match(text) is not None
            stack = "(%rsp" in text or (framed and "(%rbp" in text)
            lines.append(Line(text, stack))
    return {symbol: lines for symbol, lines in found.items() if lines}


def reached(symbol, of):
    """Return the instructions of a function and of all in the text that it calls or jumps to."""
    seen, todo = {symbol}, [symbol]
    while todo:
        for line in of[todo.pop()]:
            target = JUMP.match(line.text)
            if target and target[1] in of and target[1] not in seen:
                seen.add(target[1])
                todo.append(target[1])
    return [line for name in sorted(seen) for line in of[name]]


def calls(lines):
    """Count the calls by name, those that are followed and those into the C library alike."""
    found = {}
    for line in lines:
        if line.text.startswith("call") and (target := JUMP.match(line.text)):
            found[target[1]] = found.get(target[1], 0) + 1
    return found


def counts(lines, level):
    """Count what matters in instructions that stand in the text (a loop's body once).

    `stack`: vectors read from or written to the stack. `halves`: of these the stores of 16 bytes, which a
    wider load then waits for. `strings`: copies by `rep movs`, slow to start. `scalar`: arithmetic on one
    lane. `narrow`: arithmetic on packs that do not fill a register of the level. `fused`: multiply-adds on
    packs.
    """
    whole = f"%{REGISTER[level]}mm"
    vectors = [line.text for line in lines if line.stack and re.search("%[xyz]mm", line.text)]
    texts = [line.text for line in lines]
    return {
        "stack": len(vectors),
        "halves": sum(1 for text in vectors if HALF_STORE.match(text)),
        "strings": sum(1 for text in texts if STRING.match(text)),
        "scalar": sum(1 for text in texts if SCALAR.match(text)),
        "narrow": sum(1 for text in texts if PACKED.match(text) and whole not in text),
        "fused": sum(1 for text in texts if FUSED.match(text)),
    }

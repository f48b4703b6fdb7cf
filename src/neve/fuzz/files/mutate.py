"""Damage the bytes of a file: bits, blocks, lengths, numbers and words."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable

import numpy as np

Generator = np.random.Generator

MOST = 8
"""Damages to one file at most; the number of them is geometric."""
LARGEST = 1 << 20
"""Bytes of a damaged file at most."""
NUMBERS = ("nan", "inf", "-inf", "0", "-0", "-1", "1e308", "-1e308", "1e-320", "1e400", "9" * 30, "1e6",
           "2147483648", "4294967295", "-2147483649", "0.5", "0x10", "1_0", "", "1e", "\u0663")  # fmt: skip
"""What stands for a number afterwards."""
NUMBER = re.compile(rb"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
WORD = re.compile(rb"[A-Za-z_][A-Za-z_0-9]*")
LENGTHS = (0, 1, -1, 2, 127, 128, 255, 2**15, 2**16 - 1, 2**31 - 1, -(2**31), 2**32 - 1, 2**24)
REALS = (float("nan"), float("inf"), -float("inf"), 0.0, 1e30, -1e38, 1e-40, 1.0)
SIGNS = (
    b"\0",
    b"\n",
    b"\t",
    b'"',
    b"'",
    b"[",
    b"]" * 3,
    b"{",
    b"<",
    b">",
    b"#",
    b"\\",
    b"\xff\xfe",
    b"=",
    b"..",
)


def damaged(content: bytes, other: bytes, rng: Generator) -> bytes:
    """Return `content` after a few damages drawn from `rng`; `other` is another file of its kind."""
    found = content
    is_text = b"\0" not in content[:512]
    for _ in range(min(MOST, int(rng.geometric(0.5)))):
        ways = TEXT if is_text and rng.random() < 0.7 else BYTES
        found = ways[rng.integers(len(ways))](found, other, rng)[:LARGEST]
    return found


def _place(content: bytes, rng: Generator) -> int:
    """Return a place in the content; every third is among its first 128 bytes, where formats have heads."""
    end = min(len(content), 128) if rng.random() < 0.33 else len(content)
    return int(rng.integers(max(end, 1)))


def _block(content: bytes, rng: Generator) -> tuple[int, int]:
    """Return begin and end of a block, a few bytes or up to all of them long."""
    begin = _place(content, rng)
    longest = len(content) - begin
    return begin, begin + int(min(longest, 2 ** (rng.random() * np.log2(longest + 2))))


def _flip(content: bytes, other: bytes, rng: Generator) -> bytes:
    changed = bytearray(content)
    for _ in range(int(rng.integers(1, 9))):
        if changed:
            changed[_place(content, rng)] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def _cut(content: bytes, other: bytes, rng: Generator) -> bytes:
    return content[: _place(content, rng)]


def _remove(content: bytes, other: bytes, rng: Generator) -> bytes:
    begin, end = _block(content, rng)
    return content[:begin] + content[end:]


def _repeat(content: bytes, other: bytes, rng: Generator) -> bytes:
    begin, end = _block(content, rng)
    return content[:end] + content[begin:end] * int(2 ** rng.integers(0, 8)) + content[end:]


def _insert(content: bytes, other: bytes, rng: Generator) -> bytes:
    at = _place(content, rng)
    return content[:at] + rng.bytes(int(rng.integers(1, 33))) + content[at:]


def _splice(content: bytes, other: bytes, rng: Generator) -> bytes:
    begin, end = _block(other, rng)
    at = _place(content, rng)
    return content[:at] + other[begin:end] + content[at:]


def _overwrite(content: bytes, other: bytes, rng: Generator) -> bytes:
    begin, end = _block(content, rng)
    return content[:begin] + bytes([int(rng.choice((0, 255, 127, 32)))]) * (end - begin) + content[end:]


def _length(content: bytes, other: bytes, rng: Generator) -> bytes:
    """Put a whole number of 2, 4 or 8 bytes where a size may stand."""
    size = int(rng.choice((2, 4, 8)))
    value = int(LENGTHS[rng.integers(len(LENGTHS))]) % (1 << 8 * size)
    at = _place(content, rng) // 2 * 2
    order = "little" if rng.random() < 0.7 else "big"
    return content[:at] + value.to_bytes(size, order) + content[at + size :]  # type: ignore[arg-type]


def _real(content: bytes, other: bytes, rng: Generator) -> bytes:
    """Put a float where one may stand."""
    code = str(rng.choice(("<f", ">f", "<d", ">d")))
    value = struct.pack(code, REALS[rng.integers(len(REALS))])
    at = _place(content, rng) // 2 * 2
    return content[:at] + value + content[at + len(value) :]


def _number(content: bytes, other: bytes, rng: Generator) -> bytes:
    """Replace a number of a text."""
    return _swapped(NUMBER, content, NUMBERS[rng.integers(len(NUMBERS))].encode(), rng)


def _word(content: bytes, other: bytes, rng: Generator) -> bytes:
    """Replace a word of a text by another one, of this file or another."""
    words = WORD.findall(content if rng.random() < 0.7 else other)
    return _swapped(WORD, content, words[rng.integers(len(words))], rng) if words else content


def _swapped(pattern: re.Pattern[bytes], content: bytes, value: bytes, rng: Generator) -> bytes:
    found = list(pattern.finditer(content))
    if not found:
        return content
    match = found[rng.integers(len(found))]
    return content[: match.start()] + value + content[match.end() :]


def _lines(content: bytes, other: bytes, rng: Generator) -> bytes:
    """Remove, repeat or move a line of a text."""
    lines = content.split(b"\n")
    a, b = (int(k) for k in rng.integers(len(lines), size=2))
    what = int(rng.integers(3))
    if what == 0:
        del lines[a]
    elif what == 1:
        lines[a:a] = [lines[a]] * int(2 ** rng.integers(0, 11))
    else:
        lines[a], lines[b] = lines[b], lines[a]
    return b"\n".join(lines)


def _sign(content: bytes, other: bytes, rng: Generator) -> bytes:
    """Put a sign that formats give a meaning, once or a thousand times."""
    at = _place(content, rng)
    sign = SIGNS[rng.integers(len(SIGNS))] * int(rng.choice((1, 1, 1, 1000)))
    return content[:at] + sign + content[at:]


Damage = Callable[[bytes, bytes, Generator], bytes]
BYTES: tuple[Damage, ...] = (_flip, _flip, _cut, _remove, _repeat, _insert, _splice, _overwrite, _length,
                             _length, _real)  # fmt: skip
TEXT: tuple[Damage, ...] = (_number, _number, _number, _word, _lines, _sign, _flip)

"""Open fonts, choose how their letters are laid out, and say what a font or a text lacks."""

from __future__ import annotations

import json
import struct
import unicodedata
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

from neve.scene.errors import SceneError
from neve.scene.schema.file_shapes import Text

if TYPE_CHECKING:
    from PIL.ImageFont import FreeTypeFont

FONT = Path(__file__).parents[1] / "assets" / "FredokaOne-Regular.ttf"
NO_CHARACTER = "\U0010ffff"
"""A code that is never a character: every font draws it as its missing-glyph box."""
TAB = 4
"""Letters between the stops of a tab."""
NAMED = 8
"""Characters that a sentence names at most."""
OUTLINES = ("glyf", "CFF ", "CFF2")
COLOURS = {"CBDT": "CBDT", "sbix": "sbix", "COLR": "COLR", "SVG ": "SVG", "EBDT": "EBDT", "bdat": "bdat"}
"""Tables of a font file with the shapes of its letters, and with pictures of them (OpenType 1.9)."""
RIGHT_TO_LEFT = ("R", "AL", "AN", "RLE", "RLO", "RLI", "LRE", "LRO", "LRI")
"""Classes of characters whose order on the line is not that of the text (Unicode Standard Annex 9)."""
SHAPED = (
    *((0x0590, 0x109F), (0x1100, 0x11FF), (0x1700, 0x18AF), (0x1900, 0x1CFF), (0xA800, 0xABFF)),
    *((0xD7B0, 0xD7FF), (0xFB1D, 0xFDFF), (0xFE70, 0xFEFE), (0x10A00, 0x11FFF), (0x1E800, 0x1EFFF)),
)
"""Blocks of scripts whose letters join, stack or change places, such as Hebrew to Myanmar."""


def plain(text: str) -> str:
    """Return `text` with one sign for the end of a line, spaces for tabs, and accents in letters (NFC)."""
    return "\n".join(line.expandtabs(TAB) for line in unicodedata.normalize("NFC", text).splitlines())


def is_shaped(text: str) -> bool:
    """Whether `text` needs more than letters side by side: another order, joined letters or marks."""
    return any(
        unicodedata.category(c)[0] == "M"
        or unicodedata.category(c) == "Cf"
        or unicodedata.bidirectional(c) in RIGHT_TO_LEFT
        or any(low <= ord(c) <= high for low, high in SHAPED)
        for c in text
    )


def opened(source: Text, size: float, name: str, shaped: bool) -> FreeTypeFont:
    """Return the font of `source` at `size` pixels; `shaped` letters are laid out by HarfBuzz and FriBiDi.

    Other text stands as FreeType alone sets it, so that it is the same with and without these libraries.

    `name`: used in messages.

    Errors: SceneError, one sentence: no font, without outlines, or no FriBiDi for letters that need it.
    """
    from PIL import ImageFont, features

    if shaped and not features.check("raqm"):
        raise SceneError(
            f"{name}.text has letters that join or change places, which takes the library FriBiDi, and "
            "Pillow does not find it: install it (libfribidi0 on Debian, fribidi elsewhere)"
        )
    layout = ImageFont.Layout.RAQM if shaped else ImageFont.Layout.BASIC
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return ImageFont.truetype(source.font or FONT, size, layout_engine=layout)
    except Exception:  # whatever a damaged font makes its reader stumble over
        _require_outlines(source, name)
        raise unusable(source, name, "can be read") from None


def unusable(source: Text, name: str, can: str) -> SceneError:
    """Return the sentence about a font file that is none, or damaged."""
    stated = f"{name}.font = {json.dumps(source.font, ensure_ascii=False)}"
    return SceneError(
        f"{stated} is not a font that {can}: it is damaged, or no font; name a .ttf or .otf file"
    )


def require_glyphs(source: Text, text: str, font: FreeTypeFont, name: str) -> None:
    """Refuse characters of `text` that the font does not have, or that it draws in colour alone.

    Errors: SceneError, one sentence that names them.
    """
    _require_outlines(source, name)
    box = picture(NO_CHARACTER, font)
    seen = [c for c in dict.fromkeys(text) if not c.isspace() and not _is_silent(c)]
    drawn = {c: picture(c, font) for c in seen}
    which = "the bundled font" if not source.font else f'the font "{source.font}"'
    other = f"name a font that has it with {name}.font"
    if blank := [c for c in seen if drawn[c] is None]:
        tables = [word for tag, word in COLOURS.items() if tag in _tables(source)]
        if tables:
            raise SceneError(
                f"{name}.text: {which} draws {_named(blank)} in colours alone ({', '.join(tables)}), without "
                f"an outline that snow could fill; {other}"
            )
    if lacking := [c for c in seen if drawn[c] in (box, None)]:
        raise SceneError(f"{name}.text: {which} has no glyph for {_named(lacking)}; {other}")


def spaced(text: str, font: FreeTypeFont) -> str:
    """Return `text` with plain spaces for those that the font does not have: as wide as its box, or one."""
    missing = font.getlength(NO_CHARACTER)
    spaces = [c for c in dict.fromkeys(text) if c.isspace() and c not in " \n"]
    odd = [c for c in spaces if picture(c, font) is not None or font.getlength(c) == missing]
    return text.translate({ord(c): " " for c in odd})


def picture(character: str, font: FreeTypeFont) -> tuple[tuple[int, int], bytes] | None:
    """Return the pixels of `character`, or None if it leaves no ink."""
    mask = font.getmask(character, mode="L")
    return (mask.size, bytes(mask)) if mask.getbbox() else None


def _is_silent(c: str) -> bool:
    """Whether a character only says how others are drawn: joiners, directions, selectors of variants."""
    return unicodedata.category(c) == "Cf" or c in "\u034f\u180b\u180c\u180d" or 0xFE00 <= ord(c) <= 0xFE0F


def _named(characters: list[str]) -> str:
    """Return characters with their codes and names."""
    shown = []
    for c in characters[:NAMED]:
        code = f"U+{ord(c):04X} {unicodedata.name(c, '')}".rstrip()
        shown.append(f"{c} ({code})" if c.isprintable() and unicodedata.category(c)[0] != "M" else code)
    rest = len(characters) - NAMED
    return ", ".join(shown) + (f" and {rest} more" if rest > 0 else "")


def _require_outlines(source: Text, name: str) -> None:
    """Refuse a font that has pictures of its letters and no outlines.

    Errors: SceneError.
    """
    tables = _tables(source)
    pictures = [word for tag, word in COLOURS.items() if tag in tables]
    if pictures and not any(tag in tables for tag in OUTLINES):
        stated = f"{name}.font = {json.dumps(source.font, ensure_ascii=False)}"
        raise SceneError(
            f"{stated} has letters as pictures alone ({', '.join(pictures)}), without outlines that snow "
            "could fill: name a font with outlines"
        )


def _tables(source: Text) -> tuple[str, ...]:
    """Return the tags of the tables of a font file, of its first font (OpenType 1.9, table directory)."""
    try:
        with open(source.font or FONT, "rb") as file:
            head = file.read(12)
            if head[:4] == b"ttcf":
                file.seek(struct.unpack(">I", file.read(4))[0])
                head = file.read(12)
            count = struct.unpack(">H", head[4:6])[0]
            entries = file.read(16 * count)
    except (OSError, struct.error):
        return ()
    return tuple(entries[i : i + 4].decode("latin-1") for i in range(0, len(entries) - 15, 16))

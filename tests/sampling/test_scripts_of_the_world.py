"""Letters that join, stack or run from right to left; fonts without outlines; what a font lacks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from fontTools.feaLib.builder import addOpenTypeFeaturesFromString
from fontTools.fontBuilder import FontBuilder
from fontTools.pens.ttGlyphPen import TTGlyphPen
from fontTools.ttLib import TTFont
from fontTools.ttLib.tables.DefaultTable import DefaultTable
from matplotlib import get_data_path
from PIL import features
from scipy import ndimage

from neve.sampling.fonts import FONT, is_shaped
from neve.sampling.lettering import letters
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Source

DEJAVU = str(Path(get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf")
"""A font with Arabic and Hebrew, which comes with matplotlib."""
shaping = pytest.mark.skipif(not features.check("raqm"), reason="Pillow finds no FriBiDi here")


def drawn(text: str, font: str | Path = ""):
    return letters(Source.of("text", text=text, font=str(font)), 0.02, "sources.0")


def pieces(text: str, font: str | Path):
    """The areas of the parts of `text` that do not touch, from left to right [pixels]."""
    solid = drawn(text, font).solid
    marks, count = ndimage.label(solid, structure=np.ones((3, 3)))
    left = [np.flatnonzero((marks == k).any(axis=0))[0] for k in range(1, count + 1)]
    return [int((marks == k + 1).sum()) for k in np.argsort(left)]


@shaping
def test_arabic_is_joined_from_right_to_left():
    """Seen, lam and alef of "salam" join, and the mim stands alone on the left: two pieces, not four."""
    found = pieces("سلام", DEJAVU)
    assert len(found) == 2
    assert len(pieces("ملاس"[::-1], DEJAVU)) == 2
    assert found[0] < found[1]  # the mim is the smaller one, and on the left
    alone = [drawn(c, DEJAVU).width for c in "سلام"]
    assert drawn("سلام", DEJAVU).width < 0.9 * sum(alone)


@shaping
def test_hebrew_runs_from_right_to_left_and_numbers_in_it_do_not():
    """Yod is smaller than shin: it stands on the right where it is first. Digits keep their order."""
    small, large = pieces("י", DEJAVU)[0], sum(pieces("ש", DEJAVU))
    assert small < large
    assert pieces("יש", DEJAVU) == pytest.approx([large, small], rel=0.05)
    digits = [sum(pieces(c, DEJAVU)) for c in "71"]
    assert pieces("ש71", DEJAVU) == pytest.approx([*digits, large], rel=0.05)


def devanagari(path: Path) -> Path:
    """Write a font of blocks: ka is 800 units wide, the vowel sign i 200, a virama 100 above the line."""
    blocks = {".notdef": (500, 700), "H": (600, 700), "ka": (800, 700), "i": (200, 700), "ssa": (700, 700)}
    build = FontBuilder(1000, isTTF=True)
    names = [*blocks, "virama", "kssa"]
    build.setupGlyphOrder(names)
    codes = {0x48: "H", 0x915: "ka", 0x93F: "i", 0x937: "ssa", 0x94D: "virama"}
    build.setupCharacterMap(codes)
    made = {}
    for name, (wide, high) in (blocks | {"virama": (100, 100), "kssa": (400, 700)}).items():
        pen = TTGlyphPen(None)
        pen.moveTo((0, 0))
        for corner in ((0, high), (wide, high), (wide, 0)):
            pen.lineTo(corner)
        pen.closePath()
        made[name] = pen.glyph()
    build.setupGlyf(made)
    widths = {name: (blocks.get(name, (400, 0))[0] + 50, 0) for name in names}
    build.setupHorizontalMetrics(widths)
    build.setupHorizontalHeader(ascent=800, descent=-200)
    build.setupOS2()
    build.setupPost()
    build.setupNameTable({"familyName": "Blocks", "styleName": "Regular"})
    rules = "languagesystem DFLT dflt; languagesystem dev2 dflt;"
    joins = "feature akhn { sub ka virama ssa by kssa; } akhn;"
    addOpenTypeFeaturesFromString(build.font, rules + joins)
    build.save(path)
    return path


@shaping
def test_indic_signs_change_places_and_join(tmp_path):
    """The sign i follows its consonant in the text and stands before it; ka, virama, ssa are one glyph."""
    font = devanagari(tmp_path / "blocks.ttf")
    wide, narrow, joined = (pieces(c, font)[0] for c in "\u0915\u093f\u0937")
    assert narrow < wide
    assert pieces("\u0915\u093f", font) == pytest.approx([narrow, wide], rel=0.02)
    cluster = pieces("\u0915\u094d\u0937", font)
    assert len(cluster) == 1
    assert cluster[0] == pytest.approx(joined * 400 / 700, rel=0.02)


def test_plain_text_needs_no_other_library():
    """Latin, Greek, Cyrillic, Chinese, digits and accents in letters stand side by side, as always."""
    for text in ("NEVE gQ", "Δz Снег 雪山 ¿é?", "a\nb\tc", "1,5 €"):
        assert not is_shaped(text), text
    for text in ("سلام", "שלום", "क्षि", "ไทย", "e\u0301\u0323", "a\u200db", "ᄒ", "ܣ"):
        assert is_shaped(text), text


def test_without_fribidi_text_that_needs_it_is_told(monkeypatch):
    """Not four letters from left to right in silence."""
    monkeypatch.setattr("PIL.features.check", lambda name: False)
    with pytest.raises(
        SceneError, match=r"^sources\.0\.text has letters that join .* library FriBiDi, .* install"
    ):
        drawn("سلام", DEJAVU)
    assert drawn("NEVE").area > 0


@pytest.mark.parametrize("gap", ["\t", "\u00a0", "\u2003", "\u3000", "\u200a"])
def test_spaces_of_every_kind_leave_a_gap(gap):
    """A tab reaches the next of the stops every four letters; no space is drawn as a box."""
    spaces = "   " if gap == "\t" else " "
    assert np.array_equal(drawn(f"H{gap}H").solid, drawn(f"H{spaces}H").solid)
    for end in ("\r\n", "\r", "\u2028", "\x0b"):
        assert np.array_equal(drawn(f"H{end}H").solid, drawn("H\nH").solid)


def test_accents_apart_from_their_letters_are_joined():
    """e and an acute accent are the letter that the font has (NFC)."""
    assert np.array_equal(drawn("e\u0301").solid, drawn("\u00e9").solid)


def test_what_a_font_lacks_is_told_by_name():
    """Character, code and name; one that cannot be shown by its code alone."""
    for text, named in {
        "雪": r"雪 \(U\+96EA CJK UNIFIED IDEOGRAPH-96EA\); name a font",
        "A\x07": r"no glyph for U\+0007; name a font",
        "\U0001f600": r"\(U\+1F600 GRINNING FACE\)",
    }.items():
        with pytest.raises(SceneError, match=named):
            drawn(text)
    many = "".join(chr(0x4E00 + k) for k in range(20))
    with pytest.raises(SceneError, match=r" and 12 more; name a font"):
        drawn(many)


@pytest.mark.parametrize("table", ["CBDT", "sbix", "COLR", "EBDT"])
def test_fonts_of_pictures_alone_are_refused_for_that(table, tmp_path):
    """Without outlines, with bitmaps or layers of colour: not "damaged", and not "no glyph"."""
    content = FONT.read_bytes()
    assert content.count(b"glyf", 0, 400) == 1
    place = content.index(b"glyf")
    path = tmp_path / "pictures.ttf"
    path.write_bytes(content[:place] + table.encode() + content[place + 4 :])
    with pytest.raises(
        SceneError, match=rf"sources\.0\.font = .* as pictures alone \({table}\), without outlines"
    ):
        drawn("A", path)


def test_letters_in_colour_alone_are_told(tmp_path):
    """A font with outlines of B whose A is layers of colours alone: A is named, B is drawn."""
    font = TTFont(FONT)
    font["glyf"]["A"] = TTGlyphPen(None).glyph()
    font["COLR"] = table = DefaultTable("COLR")
    table.data = bytes(14)
    font.save(tmp_path / "layers.ttf")
    with pytest.raises(
        SceneError, match=r"draws A \(U\+0041 LATIN CAPITAL LETTER A\) in colours alone \(COLR\)"
    ):
        drawn("AB", tmp_path / "layers.ttf")
    assert drawn("B", tmp_path / "layers.ttf").area > 0

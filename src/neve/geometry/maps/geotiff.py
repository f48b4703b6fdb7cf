"""Find where the pixels of a GeoTIFF lie on the ground, and how long its units are."""

from __future__ import annotations

import math
from typing import Any
from xml.etree import ElementTree

import numpy as np

from neve.geometry.maps.epsg import units_by_code
from neve.geometry.maps.found import NO_METRES, Array, Map, Place, in_degrees
from neve.geometry.maps.well_known import Units, silent_heights
from neve.scene.errors import SceneError

PIXEL_SCALE, TIE_POINTS, TRANSFORMATION = 33550, 33922, 34264
GEO_KEYS, GEO_DOUBLES, GDAL_METADATA = 34735, 34736, 42112
"""Numbers of tags (OGC 19-008r4, section 7; GDAL's own)."""
MODEL_TYPE, PROJECTED, GEOGRAPHIC, GEOCENTRIC = 1024, 1, 2, 3
RASTER_TYPE, IS_POINT = 1025, 2
GEOGRAPHIC_SYSTEM, PROJECTED_SYSTEM, VERTICAL_SYSTEM = 2048, 3072, 4096
ANGULAR_UNITS, LINEAR_UNITS, LINEAR_SIZE, VERTICAL_UNITS = 2054, 3076, 3077, 4099
DEGREE, USER_DEFINED = 9102, 32767
"""Keys and values of the coordinate system (OGC 19-008r4, section 7 and annex C [M])."""
LENGTHS = {
    9001: 1.0,
    9002: 0.3048,
    9003: 1200.0 / 3937.0,
    9005: 0.3047972654,
    9014: 1.8288,
    9030: 1852.0,
    9036: 1000.0,
    9041: 0.3047994715386762,
    9093: 1609.344,
    9096: 0.9144,
    1025: 0.001,
    1033: 0.01,
}
"""Units of length by their EPSG code [m] (EPSG Geodetic Parameter Dataset [M])."""
UNIT_TYPES = {
    **dict.fromkeys(("m", "metre", "meter", "metres", "meters"), 1.0),
    **dict.fromkeys(("ft", "foot", "feet", "international foot", "ft (international)", "foot_intl"), 0.3048),
    **dict.fromkeys(
        ("us survey foot", "us survey feet", "us_survey_foot", "ftus", "sft", "foot_us"), 1200 / 3937
    ),
    **dict.fromkeys(("cm", "centimetre", "centimeter", "centimetres", "centimeters"), 0.01),
    **dict.fromkeys(("mm", "millimetre", "millimeter", "millimetres", "millimeters"), 0.001),
    **dict.fromkeys(("dm", "decimetre", "decimeter", "decimetres", "decimeters"), 0.1),
    **dict.fromkeys(("km", "kilometre", "kilometer", "kilometres", "kilometers"), 1000.0),
}
"""Units that GDAL writes for the numbers of a band [m]."""
STRAIGHT = 1e-6
"""What axes may deviate from right angles, and from north, as a share."""


def placed(
    rows: Array, full: float | None, page: Any, doubts: tuple[str, ...], orientation: int, key: str
) -> Map:
    """Return the map of `rows` of numbers (from the top of the file) with its axes to east and north.

    X = a i + b j + c, Y = d i + e j + f for column i and row j: of the middle of a pixel that is a point, of
    the corner of one that is an area, whose middle is half a pixel further (OGC 19-008r4, section 7.1.1).

    Errors: SceneError for a unit that is not known.
    """
    scaled, stated = _band(page, key)
    values = rows * scaled[0] + scaled[1] if scaled != (1.0, 0.0) else rows
    transform, why = _transform(page)
    if transform is None:
        upright = _oriented(values, orientation)
        return Map(upright[::-1].T, full, unit=stated or 1.0, no_size=why, doubts=doubts)
    if any(one < 0.0 for one in _numbers(page, PIXEL_SCALE)[1:2]):
        doubts = (*doubts, "has pixels of a negative height: its first row is taken for the northernmost")
    units = _units(page, key)
    unit, doubts = stated or units.vertical, doubts if stated else doubts + units.doubts
    turned, transform = _to_the_north(values, _of_middles(page, transform))
    a, b, _, d, e, _ = transform
    step = (math.hypot(a, d), math.hypot(b, e))
    if abs(a * b + d * e) > STRAIGHT * step[0] * step[1]:
        return Map(turned.T, full, unit=unit, no_size="has pixels that are no rectangles", doubts=doubts)
    angle = math.degrees(math.atan2(d, a))
    angle = 0.0 if abs(angle) < math.degrees(STRAIGHT) else angle
    heights = np.ascontiguousarray(turned.T)
    place = _place(page, transform, units.horizontal or 1.0)
    if units.horizontal is None:
        shape = (heights.shape[0], heights.shape[1])
        middle = transform[5] + 0.5 * (transform[3] * (shape[0] - 1) + transform[4] * (shape[1] - 1))
        told = in_degrees(middle if _are_degrees(page) else None, step, shape)
        return Map(heights, full, unit=unit, turn=angle, no_size=told, doubts=doubts, place=place)
    pixel = (step[0] * units.horizontal, step[1] * units.horizontal)
    return Map(heights, full, pixel, unit, angle, doubts=doubts, place=place)


def _of_middles(page: Any, transform: tuple[float, ...]) -> tuple[float, ...]:
    """Return the transform that leads to the middles of the pixels."""
    a, b, c, d, e, f = transform
    half = 0.0 if _keys(page).get(RASTER_TYPE) == IS_POINT else 0.5
    return a, b, c + half * (a + b), d, e, f + half * (d + e)


def _place(page: Any, transform: tuple[float, ...], unit: float) -> Place:
    """Return where the middles of the pixels are; unit: of the system's lengths [m], 1 for degrees."""
    keys = _keys(page)
    code = int(keys.get(PROJECTED_SYSTEM, keys.get(GEOGRAPHIC_SYSTEM, 0)))
    return Place(unit * np.reshape(transform, (2, 3)), code if code != USER_DEFINED else 0)


def _numbers(page: Any, number: int) -> tuple[float, ...]:
    tag = page.tags.get(number)
    value = () if tag is None else tag.value
    return tuple(float(one) for one in (value if isinstance(value, tuple) else (value,)))


def _transform(page: Any) -> tuple[tuple[float, ...] | None, str]:
    """Return (a, b, c, d, e, f), or None and why there is none."""
    matrix, scale, ties = (_numbers(page, tag) for tag in (TRANSFORMATION, PIXEL_SCALE, TIE_POINTS))
    if len(scale) >= 2 and all(0.0 < abs(one) < math.inf for one in scale[:2]):
        i, j, _, x, y, _ = ties[:6] if len(ties) >= 6 else (0.0,) * 6
        sx, sy = (
            scale[0],
            abs(scale[1]),
        )  # GDAL writes a negative one to the west, and reads none to the south
        return (sx, 0.0, x - i * sx, 0.0, -sy, y + j * sy), ""
    if len(matrix) == 16:
        a, b, _, c, d, e, _, f = matrix[:8]
        if all(map(math.isfinite, matrix)) and a * e != b * d:
            return (a, b, c, d, e, f), ""
    if len(ties) >= 12:
        return None, "is placed by ground control points, which do not say how many metres a pixel is"
    return None, NO_METRES


def _to_the_north(rows: Array, transform: tuple[float, ...]) -> tuple[Array, tuple[float, ...]]:
    """Return rows from south to north of numbers from west to east, and the transform of those."""
    a, b, c, d, e, f = transform
    if abs(a) + abs(e) < abs(b) + abs(d):
        rows, a, b, d, e = rows.T, b, a, e, d
    if a < 0.0:
        across = rows.shape[1] - 1
        rows, a, d, c, f = rows[:, ::-1], -a, -d, c + across * a, f + across * d
    if e < 0.0:
        up = rows.shape[0] - 1
        rows, b, e, c, f = rows[::-1], -b, -e, c + up * b, f + up * e
    return rows, (a, b, c, d, e, f)


def _oriented(rows: Array, orientation: int) -> Array:
    """Return the picture as it is seen (TIFF 6.0, Orientation)."""
    if orientation >= 5:
        rows = rows.T
    if orientation in (2, 3, 6, 7):
        rows = rows[:, ::-1]
    if orientation in (3, 4, 7, 8):
        rows = rows[::-1]
    return rows


def _keys(page: Any) -> dict[int, float]:
    """Return the keys of the coordinate system that have numbers (OGC 19-008r4, section 7.1.2)."""
    flat = np.array(_numbers(page, GEO_KEYS), dtype=np.int64)
    doubles = _numbers(page, GEO_DOUBLES)
    found: dict[int, float] = {}
    for name, where, _, value in flat[: len(flat) // 4 * 4].reshape(-1, 4)[1:]:
        if where == 0:
            found[int(name)] = int(value)
        elif where == GEO_DOUBLES and 0 <= value < len(doubles):
            found[int(name)] = doubles[int(value)]
    return found


def _are_degrees(page: Any) -> bool:
    return _keys(page).get(ANGULAR_UNITS, DEGREE) == DEGREE


def _units(page: Any, key: str) -> Units:
    """Return the units of the coordinate system; metres where the file says nothing.

    Errors: SceneError for a unit that is not known, and for coordinates around the middle of the Earth.
    """
    keys = _keys(page)
    model = keys.get(MODEL_TYPE)
    if model == GEOCENTRIC:
        raise SceneError(f"{key} has geocentric coordinates, in which a map has no height: project it first")
    by_code = units_by_code(int(keys.get(PROJECTED_SYSTEM, keys.get(GEOGRAPHIC_SYSTEM, 0))))
    horizontal: float | None = by_code[0] or 1.0
    if (unit := keys.get(LINEAR_UNITS)) is not None:
        horizontal = _length(int(unit), keys.get(LINEAR_SIZE), "lengths", key)
    if model == GEOGRAPHIC or (model is None and GEOGRAPHIC_SYSTEM in keys and PROJECTED_SYSTEM not in keys):
        horizontal = None
    vertical = by_code[1] or units_by_code(int(keys.get(VERTICAL_SYSTEM, 0)))[1]
    if (unit := keys.get(VERTICAL_UNITS)) is not None:
        vertical = _length(int(unit), None, "heights", key)
    if vertical is None:
        return Units(horizontal, 1.0, silent_heights(horizontal))
    return Units(horizontal, vertical)


def _length(code: int, size: float | None, what: str, key: str) -> float:
    if code == USER_DEFINED and size is not None and 0.0 < size < 1e6:
        return size
    if code not in LENGTHS:
        raise SceneError(
            f"{key} measures {what} in a unit that is not known, EPSG {code}: project it to metres"
        )
    return LENGTHS[code]


def _items(page: Any) -> list[ElementTree.Element]:
    tag = page.tags.get(GDAL_METADATA)
    try:
        root = ElementTree.fromstring(str(tag.value).strip("\0 ")) if tag is not None else None
    except ElementTree.ParseError:
        root = None
    found = [] if root is None else list(root.iter("Item"))
    return [item for item in found if item.get("sample", "0") == "0"]


def _item(page: Any, role: str) -> str:
    return next(((item.text or "").strip() for item in _items(page) if item.get("role") == role), "")


def _band(page: Any, key: str) -> tuple[tuple[float, float], float | None]:
    """Return scale and offset of the numbers, and their unit [m] if there is one, as GDAL writes them.

    Errors: SceneError for a scale that is no number, or a unit that is not known.
    """
    try:
        scale, offset = float(_item(page, "scale") or 1.0), float(_item(page, "offset") or 0.0)
    except ValueError:
        scale = offset = math.nan
    if not (math.isfinite(scale) and math.isfinite(offset)) or scale == 0.0:
        raise SceneError(f"{key} has a scale or an offset of its numbers that is no number: take it out")
    word = _item(page, "unittype")
    if word and word.lower() not in UNIT_TYPES:
        raise SceneError(f'{key} measures heights in "{word}", which is not known: save it in metres')
    return (scale, offset), UNIT_TYPES.get(word.lower())

"""Write src/neve/assets/epsg_units.txt: coordinate systems that do not measure in metres.

`pip install pyproj && python tools/maps/epsg_units.py`; pyproj brings the EPSG dataset of PROJ.
"""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

from pyproj import CRS, database
from pyproj.enums import PJType
from pyproj.exceptions import CRSError

TARGET = Path(__file__).parents[2] / "src" / "neve" / "assets" / "epsg_units.txt"
HEAD = """# Units of coordinate systems by their EPSG code: first and last code, metres of a unit of length,
# metres of a unit of height ("-": not stated, or an angle). Codes that do not occur measure lengths in
# metres, and say nothing of heights. From the EPSG Geodetic Parameter Dataset (IOGP, epsg.org), by
# tools/maps/epsg_units.py.
"""
KINDS = (PJType.PROJECTED_CRS, PJType.VERTICAL_CRS, PJType.COMPOUND_CRS)


def units(kind: PJType, code: int) -> tuple[str, str]:
    """Return the metres of a unit of length and of height of a system, as words."""
    axes = CRS.from_epsg(code).axis_info
    lengths = [f"{axis.unit_conversion_factor:.16g}" for axis in axes]
    flat = "-" if kind == PJType.VERTICAL_CRS or "degree" in axes[0].unit_name else lengths[0]
    if axes[0].unit_name in ("grad", "radian"):
        flat = "-"
    return flat, "-" if kind == PJType.PROJECTED_CRS else lengths[-1]


def main() -> None:
    """Write the table; neighbouring codes of the same units share a line."""
    found: dict[int, tuple[str, str]] = {}
    for kind in KINDS:
        for info in database.query_crs_info(auth_name="EPSG", pj_types=kind, allow_deprecated=True):
            try:
                found[int(info.code)] = units(kind, int(info.code))
            except CRSError:
                continue
    lines = []
    for pair, group in groupby(sorted(found), key=lambda code: found[code]):
        codes = list(group)
        if pair not in (("1", "-"), ("-", "-")):
            lines.append(f"{codes[0]} {codes[-1]} {pair[0]} {pair[1]}\n")
    TARGET.write_text(HEAD + "".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()

"""Snow that has fallen before the run: on all that is there, or as a file has it."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import model_validator

from neve.scene.schema.shapes import Shape, Vector
from neve.scene.schema.snow_kinds import REPOSE, SnowKind
from neve.scene.values.fields import (
    ZERO,
    Length,
    Point2,
    Real,
    Size2,
    Whole,
    check_file,
    entry,
    file_entry,
    wrong,
)

LYING = (".npz",)
"""What a file of lying snow ends in."""

DENSITY = (109.0, 6.0, 26.0, 50.0)
"""Of new snow: a, b, c and the least of a + b T + c sqrt(u) [kg/m3], T [deg C], u [m/s]."""
PAHAUT = "Pahaut 1976, as the snow model Crocus has it (constants from memory)"


class Snowfall(Shape):
    """Let snow fall on what is there, colliders, bodies and the sources before it, before the run begins."""

    roles = ("source",)

    shape: Literal["snowfall"] = entry(
        "snowfall", "Snow that has fallen on all that is there ([snowfall](snowfall.md))."
    )
    center: Point2 = entry((0.0, 0.0), "Middle of the rectangle on which it snows, seen from above.", "m")
    size: Size2 = entry((2.0, 2.0), "Extent of the rectangle along x and y.", "m")
    depth: Length | None = entry(
        None, "Depth of the new snow on level open ground; in place of rate. Left out with rate, 0.1.", "m"
    )
    rate: Real | None = entry(
        None, "How fast it snows: water in a unit of time, in place of depth.", "mm/h", gt=0, le=1000
    )
    duration: Real = entry(1.0, "How long it snows; used with rate only.", "h", gt=0, le=10000)
    temperature: Real = entry(
        -5.0, "Temperature of the air, from which the density follows.", "deg C", ge=-60, le=5
    )
    density: Real | None = entry(
        None,
        "Density of the new snow; left out, max(50, 109 + 6 T + 26 sqrt(u)), T the temperature [deg C] and u "
        "the speed of the wind [m/s].",
        "kg/m3",
        PAHAUT,
        gt=0,
        le=917,
    )
    wind: Point2 = entry((0.0, 0.0), "Velocity of the wind along x and y.", "m/s")
    fall_speed: Real = entry(1.0, "Speed at which flakes fall.", "m/s", gt=0, le=20)
    flutter: Real = entry(
        0.1,
        "How far a flake swings aside over 1 m of fall, along x and y each, root mean square; over H metres "
        "sqrt(H) times as far. Large flakes flutter more, and get farther below roofs.",
        "m",
        ge=0,
        le=10,
    )
    stability: Literal["repose", "snowslide", "none"] = entry(
        "repose",
        '"repose": what lies steeper than `repose` slides down or over edges; "snowslide": '
        'slopes above 25 degrees lose what is deeper than they hold, for terrain; "none": all stays.',
        "",
        "Fearing 2000; Bernhardt and Schulz 2010",
    )
    drift: Real = entry(
        0.0,
        "How long wind then moves the snow that lies under the open sky; from about 7 m/s on it does.",
        "h",
        "Pomeroy and Gray 1990 (from memory); a simple model ([snowfall](snowfall.md#drifting))",
        ge=0,
        le=1000,
    )
    drift_wind: Point2 | None = entry(
        None, "Wind that does so, 10 m above the ground; left out, `wind`, in which the snow fell.", "m/s"
    )
    repose: Real | None = entry(
        None,
        "Angle of repose; left out, that of the kind of the new snow ([snows](snows.md)), or 50, that of "
        "fluffy snow.",
        "degrees",
        "observations of heaps of 1 m (slush: from memory)",
        ge=1,
        le=89,
    )
    steps: Whole = entry(
        4,
        "Parts in which it falls: after each, snow slides, and then shelters what is below.",
        "1",
        ge=1,
        le=100,
    )
    cell: Length | None = entry(
        None, "Spacing of the places at which snow is counted; left out, the distance of particles.", "m"
    )
    tolerance: Real = entry(
        0.02,
        "Standard error at which a place has enough flakes, as a share of the open sky's. In each part it "
        "has 4096 at most, of an error below 0.008: values below 0.008 / sqrt(`steps`) change little.",
        "1",
        ge=1e-4,
        le=0.5,
    )
    seed: Whole = entry(0, "Seed of the flakes.", "1", ge=0, lt=2**32)

    @model_validator(mode="after")
    def _check_amount(self) -> Snowfall:
        if self.depth is not None and self.rate is not None:
            raise wrong("rate", "cannot be combined with depth; leave one of them out")
        return self

    @property
    def new_density(self) -> float:
        """Density of the new snow [kg/m3]."""
        if self.density is not None:
            return self.density
        a, b, c, least = DENSITY
        return max(least, a + b * self.temperature + c * math.sqrt(math.hypot(*self.wind)))

    @property
    def angle_of_repose(self) -> float:
        """Angle of repose [degrees]."""
        return REPOSE if self.repose is None else self.repose

    def of_kind(self, kind: SnowKind) -> Snowfall:
        """Return this fall with the angle of repose of `kind`, which falls, where it has none of its own."""
        if self.repose is not None:
            return self
        return self.model_copy(update={"repose": kind.angle_of_repose})

    @property
    def open_depth(self) -> float:
        """Depth of the new snow on level open ground [m]: rate times duration over its density."""
        if self.rate is not None:
            return self.rate * self.duration / self.new_density
        return 0.1 if self.depth is None else self.depth

    @property
    def place(self) -> Vector:
        """Middle of the rectangle, half of the snow's depth above z = 0 [m]."""
        return self.center[0], self.center[1], 0.5 * self.open_depth

    def half_extents(self) -> Vector:
        """Return half of the rectangle and half of the depth on open ground [m]."""
        return 0.5 * self.size[0], 0.5 * self.size[1], 0.5 * self.open_depth

    def thinnest(self) -> tuple[str, float] | None:
        """Return the shorter side of the rectangle [m]: thin snow is scattered particles."""
        return "size", min(self.size)


class Lying(Shape):
    """Take snow that lies from a file, as it was left: layer by layer, or particle by particle."""

    roles = ("source",)

    shape: Literal["lying"] = entry(
        "lying", "Snow that lies, from a file ([snowfall](snowfall.md#from-a-file))."
    )
    file: str = file_entry(
        "cover.npz of `neve snow` or `neve age`, with layers of their own density, temperature, strength and "
        "age; or rest.npz of `neve snow RUN`, the particles at the end of a run; relative to the scene file.",
        LYING,
    )

    @model_validator(mode="after")
    def _check_lying(self) -> Lying:
        check_file(self.file, LYING, "snow that lies")
        return self

    @property
    def place(self) -> Vector:
        """The origin: the file has its places in the world [m]."""
        return ZERO

    def half_extents(self) -> Vector:
        """Return none: only the file tells [m]."""
        return ZERO

    def volume(self) -> float:
        """Return none: only the file tells [m3]."""
        return 0.0

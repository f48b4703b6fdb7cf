"""Describe the camera of films and pictures, how it moves, what it keeps in sight, and their light."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pydantic import model_validator

from neve.scene.values.fields import (
    ZERO,
    Color,
    Coordinate,
    Fraction,
    Part,
    Point3,
    Rate3,
    Real,
    Switch,
    check_times,
    entry,
    norm,
    wrong,
)

SNOW = "snow"
"""What `follow` names, if it is no solid."""
LEAVE_OUT = "leave one of them out, the keyframes for example by --set 'camera.keyframes=[]'"


class CameraKeyframe(Part):
    """Say where a camera is at one moment; what is left out is the camera's own."""

    t: Real = entry(0.0, "Time.", "s", ge=0, le=1e6)
    position: Point3 | None = entry(None, "Where the camera stands at `t`.", "m")
    target: Point3 | None = entry(None, "Point in the middle of the picture at `t`.", "m")
    fov: Real | None = entry(None, "Vertical angle of view at `t`.", "degrees", gt=1, lt=170)
    up: Point3 | None = entry(None, "Direction that is up in the picture at `t`.", "1")


class Camera(Part):
    """Place the camera of films and pictures, and move it."""

    position: Point3 = entry((4.0, -6.0, 2.0), "Where the camera stands.", "m")
    target: Point3 = entry((0.0, 0.0, 0.5), "Point in the middle of the picture.", "m")
    fov: Real = entry(35.0, "Vertical angle of view.", "degrees", gt=1, lt=170)
    up: Point3 = entry(
        (0.0, 0.0, 1.0), "Direction that is up in the picture; not zero, not along the view.", "1"
    )
    keyframes: tuple[CameraKeyframe, ...] = entry(
        (),
        "Views at increasing times. Between them position, target, fov and up follow monotone cubic curves, "
        "without overshoot; the camera rests before the first and after the last. Excludes turntable.",
        "",
        "Fritsch and Butland 1984 (from memory)",
    )
    turntable: Coordinate = entry(
        0.0,
        "Rate at which the camera turns about `up` through its target from t = 0 on, anticlockwise seen from "
        "above; 360 over the length of the run is once around. Excludes keyframes.",
        "degrees/s",
    )
    follow: str | None = entry(
        None,
        'What stays in the middle of the picture, in place of `target`: "snow", the middle of the snow that '
        'moves or has moved, or a solid, such as "bodies.0", "colliders.1" or "robots.0.NAME".',
        "",
    )
    offset: Point3 = entry(
        ZERO, "Added to the place of what is followed: what is in the middle of the picture then.", "m"
    )
    dolly: Switch = entry(
        False,
        "Whether the camera travels along with what it follows, across `up`; otherwise it turns where it "
        "stands.",
        "",
    )
    follow_time: Real = entry(
        0.5,
        "How long before and after a moment places of what is followed count, the less the further away; "
        "longer is calmer.",
        "s",
        ge=0,
        le=1000,
    )
    shutter: Fraction = entry(
        0.0,
        "Share of the time from frame to frame for which the shutter is open, half before and half after the "
        "frame: 0.5 is the 180 degrees that films mostly have, 0 is no motion blur. In `neve render`, and "
        "of flakes that fall everywhere.",
        "1",
    )

    aperture: Real = entry(
        0.0,
        "Radius of the lens: what is nearer or farther than `focus` is out of focus; 0 is a pinhole, where "
        "all is sharp. Only in `neve render` and in exported cameras.",
        "m",
        ge=0,
        le=100,
    )
    focus: Real | None = entry(
        None,
        "Distance along the view at which the picture is sharp; left out, that of the target.",
        "m",
        gt=0,
        le=1e6,
    )

    @model_validator(mode="after")
    def _check(self) -> Camera:
        check_times(self.keyframes)
        if self.keyframes and self.turntable:
            raise wrong("turntable", f"cannot be combined with keyframes; {LEAVE_OUT}")
        if self.follow is None:
            self._check_alone()
            return self
        if not self.follow:
            raise wrong("follow", 'must be "snow" or the name of a solid, such as "bodies.0"')
        for i, key in enumerate(self.keyframes):
            if key.target is not None:
                raise wrong(f"keyframes.{i}.target", f"cannot be combined with camera.follow; {LEAVE_OUT}")
        return self

    def _check_alone(self) -> None:
        """Check what a camera that follows nothing may not have, and where it looks."""
        if self.dolly:
            raise wrong("dolly", 'needs camera.follow = "snow" or the name of a solid')
        if self.offset != ZERO:
            raise wrong("offset", 'needs camera.follow = "snow" or the name of a solid')
        self._check_view("", self)
        for i, key in enumerate(self.keyframes):
            self._check_view(f"keyframes.{i}.", key)

    def _check_view(self, where: str, view: Camera | CameraKeyframe) -> None:
        position, target, up = (
            self.position if view.position is None else view.position,
            self.target if view.target is None else view.target,
            self.up if view.up is None else view.up,
        )
        x, y, z = (b - a for a, b in zip(position, target, strict=True))
        a, b, c = up
        if norm((x, y, z)) < 1e-9:
            key = "position" if where and view.target is None else "target"
            other = "target" if key == "position" else "position"
            raise wrong(f"{where}{key}", f"must differ from camera.{other}")
        if norm((y * c - z * b, z * a - x * c, x * b - y * a)) <= 1e-6 * norm((x, y, z)) * norm(up):
            key = "up" if not where or view.up is not None else "target" if view.target else "position"
            sentence = "up must not be zero or point along the view from position to target"
            raise wrong(f"{where}{key}", sentence[3:] if key == "up" else f"is no view: {sentence}")


class Light(Part):
    """Set the sun and the sky of the film."""

    sun_elevation: Real = entry(30.0, "Height of the sun above the horizon.", "degrees", gt=0, le=90)
    sun_azimuth: Real = entry(200.0, "Direction of the sun: 0 is +x, 90 is +y.", "degrees", ge=-360, le=360)
    sun_strength: Real = entry(1.0, "Brightness of the sun; 1 is a clear day.", "1", ge=0, le=100)
    sky_strength: Real = entry(1.0, "Brightness of the sky; 1 is a clear day.", "1", ge=0, le=100)
    sun_size: Real = entry(
        0.53,
        "Angle across the sun, for the edges of shadows in `neve render`; 0 is parallel light.",
        "degrees",
        "as seen from the earth",
        ge=0,
        le=30,
    )
    sun_color: Color = entry((1.0, 0.94, 0.85), "Red, green and blue of the sun.", "1")
    sky_color: Color = entry((0.62, 0.76, 1.0), "Red, green and blue of the sky.", "1")
    falling: Real = entry(
        0.0,
        "Flakes that fall in a cubic metre of air, in films, pictures and the viewer; 50 is light snowfall.",
        "1/m3",
        ge=0,
        le=10000,
    )
    flake_radius: Real = entry(0.004, "Radius of a flake that falls, on average.", "m", ge=1e-4, le=0.1)
    flake_velocity: Rate3 = entry(
        (0.2, 0.1, -1.0), "Velocity of flakes that fall, on average: with the wind, and down.", "m/s"
    )

    @property
    def towards_sun(self) -> tuple[float, float, float]:
        """Return the unit vector towards the sun; the azimuth turns from x to y."""
        elevation, azimuth = math.radians(self.sun_elevation), math.radians(self.sun_azimuth)
        flat = math.cos(elevation)
        return flat * math.cos(azimuth), flat * math.sin(azimuth), math.sin(elevation)


def unknown(camera: Camera, solids: Sequence[str], robots: int) -> str | None:
    """Return the end of a sentence if `camera` follows what is not there; None if all is well.

    solids: names of the colliders and bodies; robots: how many there are, whose parts only their files name
    """
    name = camera.follow
    if name is None or name == SNOW or name in solids:
        return None
    parts = name.split(".")
    if len(parts) > 2 and parts[0] == "robots" and parts[1].isdecimal() and int(parts[1]) < robots:
        return None
    known = ", ".join(f'"{word}"' for word in (SNOW, *solids))
    return f"must name what is there: {known}" + (', or a part of a robot, "robots.0.NAME"' if robots else "")

"""Describe snow: its law and the constants of all laws, with the rules between them; and its heat.

The constants, their ranges and the limits between them are the laws' own (`neve.scene.values.choices`).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Field, ModelWrapValidatorHandler, Strict, create_model, model_validator
from pydantic.fields import FieldInfo

from neve.scene.schema.snow_kinds import DEFAULT_KIND, SNOWS, Kind
from neve.scene.values.choices import DEFAULT_LAW, LAWS, LawWord, listed, meanings, sources
from neve.scene.values.fields import NoTrace, Part, Real, Switch, entry, rounded_down, wrong

if TYPE_CHECKING:
    from neve._core import Constant

WORDS = ("kind", "law", "plasticity")


def used(law: str, plasticity: str) -> tuple[str, ...]:
    """Return the constants that `law` uses."""
    elastic = LAWS[law].has_elastic_option and plasticity == "none"
    return tuple(c.name for c in LAWS[law].constants if not (elastic and c.is_plastic))


class _Snow(Part):
    """Describe the snow of all sources that do not say otherwise."""

    kind: Kind = entry(
        DEFAULT_KIND,
        "A named snow, whose constants are the defaults of the keys below; `neve list --snow` lists them.",
        "",
    )
    law: LawWord = entry(
        DEFAULT_LAW,
        f"Constitutive law; left out, that of the kind. {meanings(LAWS)}.",
        "",
        sources(LAWS),
    )
    plasticity: Literal["snow", "none"] = entry(
        "snow",
        f"What {listed(name for name, law in LAWS.items() if law.has_elastic_option)} do beyond their "
        'limits: "snow" clamps the stretches and hardens; "none" is elastic alone, until an axis is crushed '
        "to a hundredth.",
        "",
        LAWS[DEFAULT_LAW].source,
    )

    @model_validator(mode="wrap")
    @classmethod
    def _complete(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        if not isinstance(data, Mapping):
            return handler(data)
        snow = handler(_filled(data))
        found = problem(snow, data)
        if found:
            raise wrong(*found)
        return snow

    def constants(self) -> dict[str, float]:
        """Return the constants of this snow's law by their names [SI]."""
        return {constant.name: getattr(self, constant.name) for constant in LAWS[self.law].constants}

    def but(self, changes: Overrides) -> Self:
        """Return this snow with `changes`, unchecked (see `problem`).

        Changes that name a kind, or a law with other constants than this one's, start from that kind or law.
        """
        given = changes.given()
        law = str(given.get("law", self.law))
        if "kind" in given or _family(law) != _family(self.law):
            return self.model_construct(**_filled(given))
        here = used(law, given.get("plasticity", self.plasticity))
        kept = {name: value for name, value in self.model_dump().items() if name in (*WORDS, *here)}
        return self.model_construct(**_filled(kept | given))


def _field(name: str) -> Any:
    """Make the field of a constant from what the laws say; it holds what is legal for any of them."""
    having = {law.name: c for law in LAWS.values() for c in law.constants if c.name == name}
    first, *_ = having.values()
    text = first.meaning.removesuffix(".")
    others = [(law, c.meaning.removesuffix(".")) for law, c in having.items() if c.meaning != first.meaning]
    text += "".join(f"; with {law}: {meaning}" for law, meaning in others)
    if len(having) < len(LAWS):
        text += f"; used by {', '.join(having)}"
    own = [f"{law}: {c.usual:g}" for law, c in having.items() if c.usual != first.usual]
    if own:
        text += f" (default for {', '.join(own)})"
    low, open_low = min((c.low, c.open_low) for c in having.values())
    high, closed_high = max((c.high, not c.open_high) for c in having.values())
    limits = {"gt" if open_low else "ge": low, "le" if closed_high else "lt": high}
    return entry(first.usual, f"{text}.", first.unit, first.source, **limits)


CONSTANTS = tuple(dict.fromkeys(c.name for law in LAWS.values() for c in law.constants))
"""The constants of all laws."""

if TYPE_CHECKING:

    class Snow(_Snow):
        """Describe the snow of all sources; each of `CONSTANTS` is an attribute."""

        def __getattr__(self, name: str) -> float: ...
else:
    Snow = create_model(
        "Snow",
        __base__=_Snow,
        __module__=__name__,
        __doc__=_Snow.__doc__,
        **{name: (Real, _field(name)) for name in CONSTANTS},
    )


class _Overrides(Part):
    """Replace some properties of the scene's snow in one source; what is left out stays as in [snow]."""

    def given(self) -> dict[str, Any]:
        """Return the properties that are not left out."""
        return self.model_dump(exclude_none=True)


def _optional(field: FieldInfo) -> tuple[Any, Any]:
    """Turn a field of Snow into one of the same range that may be left out."""
    extra = field.json_schema_extra
    assert isinstance(extra, dict)
    kind: Any = Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation
    return kind | None, entry(None, field.description or "", str(extra["unit"]), str(extra["source"]))


if TYPE_CHECKING:
    Overrides = _Overrides
else:
    Overrides = create_model(
        "Overrides",
        __base__=_Overrides,
        __module__=__name__,
        __doc__=_Overrides.__doc__,
        **{name: _optional(field) for name, field in Snow.model_fields.items()},
    )


class _SnowKeyframe(Part):
    """Give some constants of [snow] at one moment; what is left out is [snow]'s own."""

    t: Real = entry(0.0, "Time.", "s", ge=0, le=1e6)

    def constants(self) -> dict[str, float]:
        """Return the constants that are not left out."""
        return {
            name: float(value) for name, value in self.model_dump(exclude_none=True, exclude={"t"}).items()
        }


AT_BIRTH = ("rho0",)
"""Constants by which particles are made: no keyframe can change them."""

if TYPE_CHECKING:
    SnowKeyframe = _SnowKeyframe
else:
    SnowKeyframe = create_model(
        "SnowKeyframe",
        __base__=_SnowKeyframe,
        __module__=__name__,
        __doc__=_SnowKeyframe.__doc__,
        **{name: _optional(Snow.model_fields[name]) for name in CONSTANTS if name not in AT_BIRTH},
    )


def problem(snow: _Snow, given: Collection[str]) -> tuple[str, str] | None:
    """Return what is wrong between the values of `snow`: a key and the end of a sentence.

    The key is one of `given` where there is a choice.
    """
    kind, law = SNOWS[snow.kind], snow.law
    if snow.kind != DEFAULT_KIND and _family(kind.law) != _family(law):
        return "law", (
            f'does not fit kind = "{snow.kind}", a snow of the law {kind.law}; leave out the law or the kind'
        )
    if snow.plasticity != "snow" and not LAWS[law].has_elastic_option:
        return "plasticity", f'is not used by law = "{law}"; leave it out'
    here = used(law, snow.plasticity)
    for name, field in Snow.model_fields.items():
        if name not in WORDS and name not in here and getattr(snow, name) != field.default:
            why = 'plasticity = "none"' if name in used(law, "snow") else f'law = "{law}"'
            return name, (
                f"is not used with {why}, which takes {', '.join(here)}; "
                f"leave it out or at its default, {field.default:g}"
            )
    for constant in LAWS[law].constants:
        found = _outside(constant, getattr(snow, constant.name))
        if found:
            return constant.name, f'must be {found} with law = "{law}"'
    return _over_limit(snow, given) if most_strength(snow) < 1 - 1e-9 else None


def most_strength(snow: _Snow) -> float:
    """Return the largest factor that the thresholds of `snow` may have [1]; below 1 it is not legal."""
    return LAWS[snow.law].most_strength(snow.constants()) if snow.plasticity == "snow" else math.inf


def _outside(constant: Constant, value: float) -> str:
    """Return what `value` must be to be legal for the law of `constant`; "" if it is."""
    if value < constant.low or (constant.open_low and value == constant.low):
        return f"{'greater than' if constant.open_low else 'at least'} {constant.low:g}"
    if value > constant.high or (constant.open_high and value == constant.high):
        return f"{'less than' if constant.open_high else 'at most'} {constant.high:g}"
    return ""


def _over_limit(snow: _Snow, given: Collection[str]) -> tuple[str, str]:
    """Say which constant puts the thresholds of `snow` over their law's limit, and how far it may go."""
    law, now = LAWS[snow.law], snow.constants()
    most = law.most_strength(now)
    thresholds, lowers, raises = _acting(snow)
    threshold = max(thresholds, key=lambda name: now[name])
    at_most = rounded_down(now[threshold] * most)
    if lowers and (threshold not in given or lowers[0] in given):
        key = lowers[0]
        return key, (
            f"must be at most {rounded_down(_largest(snow, key))} with {threshold} = {now[threshold]:g}, "
            f"{law.limit}"
        )
    for key in raises:
        if key in given and threshold not in given:
            return key, (
                f"is too small for {threshold} = {now[threshold]:g}; set {threshold} to at most {at_most}"
            )
    whose = [f"{name} = {now[name]:g}" for name in lowers] or [f"this {listed(raises)}"]
    return threshold, f"must be at most {at_most} with {listed(whose)}, {law.limit}"


def strength_rule(snow: _Snow) -> str:
    """Return why the thresholds of `snow` have a limit, with its constants: the end of a sentence."""
    thresholds, lowers, raises = _acting(snow)
    now = snow.constants()
    values = [f"{name} = {now[name]:g}" for name in (*thresholds, *lowers, *raises) if now[name]]
    return f"with {listed(values)}, {LAWS[snow.law].limit}"


def _acting(snow: _Snow) -> tuple[list[str], list[str], list[str]]:
    """Return the thresholds that the limit of `snow` bounds, and other constants that lower or raise it.

    What counts is found from the limit itself: each constant is moved a little.
    """
    law, now = LAWS[snow.law], snow.constants()
    most = law.most_strength(now)
    lowers: list[str] = []
    raises: list[str] = []
    thresholds: list[str] = []
    for constant in law.constants:
        name, little = constant.name, 1e-9 * constant.drawn[1]
        step = -little if now[name] + little >= constant.high else little
        effect = (law.most_strength(now | {name: now[name] + step}) - most) * step
        if effect < 0:
            (thresholds if constant.is_threshold else lowers).append(name)
        elif effect > 0:
            raises.append(name)
    return thresholds, lowers, raises


def _largest(snow: _Snow, name: str) -> float:
    """Return the largest legal value of a constant that is too large, by bisection."""
    law, now = LAWS[snow.law], snow.constants()
    low, high = 0.0, now[name]
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if law.most_strength(now | {name: middle}) >= 1 else (low, middle)
    return high


def _family(law: str) -> tuple[Any, ...]:
    """Return what all laws have in common that share the constants of `law`."""
    return LAWS[law].has_elastic_option, *(c.name for c in LAWS[law].constants)


def _filled(given: Mapping[str, Any]) -> dict[str, Any]:
    """Add to `given` the defaults of its kind and its law; unknown words are left for validation."""
    kind = SNOWS.get(str(given.get("kind", DEFAULT_KIND)))
    law = str(given.get("law", kind.law if kind else ""))
    plasticity = given.get("plasticity", "snow")
    if kind is None or law not in LAWS or plasticity not in ("snow", "none"):
        return dict(given)
    here = used(law, plasticity)
    own = kind.constants if _family(kind.law) == _family(law) else {}
    defaults = {c.name: c.usual for c in LAWS[law].constants} | dict(own)
    return {"law": law} | {name: value for name, value in defaults.items() if name in here} | dict(given)


class Fluid(Snow):
    """Stand for a fluid in the material table: `rho0` is its own, the other constants mean nothing."""


class Water(Part):
    """Describe the water of sources of `phase = "water"`: a fluid that takes no shape of its own."""

    density: Real = entry(1000.0, "Density.", "kg/m3", ge=1, le=2e4)
    bulk_modulus: Real = entry(
        2.2e9, "Resistance to being pressed together.", "Pa", "from memory", ge=1e2, le=1e12
    )
    viscosity: Real = entry(
        1.8e-3,
        "Viscosity; that of water at 0 deg C, 1e-3 at 20 deg C, 1 to 10 of honey.",
        "Pa s",
        "from memory",
        ge=0,
        le=1e6,
    )

    @property
    def material(self) -> Fluid:
        """Return its row of the material table."""
        return Fluid.model_construct(**{**Snow().model_dump(), "rho0": self.density})


CONDUCTIVITY = Annotated[float, Strict(), Field(ge=1e-3, le=1e3), NoTrace]


class Heat(Part):
    """Let snow warm, melt, freeze and sinter; a scene without this table knows no heat."""

    snow_temperature: Real = entry(-2.0, "Temperature of all snow at birth.", "deg C", ge=-100, le=0)
    air_temperature: Real = entry(5.0, "Temperature of the air.", "deg C", ge=-100, le=100)
    air_exchange: Real = entry(
        15.0,
        "Heat that a surface of snow takes from the air per area and kelvin; 10 to 25 in light wind.",
        "W/(m2 K)",
        "from memory",
        ge=0,
        le=1e4,
    )
    sun: Real = entry(
        0.0,
        "Power of the sun, which stands where [light] has it, on an area that faces it; 800 on a clear day.",
        "W/m2",
        ge=0,
        le=1e5,
    )
    albedo: Real = entry(
        0.8,
        "Share of the sun's power that snow throws back; 0.9 when fresh, 0.5 when old and wet.",
        "1",
        "from memory",
        ge=0,
        le=1,
    )
    conductivity: Literal["density"] | CONDUCTIVITY = entry(
        "density",
        'Conductivity of heat, or "density" for that of snow of the particle\'s density and of water.',
        "W/(m K)",
        "Calonne et al. 2011, 2.5e-6 rho^2 - 1.23e-4 rho + 0.024 (formula from memory)",
    )
    heat_speed: Real = entry(
        1.0,
        "Seconds that pass for heat in a second of motion: melting takes hours. The film says so.",
        "1",
        ge=1e-3,
        le=1e6,
    )
    sintering: Switch = entry(
        False,
        "Whether snow at rest grows stronger with time, the faster the warmer.",
        "",
        "power of time 0.21: Szabo and Schneebeli 2007 (from memory)",
    )

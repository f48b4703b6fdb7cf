"""Describe snow: its law and the constants of all laws, with the rules between them."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import ModelWrapValidatorHandler, create_model, model_validator
from pydantic.fields import FieldInfo

from neve.scene.schema.fields import CHOICE, Part, Real, entry, rounded_down, wrong
from neve.scene.schema.snows import SNOWS, Kind

SSCTS = "Stomakhin et al. 2013 (as quoted in public codes)"
BOUNDS = "bounds of the public 88-line MLS-MPM program"
KLAR = "Klar et al. 2016 for the law; value: our choice"
LI = "Li et al. 2021, case I (as quoted in a public code)"

ELASTIC_LAWS = ("stomakhin2013", "neo_hookean", "hencky")
"""Laws of elasticity that share the snow plasticity and its constants."""
WORDS = ("kind", "law", "plasticity")
ALWAYS = ("rho0", "E0", "nu")
USES: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(ELASTIC_LAWS, (*ALWAYS, "xi", "theta_c", "theta_s", "J_P_min", "J_P_max")),
    "drucker_prager": (*ALWAYS, "friction_angle", "cohesion", "J_P_max"),
    "cam_clay": (*ALWAYS, "xi", "M", "beta", "p0", "J_P_min", "J_P_max"),
}
"""Law -> the constants that it uses, when it is plastic."""

LAW_DEFAULTS: Mapping[str, Mapping[str, float]] = {
    "drucker_prager": {"E0": 3.5e5, "nu": 0.3},
    "cam_clay": {"rho0": 250.0, "E0": 3e6, "nu": 0.3, "xi": 1.0},
}
"""Law -> its own defaults, where they differ from the field's."""

MOST_HARDENING = 0.5
"""Largest xi max(theta_c, theta_s). While snow is crushed, hardening multiplies its elastic energy by
exp(xi (1 - J_P)); the work of crushing pays for that as long as xi theta < 2/3 (small, on all axes)."""
MOST_YIELD = 0.1
"""Largest yield pressure, in compression or tension, over the bulk modulus: elastic strains stay moderate."""
LEAST_XI = 1e-4
"""Least hardening of cam_clay, whose plastic strain at the start is asinh(p0 / K) / xi."""


def used(law: str, plasticity: str) -> tuple[str, ...]:
    """Return the constants that `law` uses."""
    return ALWAYS if law in ELASTIC_LAWS and plasticity == "none" else USES[law]


def _constant(name: str, default: float, meaning: str, unit: str, source: str = CHOICE, **limits: Any) -> Any:
    """Make the field of a constant, which says who uses it and whose default is another."""
    laws = [law for law, names in USES.items() if name in names]
    own = [f"{law}: {values[name]:g}" for law, values in LAW_DEFAULTS.items() if name in values]
    text = meaning.removesuffix(".")
    if len(laws) < len(USES):
        text += f"; used by {', '.join(laws)}"
    if own:
        text += f" (default for {', '.join(own)})"
    return entry(default, f"{text}.", unit, source, **limits)


class Snow(Part):
    """Describe the snow of all sources that do not say otherwise."""

    kind: Kind = entry(
        "reference",
        "A named snow, whose constants are the defaults of the keys below; `neve list --snow` tells all.",
        "",
    )
    law: Literal["stomakhin2013", "neo_hookean", "hencky", "drucker_prager", "cam_clay"] = entry(
        "stomakhin2013",
        "Constitutive law; left out, that of the kind. stomakhin2013: fixed-corotated elasticity; "
        "neo_hookean and hencky: other elasticity of the same constants; these three crush, tear and "
        "harden as plasticity says. drucker_prager: loose grains with friction. cam_clay: snow that "
        "compacts, with cohesion.",
        "",
        "stomakhin2013: Stomakhin et al. 2013; drucker_prager: Klar et al. 2016; cam_clay: Gaume et al. 2018 "
        "and Li et al. 2021 (as quoted in public codes)",
    )
    plasticity: Literal["snow", "none"] = entry(
        "snow",
        'What stomakhin2013, neo_hookean and hencky do beyond their limits: "snow" clamps the stretches and '
        'hardens; "none" is elastic alone.',
        "",
        SSCTS,
    )
    rho0: Real = _constant("rho0", 400.0, "Density.", "kg/m3", SSCTS, gt=0, le=2000)
    E0: Real = _constant(
        "E0",
        1.4e5,
        "Young's modulus of snow that is not hardened; larger is icier.",
        "Pa",
        SSCTS,
        gt=0,
        le=1e12,
    )
    nu: Real = _constant("nu", 0.2, "Poisson's ratio.", "1", SSCTS, ge=0, lt=0.5)
    xi: Real = _constant("xi", 10.0, "Hardening; larger is more brittle.", "1", SSCTS, ge=0, le=100)
    theta_c: Real = _constant(
        "theta_c",
        2.5e-2,
        "Critical compression, beyond which snow is crushed for good; smaller is powdery; xi times the "
        f"larger of theta_c and theta_s is at most {MOST_HARDENING:g}.",
        "1",
        SSCTS,
        ge=0,
        lt=1,
    )
    theta_s: Real = _constant(
        "theta_s",
        7.5e-3,
        "Critical stretch, beyond which snow tears; smaller is powdery.",
        "1",
        SSCTS,
        ge=0,
        le=1,
    )
    J_P_min: Real = _constant(
        "J_P_min", 0.6, "Lower bound of J_P inside the hardening alone.", "1", BOUNDS, gt=0, lt=1
    )
    J_P_max: Real = _constant(
        "J_P_max",
        20.0,
        "Upper bound of J_P: grains that fly apart do not remember how far; with drucker_prager, snow torn "
        "apart further bears load again before all that room is closed.",
        "1",
        BOUNDS,
        gt=1,
        le=1e6,
    )
    friction_angle: Real = _constant(
        "friction_angle", 35.0, "Angle of internal friction.", "degrees", KLAR, ge=1, le=80
    )
    cohesion: Real = _constant(
        "cohesion",
        0.0,
        "Shear strength at no pressure; cohesion / tan(friction_angle) is at most a tenth of the bulk "
        "modulus.",
        "Pa",
        KLAR,
        ge=0,
        le=1e9,
    )
    M: Real = _constant(
        "M", 0.5, "Slope of the critical state line: shear stress over pressure.", "1", LI, gt=0, le=3
    )
    beta: Real = _constant(
        "beta",
        0.0,
        "Cohesion: strength in tension over strength in compression.",
        "1",
        LI,
        ge=0,
        le=1,
    )
    p0: Real = _constant(
        "p0",
        3e3,
        "Pressure that crushes at the start, at most a tenth of the bulk modulus.",
        "Pa",
        LI,
        gt=0,
        le=1e9,
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

    def but(self, changes: Overrides) -> Snow:
        """Return this snow with `changes`, unchecked (see `problem`).

        Changes that name a kind, or a law with other constants than this one's, start from that kind or law.
        """
        given = changes.given()
        law = given.get("law", self.law)
        if "kind" in given or _family(law) != _family(self.law):
            return Snow.model_construct(**_filled(given))
        here = used(law, given.get("plasticity", self.plasticity))
        kept = {name: value for name, value in self.model_dump().items() if name in (*WORDS, *here)}
        return Snow.model_construct(**_filled(kept | given))


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


def problem(snow: Snow, given: Collection[str]) -> tuple[str, str] | None:
    """Return what is wrong between the values of `snow`: a key and the end of a sentence.

    The key is one of `given` where there is a choice.
    """
    kind, law = SNOWS[snow.kind], snow.law
    if snow.kind != "reference" and _family(kind.law) != _family(law):
        return "law", (
            f'does not fit kind = "{snow.kind}", a snow of the law {kind.law}; leave out the law or the kind'
        )
    if snow.plasticity != "snow" and law not in ELASTIC_LAWS:
        return "plasticity", f'is not used by law = "{law}"; leave it out'
    here = used(law, snow.plasticity)
    for name, field in Snow.model_fields.items():
        if name not in WORDS and name not in here and getattr(snow, name) != field.default:
            why = 'plasticity = "none"' if name in USES[law] else f'law = "{law}"'
            return name, (
                f"is not used with {why}, which takes {', '.join(here)}; "
                f"leave it out or at its default, {field.default:g}"
            )
    if law == "cam_clay" and snow.xi < LEAST_XI:
        return "xi", f'must be at least {LEAST_XI:g} with law = "cam_clay"'
    if most_strength(snow) >= 1 - 1e-9:
        return None
    return _too_brittle(snow, given) if law in ELASTIC_LAWS else _yields_late(snow, given)


def most_strength(snow: Snow) -> float:
    """Return the largest factor that the thresholds of `snow` may have [1]; below 1 it is not legal."""
    if snow.law == "drucker_prager":
        tension = snow.cohesion / math.tan(math.radians(snow.friction_angle))
        return _most_pressure(snow) / tension if tension else math.inf
    if snow.law == "cam_clay":
        return _most_pressure(snow) / snow.p0
    hardening = snow.xi * max(snow.theta_c, snow.theta_s) if snow.plasticity == "snow" else 0.0
    return MOST_HARDENING / hardening if hardening else math.inf


def _too_brittle(snow: Snow, given: Collection[str]) -> tuple[str, str]:
    """Say that hardening could create energy."""
    theta = "theta_s" if snow.theta_s > snow.theta_c else "theta_c"
    limit = f"so that hardening cannot create energy (xi {theta} at most {MOST_HARDENING:g})"
    if theta in given and "xi" not in given:
        most = rounded_down(MOST_HARDENING / snow.xi)
        return theta, f"must be at most {most} with xi = {snow.xi:g}, {limit}"
    most = rounded_down(MOST_HARDENING / getattr(snow, theta))
    return "xi", f"must be at most {most} with {theta} = {getattr(snow, theta):g}, {limit}"


def _yields_late(snow: Snow, given: Collection[str]) -> tuple[str, str]:
    """Say that grains or clay would flow only at strains that are no longer small."""
    name, value, most, whose = "p0", snow.p0, _most_pressure(snow), "this E0 and nu"
    if snow.law == "drucker_prager":
        most *= math.tan(math.radians(snow.friction_angle))
        name, value, whose = "cohesion", snow.cohesion, "this E0, nu and friction_angle"
    if name not in given and "E0" in given:
        return (
            "E0",
            f"is too small for {name} = {value:g}; set {name} to at most {rounded_down(most)}",
        )
    return name, f"must be at most {rounded_down(most)} with {whose}"


def _most_pressure(snow: Snow) -> float:
    """Return the largest legal yield pressure, in compression or tension [Pa]."""
    return MOST_YIELD * snow.E0 / (3 * (1 - 2 * snow.nu))


def _family(law: str) -> str:
    """Return the name of all laws that share the constants of `law`."""
    return ELASTIC_LAWS[0] if law in ELASTIC_LAWS else law


def _filled(given: Mapping[str, Any]) -> dict[str, Any]:
    """Add to `given` the defaults of its kind and its law; unknown words are left for validation."""
    kind = SNOWS.get(str(given.get("kind", "reference")))
    law = given.get("law", kind.law if kind else None)
    plasticity = given.get("plasticity", "snow")
    if kind is None or law not in USES or plasticity not in ("snow", "none"):
        return dict(given)
    here = used(law, plasticity)
    own = kind.constants if _family(kind.law) == _family(law) else {}
    defaults = {**LAW_DEFAULTS.get(law, {}), **own}
    return {"law": law} | {name: value for name, value in defaults.items() if name in here} | dict(given)

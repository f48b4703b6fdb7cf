"""What to cite: each method that a scene can use, with the works that describe it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from neve.io.version import version
from neve.scene.schema.snowfall import Snowfall
from neve.scene.values.choices import DEFAULT_LAW, LAWS, SPLINES, TRANSFERS

if TYPE_CHECKING:
    from neve.scene.schema.scene import Scene

WORKS: Mapping[str, str] = {
    entry[entry.index("{") + 1 : entry.index(",")]: entry.strip()
    for entry in Path(__file__).with_name("references.bib").read_text(encoding="utf-8").split("\n\n")
    if entry.startswith("@")
}
"""Works by their BibTeX keys."""

# Method -> works that describe it. A method's name is the word that chooses it in a scene, or its table.
METHODS: Mapping[str, tuple[str, ...]] = {
    "mpm": ("sulsky1994", "sulsky1995"),
    "particles": ("goswami2019", "takahashi2014", "cundall1979"),
    "sph": ("gissler2020", "akinci2012", *LAWS[DEFAULT_LAW].cites),
    **{name: tuple(choice.cites) for name, choice in {**LAWS, **SPLINES, **TRANSFERS}.items()},
    "snow": tuple(dict.fromkeys(key for law in LAWS.values() for key in law.plasticity_cites)),
    "semi_implicit": tuple(LAWS[DEFAULT_LAW].cites),  # whose paper has it
    "implicit": ("gast2015",),
    "learned": ("li2022",),
    "poisson": ("bridson2007",),
    "fractal": ("perlin1985",),
    "clods": ("worley1996",),
    "mesh": ("jacobson2013", "barill2018"),
    "snowfall": ("fearing2000",),
    "snowslide": ("bernhardt2010",),
    "bodies": ("todorov2012",),
    "heat": ("calonne2011",),
    "heat.sintering": ("szabo2007",),
    "camera.keyframes": ("fritsch1984",),
    "camera.follow": ("cleveland1979",),
}
GRIDLESS = ("particles", "sph")
"""Methods with neither the laws of the material point method nor its transfers."""


def methods(scene: Scene) -> list[str]:
    """Return the names of the methods that `scene` uses, in the order of the data path."""
    snows = [scene.snow_of(source) for source in scene.bearers]
    laws: list[str] = [snow.law for snow in snows]
    if any(LAWS[snow.law].has_elastic_option and snow.plasticity == "snow" for snow in snows):
        laws.append("snow")
    names = [scene.numerics.method]
    if scene.numerics.method not in GRIDLESS:
        names += [*laws, scene.numerics.spline, scene.numerics.transfer]
    if scene.numerics.is_implicit:
        names.append(scene.numerics.integrator)
        if scene.numerics.integrator == "implicit" and scene.numerics.implicit_plasticity == "learned":
            names.append("learned")
    if scene.numerics.sampling == "poisson":
        names.append("poisson")
    noises = [scene.completed(source).variation for source in scene.sources]
    names += [n.pattern for n in noises if n and (n.stiffness or n.strength or n.density)]
    if any(part.shape == "mesh" for part in (*scene.sources, *scene.colliders, *scene.bodies)):
        names.append("mesh")
    falls = [source for source in scene.sources if isinstance(source, Snowfall)]
    names += ["snowfall"] if falls else []
    names += ["snowslide"] if any(fall.stability == "snowslide" for fall in falls) else []
    if scene.bodies or scene.robots:
        names.append("bodies")
    if scene.heat:
        names += ["heat", *(["heat.sintering"] if scene.heat.sintering else [])]
    names += [f"camera.{key}" for key in ("keyframes", "follow") if getattr(scene.camera, key)]
    if scene.is_keyed or any(emitter.keyframes for emitter in scene.emitters):
        names.append("camera.keyframes")
    return list(dict.fromkeys(names))


def bibtex(scene: Scene) -> str:
    """Return BibTeX entries for Neve and for every work behind the methods of `scene`.

    What has no entry, such as a law or a solver of one's own, is named in lines of comment, with the source
    that it states: BibTeX skips what stands outside of entries.
    """
    names = methods(scene)
    keys = dict.fromkeys(key for name in names for key in METHODS.get(name, ()))
    comments = [line for name in names if (line := _without_entry(name))]
    return "\n\n".join([_neve(), *(WORKS[key] for key in keys if key in WORKS), *comments]) + "\n"


def _without_entry(method: str) -> str:
    """Return a comment about a method if it names no work, or works that have no entry; else nothing."""
    keys = METHODS.get(method, ())
    unknown = [key for key in keys if key not in WORKS]
    if keys and not unknown:
        return ""
    choice = {**LAWS, **SPLINES, **TRANSFERS}.get(method)
    source = f"; its source: {' '.join(choice.source.split())}" if choice and choice.source else ""
    what = f"cites {', '.join(unknown)}, without an entry here" if unknown else "names no work to cite"
    return f"% {method} {what}{source}".replace("@", "(at)")


def _neve() -> str:
    return f"""@software{{neve,
  author  = {{{{The Neve developers}}}},
  title   = {{Neve: a snow laboratory}},
  version = {{{version()}}}
}}"""

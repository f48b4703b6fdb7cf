"""Tell what the named snows are: for the command line, for programs, for the documentation."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from neve.scene.schema.material import Snow, used
from neve.scene.schema.snow_kinds import REPOSE, SNOWS, Tag

MEANING: dict[Tag, str] = {
    "quoted": "read in public code that quotes the paper, which itself was not at hand",
    "derived": "ours, following a tendency that the paper states",
    "chosen": "ours, by eye and by small runs",
}
"""What a tag says about the constants."""


def as_data() -> list[dict[str, Any]]:
    """Return all snows: name, about, law, constants, structure, variation, profile, source, tag, repose."""
    found = []
    for name, kind in SNOWS.items():
        snow = Snow.model_validate({"kind": name})
        found.append(
            {
                "name": name,
                "about": kind.about,
                "law": snow.law,
                "constants": {key: getattr(snow, key) for key in used(snow.law, snow.plasticity)},
                "structure": kind.structure or None,
                "variation": dict(kind.variation) or None,
                "profile": dict(kind.profile) or None,
                "source": kind.source,
                "tag": kind.tag,
                "repose": asdict(kind.repose) if kind.repose else None,
            }
        )
    return found


def as_text() -> str:
    """Return three lines for each snow, a fourth with its angle of repose, and the meaning of the tags."""
    snows = as_data()
    width = max(len(snow["name"]) for snow in snows) + 2
    lines = []
    for snow in snows:
        lines += [
            f"{snow['name']:{width}}{snow['about']}",
            f"{'':{width}}{snow['law']}: {_constants(snow)}",
            f"{'':{width}}{snow['tag']}: {snow['source']}",
        ]
        if repose := snow["repose"]:
            angle = f"fallen, it lies up to {repose['degrees']:g} degrees steep"
            lines.append(f"{'':{width}}{angle}, {repose['tag']}: {repose['source']}")
    return "\n".join([*lines, "", *(f"{tag:{width}}{text}" for tag, text in MEANING.items())])


def as_table() -> str:
    """Return the snows as a table in Markdown."""
    lines = ["| `kind` | what it is | law | constants | source | tag |", "|---|---|---|---|---|---|"]
    for snow in as_data():
        name, law = f"`{snow['name']}`", f"`{snow['law']}`"
        cells = [name, snow["about"], law, _constants(snow), snow["source"], snow["tag"]]
        lines.append(f"| {' | '.join(cells)} |")
    tags = [f"* *{tag}*: {text}." for tag, text in MEANING.items()]
    return "\n".join([*lines, "", *tags, "", *_angles()]) + "\n"


def _angles() -> list[str]:
    """Return the angles of repose as a table in Markdown."""
    lines = [
        "Snow that has fallen ([snowfall](snowfall.md#what-stays)) lies as steeply as its kind has it, where",
        "the fall has no `repose` of its own:",
        "",
        "| `kind` | angle of repose [degrees] | source | tag |",
        "|---|---|---|---|",
    ]
    for name, kind in SNOWS.items():
        if kind.repose:
            lines.append(f"| `{name}` | {kind.repose.degrees:g} | {kind.repose.source} | {kind.repose.tag} |")
    return [*lines, f"| all others | {REPOSE:g} | that of fluffy new snow | chosen |"]


def _constants(snow: dict[str, Any]) -> str:
    """Write the constants, but the usual bounds of J_P, and what differs inside a source."""
    usual = Snow()
    text = [
        f"{name} {value:.5g}"
        for name, value in snow["constants"].items()
        if not name.startswith("J_P") or value != getattr(usual, name)
    ]
    if snow["structure"]:
        text.append(f"structure {snow['structure']}")
    for key in ("variation", "profile"):
        if table := snow[key]:
            text.append(f"{key} ({', '.join(f'{name} {_value(value)}' for name, value in table.items())})")
    return ", ".join(text)


def _value(value: Any) -> str:
    return "/".join(f"{v:g}" for v in value) if isinstance(value, list) else f"{value:g}"

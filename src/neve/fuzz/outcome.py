"""What became of one trial of a campaign, in a form that all campaigns share."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

VERDICTS = ("held", "refused", "failed")


@dataclass(frozen=True)
class Outcome:
    """Hold what became of one trial.

    verdict: "held"; "refused" if Neve declined in one sentence what was drawn, as it promises; or "failed".
    about: what was drawn, in a few words. sentence: why it was refused or failed, "" if it held.
    facts: numbers of the campaign's own, and of a crash its traceback.
    """

    seed: int
    number: int
    verdict: str
    about: str = ""
    sentence: str = ""
    seconds: float = 0.0
    facts: Mapping[str, Any] = field(default_factory=dict)

    def as_json(self) -> str:
        """Return the outcome as one line of JSON; numbers that JSON does not know become words."""
        return json.dumps(_plain(asdict(self)), allow_nan=False)

    def as_text(self) -> str:
        """Return the outcome as a line for the terminal."""
        said = f": {self.sentence}" if self.sentence else ""
        return f"{self.seed}/{self.number:<5}{self.verdict:8}{self.seconds:6.1f} s  {self.about}{said}"


def outcome_of(line: str) -> Outcome:
    """Read an outcome from a line of JSON.

    Errors: ValueError if the line is none.
    """
    table = json.loads(line)
    if not isinstance(table, dict) or table.get("verdict") not in VERDICTS:
        raise ValueError("no outcome of a trial")
    try:
        return Outcome(**table)
    except TypeError as error:
        raise ValueError("no outcome of a trial") from error


def _plain(value: Any) -> Any:
    """Return `value` with floats that are not finite as words."""
    if isinstance(value, dict):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value

"""Kill a run at random moments, hurt its folder, resume it, and compare with a run that nobody touched."""

from __future__ import annotations

import contextlib
import csv
import io
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from neve.fuzz.kills.hurt import HURTS, hurt
from neve.fuzz.outcome import Outcome
from neve.io.errors import RunError
from neve.io.frames import read_frame
from neve.scene.reading.load import scene_from, to_toml

MOST_KILLS = 4
"""Kills of a run at most, besides the damage."""

Random = np.random.Generator


def kill_and_resume(seed: int, number: int) -> Outcome:
    """Run trial `number` of the campaign `seed`.

    It holds if the folder is in the end, byte for byte but for wall times, that of a run in one go; or if a
    folder that was hurt is refused in one sentence, or what is not mended was told by a warning.
    """
    rng = np.random.default_rng([seed, number])
    place = Path(tempfile.mkdtemp(prefix="neve-kills-"))
    try:
        scene = place / "scene.toml"
        scene.write_text(
            to_toml(scene_from(draw(rng), where=f"fuzz kills {seed}/{number}")), encoding="utf-8"
        )
        started = time.perf_counter()
        straight = _run(scene, place / "straight")
        if straight.returncode:
            return Outcome(seed, number, "failed", "", f"a plain run ended with {straight.stderr[-300:]}")
        return _attack(rng, seed, number, scene, place, time.perf_counter() - started)
    finally:
        shutil.rmtree(place, ignore_errors=True)


def draw(rng: Random) -> dict[str, Any]:
    """Draw a small scene with outputs of all kinds."""
    outputs: list[dict[str, Any]] = [{"kind": "checkpoint", "every_frames": int(rng.integers(1, 4))}]
    if rng.random() < 0.5:
        outputs.append({"kind": "fragments", "name": "more.csv", "every_frames": int(rng.integers(1, 4))})
    if rng.random() < 0.3:
        outputs.append({"kind": "frames", "every_frames": int(rng.integers(1, 4))})
    if rng.random() < 0.3:
        outputs.append({"kind": "film", "name": "side.mp4", "every_frames": int(rng.integers(1, 3))})
    return {
        "numerics": {"dx": 0.1, "transfer": str(rng.choice(["apic", "flip", "asflip", "pic"]))},
        "sources": [{"shape": "sphere", "radius": 0.2, "center": [0, 0, 0.3], "velocity": [1, 0, -5]}],
        "colliders": [{"shape": "plane"}],
        "bodies": [{"shape": "box", "size": [0.2, 0.2, 0.2], "center": [0.4, 0, 0.3]}] * (rng.random() < 0.3),
        "run": {
            "duration": float(rng.integers(6, 16)) / 100,
            "fps": 100,
            "film": bool(rng.random() < 0.3),
            "fragments": bool(rng.random() < 0.5),
        },
        "outputs": outputs,
    }


def _attack(rng: Random, seed: int, number: int, scene: Path, place: Path, seconds: float) -> Outcome:
    out, kills = place / "out", int(rng.integers(1, MOST_KILLS + 1))
    done = sum(_killed(scene, out, float(rng.uniform(0.0, seconds))) for _ in range(kills))
    damage = str(rng.choice(list(HURTS))) if rng.random() < 0.5 else ""
    elsewhere = place / "elsewhere"
    before = None
    if damage and (out / "run.json").exists():
        damage = f"{damage} {hurt(rng, damage, out, elsewhere)}".strip()
        before = _files(elsewhere)
    end = _run(scene, out)
    about = f"{done} kills" + (f", then {damage}" if damage else "")
    facts: dict[str, Any] = {"kills": done, "damage": damage.partition(" ")[0]}
    sentence = " ".join(end.stderr.split())[-300:]
    differ = [] if end.returncode else differences(place / "straight", out)
    if damage:
        differ = [name for name in differ if not _is_told_when_read(name, place / "straight", out)]
    facts["told"] = bool(differ and damage and "warning" in sentence)
    verdict = "held"
    if before is not None and _files(elsewhere) != before:
        verdict, sentence = "failed", "a file outside the folder was touched"
    elif end.returncode == 2 and damage and end.stderr.count("\n") <= 2 and "Traceback" not in end.stderr:
        verdict = "refused"
    elif end.returncode:
        verdict, sentence = "failed", f"the resumed run ended with {end.returncode}: {sentence}"
    elif differ and not facts["told"]:
        verdict, sentence = "failed", f"other bytes in {', '.join(differ)[:300]}"
    return Outcome(seed, number, verdict, about, sentence, 0.0, facts)


def _command(scene: Path, out: Path) -> list[str]:
    """Return the command that begins the run in `out`, or goes on with it."""
    from neve.io.run_folder import RunFolder

    words = ["--resume"] if RunFolder(out).is_run() else []
    command = [sys.executable, "-m", "neve.cli", "run", str(scene), "--out", str(out)]
    return [*command, "--threads", "1", "--quiet", *words]


def _run(scene: Path, out: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(_command(scene, out), capture_output=True, text=True, check=False, errors="replace")


def _killed(scene: Path, out: Path, after: float) -> bool:
    """Run on for `after` seconds of wall time, then kill; return whether there was something to kill."""
    process = subprocess.Popen(_command(scene, out), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        process.wait(after)
        return False
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGKILL)
        process.wait()
        return True


def differences(one: Path, other: Path) -> list[str]:
    """Return the names of files that are not the same in two run folders; wall times do not count."""
    first, second = _files(one), _files(other)
    return sorted(name for name in first.keys() | second.keys() if first.get(name) != second.get(name))


def _is_told_when_read(name: str, one: Path, other: Path) -> bool:
    """Tell whether a frame that was hurt is refused when it is read, or reads as it was."""
    if not (name.startswith("frames/") and (other / name).exists()):
        return False
    frame = int(Path(name).stem)
    try:
        found: tuple[Any, ...] = read_frame(other / "frames", frame)
    except RunError:
        return True
    whole: tuple[Any, ...] = read_frame(one / "frames", frame)
    return all(np.array_equal(a, b) for a, b in zip(found, whole, strict=True))


def _files(folder: Path) -> dict[str, object]:
    found: dict[str, object] = {}
    for path in folder.rglob("*"):
        name = str(path.relative_to(folder))
        if ".parts/" in name:  # of a film that is not finished, or whose frames are not kept
            continue
        if name.endswith(".mp4"):  # encoded in pieces, which begin anew where a process was killed
            found[name] = "a film"
        elif path.is_file():
            data = path.read_bytes()
            found[name] = _timeless(data) if name == "log.csv" else data
    return found


def _timeless(log: bytes) -> object:
    with contextlib.suppress(csv.Error):
        rows = csv.DictReader(io.StringIO(log.decode(errors="replace")))
        return [{k: v for k, v in row.items() if k and not k.startswith("seconds_")} for row in rows]
    return log


def summary(outcomes: Sequence[Outcome]) -> str:
    """Say how many kills there were, and what the damage was."""
    kills = sum(int(outcome.facts.get("kills", 0)) for outcome in outcomes)
    kinds = Counter(str(outcome.facts["damage"]) for outcome in outcomes if outcome.facts.get("damage"))
    told = sum(bool(outcome.facts.get("told")) for outcome in outcomes)
    damage = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items())) or "none"
    return f"{kills:,} kills; damage: {damage}; {told} told by a warning what could not be mended"

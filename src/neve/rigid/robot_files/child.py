"""The process in which robot files are read first: a crash of the engine's parser ends it, and nothing else.

It reads a line of JSON, {"path": ..., "text": ...}, and answers with one: {"files": [...]} or {"error": ...}.
It ends when its input does.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
from pathlib import Path

from neve.rigid.engine import engine
from neve.rigid.robot_files.limits import SECONDS, limit_memory, limit_seconds
from neve.rigid.robot_files.reading import examine
from neve.scene.errors import SceneError


def serve() -> None:
    """Answer line by line; what the engine prints goes nowhere."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    engine().set_mju_user_warning(_no_word)
    limit_memory()
    for line in sys.stdin:
        asked = json.loads(line)
        limit_seconds(SECONDS)
        answers.write(json.dumps(_answer(asked["path"], asked["text"])) + "\n")
        answers.flush()


def _answer(path: str, text: str) -> dict[str, object]:
    try:
        return {"files": examine(Path(path), text)}
    except SceneError as error:
        return {"error": str(error)}
    except MemoryError:
        return {"error": f"{text} cannot be read as a robot: it needs too much memory"}
    except Exception as error:  # whatever the parser raises is a word about the file
        words = " ".join(str(error).split())[:200] or type(error).__name__
        return {"error": f"{text} cannot be read as a robot: {words}"}


def _no_word(text: str) -> None:
    """Say nothing: the process that reads the file next will."""


if __name__ == "__main__":
    with contextlib.suppress(BrokenPipeError):
        serve()

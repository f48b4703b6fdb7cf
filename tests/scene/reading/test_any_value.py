"""Whatever stands at whatever key of a scene: it is read, or refused in one sentence that names the key."""

import math
import warnings

import pytest
from pydantic import BaseModel

from neve.scene.errors import SceneError, SceneWarning
from neve.scene.reading.load import load
from neve.scene.schema.scene import Scene
from neve.scene.schema.tables import entry_models, table_of_list
from neve.scene.values.allowed import part
from neve.scene.values.fields import LEAST, NoTrace
from neve.scene.values.kinds import Kind, kind_of

VALUES = ("{}", "[]", '""', "true", "nan", "-inf", "1e-320", "-1e308", "9" * 30, "{a={b=1}}", "[[[]]]",
          "[{}]", "[1e-320,1e-320,1e-320]", "[nan,nan]", "1979-05-27", '"\\u0000"')  # fmt: skip
"""Values of wrong types and of extremes, as in a scene file."""
NEEDED = {"mesh": 'file = "a.ply"', "terrain": 'file = "a.png"', "text": 'text = "A"'}


def keys(model: type[BaseModel], path: tuple[str, ...] = ()):
    """Yield the path of each key of a part of the scene, and its field."""
    for name, field in model.model_fields.items():
        inner = part(field.annotation)
        yield (*path, name), field
        if inner is not None:
            yield from keys(inner, (*path, name))
        if path and (table := table_of_list(field.annotation)) is not None:
            yield from keys(table, (*path, name, "0"))


def places():
    """Yield each key of a scene once: its path, its field, and the tables that it needs in a file."""
    seen = set()
    for path, field in keys(Scene):
        yield path, field, ""
        if len(path) > 1:
            continue
        (tag, models), table = entry_models(field.annotation), table_of_list(field.annotation)
        for word, model in [*models.items(), *([("", table)] if table else [])]:
            head = f"[[{path[0]}]]\n" + (f'{tag} = "{word}"\n' if tag else "") + NEEDED.get(word, "")
            for inner, of in keys(model):
                if (path, inner, repr(of)) not in seen:
                    seen.add((path, inner, repr(of)))
                    yield (*path, "0", *inner), of, head


PLACES = {
    ".".join((*path, head.partition('"')[2].partition('"')[0])): (path, head) for path, _, head in places()
}


@pytest.fixture
def attempt(tmp_path):
    """A function that reads a scene with a value at a key."""
    file = tmp_path / "scene.toml"

    def read(path, head, value):
        source = "" if head.startswith("[[sources]]") else '[[sources]]\nshape = "sphere"\n'
        file.write_text(f"{source}{head}\n")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", SceneWarning)
            load(str(file), [f"{'.'.join(path)}={value}"])

    return read


def test_every_key_takes_any_value_or_says_why_not(attempt):
    """No traceback, no warning of NumPy or pydantic, one line that names the first word of the key."""
    refused = 0
    for path, head in PLACES.values():
        for value in VALUES:
            try:
                attempt(path, head, value)
            except SceneError as error:
                refused += 1
                said = str(error)
                assert "\n" not in said
                assert path[0] in said
                assert len(said) < 1000
            except Exception as error:
                pytest.fail(f"{'.'.join(path)} = {value}: {error!r}")
    assert refused > 0.5 * len(PLACES) * len(VALUES)


def numbers(kind: Kind):
    """Yield the kinds of numbers in a kind of values."""
    if kind.name == "number":
        yield kind
    for member in kind.members:
        yield from numbers(member)


def test_every_number_has_finite_bounds_and_no_trace_passes(attempt):
    """Of each number: an upper bound or a check, and nothing nearer to 0 than LEAST but 0 itself."""
    unbounded = []
    for path, field, head in places():
        for kind in numbers(kind_of(field.annotation, field.metadata)):
            top = min(kind.limits.get("le", math.inf), kind.limits.get("lt", math.inf))
            low = max(kind.limits.get("ge", -math.inf), kind.limits.get("gt", -math.inf))
            if not (math.isfinite(top) and math.isfinite(low)):
                unbounded.append(".".join(path))
            if low <= 0 <= top and field.annotation is float:
                with pytest.raises(SceneError, match=r"not nearer to it than|is empty in this scene"):
                    attempt(path, head, f"{LEAST / 2 if top > 0 else -LEAST / 2}")
    assert unbounded == []
    assert NoTrace.func(-LEAST) == -LEAST
    assert NoTrace.func(0.0) == 0.0

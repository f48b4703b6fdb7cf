"""Scene documents by Hypothesis, drawn from the schema itself, and ways to spoil them."""

import copy
import datetime
import math

from hypothesis import strategies as st

from neve.scene.schema.scene import Scene
from neve.scene.schema.tables import entry_models, table_of_list
from neve.scene.values.allowed import part
from neve.scene.values.kinds import kind_of

OWN_FILES = {"meshes": "neve:boot", "terrains": "neve:hill"}
FILE_SHAPES = {"mesh", "terrain", "text"}
TEXT = st.text(st.characters(codec="utf-8", exclude_categories=["Cs"]), max_size=20)
FEW = 3
"""Most entries of a list."""


def number(limits, is_whole):
    """Numbers within limits, at both ends of the range and over its decades."""
    low, high = limits.get("ge", limits.get("gt")), limits.get("le", limits.get("lt"))
    if is_whole:
        low = 0 if low is None else math.ceil(low) + ("gt" in limits)
        high = 2**31 if high is None else math.floor(high) - ("lt" in limits)
        return st.integers(int(low), int(high)) | st.integers(int(low), min(int(high), int(low) + 10))
    wide = st.floats(
        low,
        high,
        exclude_min="gt" in limits,
        exclude_max="lt" in limits,
        allow_nan=False,
        allow_infinity=False,
    )
    least = 1e-3 if low is None else max(low, 0.0) + 1e-3
    most = 10.0 if high is None else min(high, 10.0)
    return wide | st.floats(least, most) if least < most else wide


def value(annotation, metadata):
    """Values that an annotation of the schema allows by itself."""
    kind = kind_of(annotation, metadata)
    inner = part(annotation)
    if inner is not None:
        return table(inner)
    tag, models = entry_models(annotation)
    if models:
        entries = [table(model, {tag: word}) for word, model in models.items()]
        return st.lists(st.one_of(entries), max_size=FEW)
    if (listed := table_of_list(annotation)) is not None:
        return st.lists(table(listed), max_size=FEW)
    return of_kind(kind)


def of_kind(kind):
    """Values of a kind (see neve.scene.values.kinds)."""
    match kind.name:
        case "choice":
            return st.sampled_from(kind.choices)
        case "union":
            return st.one_of([of_kind(member) for member in kind.members])
        case "vector":
            return st.tuples(*[of_kind(kind.members[0])] * kind.count).map(list)
        case "list":
            return st.lists(of_kind(kind.members[0]), max_size=FEW)
        case "text":
            return TEXT.filter(lambda text: len(text) >= kind.min_length)
        case "switch":
            return st.booleans()
        case "integer" | "number":
            return number(kind.limits, kind.name == "integer")
        case _:
            return st.just({})


def table(model, fixed=None):
    """Tables of a part of the schema, each key given or left out."""
    keys = {}
    for name, field in model.model_fields.items():
        extra = field.json_schema_extra or {}
        if name in (fixed or {}):
            continue
        if "suffixes" in extra:
            own = OWN_FILES.get(extra["folder"])
            if own:
                keys[name] = st.just(own)
            continue
        keys[name] = value(field.annotation, field.metadata)
    return st.fixed_dictionaries({}, optional=keys).map(lambda drawn: {**(fixed or {}), **drawn})


documents = st.deferred(lambda: table(Scene))
"""Tables of whole scenes, each value in its range; rules between values may be broken."""

SPOILERS = st.sampled_from(
    [
        math.nan,
        math.inf,
        -math.inf,
        5e-324,
        1e-320,
        -5e-324,
        -0.0,
        0,
        0.0,
        -1,
        1e308,
        -1e308,
        2**31,
        2**32,
        2**63,
        10**30,
        10**400,
        -(10**30),
        True,
        False,
        "",
        " ",
        "\u2603\U0001f3bf",
        "\x7f\x1b[31m",
        "\u202e",
        "nan",
        "x" * 5000,
        "a\nb",
        "{0} %s {key}",
        [],
        {},
        [[]],
        [{}],
        {"a": {"b": {"c": 1}}},
        {"": 1},
        {"\u2603": [1, {"x": 2}]},
        [0.0] * 500,
        [1, "a", True],
        [[[[[[[[1]]]]]]]],
        datetime.datetime(2026, 1, 1, tzinfo=datetime.UTC),
        datetime.date(2026, 1, 1),
        datetime.time(1, 2, 3),
    ]
)
"""What no key of a scene, or only few, may hold."""

KEYS = st.sampled_from(["", "x", "shpae", "dx", "a.b", "\u2603", "__class__", "0", "model_fields", "snow"])


def places(tree, path=()):
    """Yield the paths of all values of a tree of tables and lists."""
    entries = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, inner in entries:
        yield (*path, key)
        yield from places(inner, (*path, key))


def holder(tree, path):
    """Return the table or list that holds the last key of a path."""
    for key in path[:-1]:
        tree = tree[key]
    return tree


@st.composite
def spoilt(draw):
    """Documents of which one to three places were replaced, removed, renamed or added to."""
    tree = copy.deepcopy(draw(documents))
    for _ in range(draw(st.integers(1, 3))):
        paths = list(places(tree))
        way = draw(st.sampled_from(["replace", "remove", "rename", "add", "whole"]))
        if way == "whole" or not paths:
            tree[draw(st.sampled_from(list(Scene.model_fields)))] = copy.deepcopy(draw(SPOILERS))
            continue
        path = draw(st.sampled_from(paths))
        place = holder(tree, path)
        if way == "replace":
            place[path[-1]] = copy.deepcopy(draw(SPOILERS))
        elif way == "remove":
            del place[path[-1]]
        elif way == "rename" and isinstance(place, dict):
            place[draw(KEYS)] = place.pop(path[-1])
        elif isinstance(place, dict):
            place[draw(KEYS)] = copy.deepcopy(draw(SPOILERS))
        else:
            place.append(copy.deepcopy(draw(SPOILERS)))
    return tree

"""Which runs a sweep has: values, ranges, and designs."""

import math

import numpy as np
import pytest

from neve.io.errors import RunError
from neve.sweep import grid, latin, read_vary, together
from neve.sweep.design import changes_of
from neve.sweep.plan import read_plan


def values(text):
    """Return the values of a grid in the text of --vary."""
    return read_vary(text).listed()


def test_values_and_ranges():
    """Values are TOML or bare words; a range has both its ends, and equal steps or equal factors between."""
    assert values("snow.xi=5,10.5") == (5, 10.5)
    assert values("numerics.transfer=apic,flip") == ("apic", "flip")
    assert values("sources.0.velocity=[0, 0, -1],[0, 0, -2]") == ([0, 0, -1], [0, 0, -2])
    assert values("run.film=true,false") == (True, False)
    assert values("snow.xi=5..10:6") == (5, 6, 7, 8, 9, 10)
    assert all(isinstance(value, int) for value in values("snow.xi=5..10:6"))
    assert values("snow.nu=0.1..0.3:3") == pytest.approx((0.1, 0.2, 0.3))
    by_factors = values("snow.E0=1e3..1e6:4:log")
    assert (by_factors[0], by_factors[-1]) == (1e3, 1e6), "the ends are exact"
    assert by_factors == pytest.approx((1e3, 1e4, 1e5, 1e6), rel=1e-12)
    assert values('about="a..b"') == ("a..b",), "two dots within quotes are no range"


def test_designs():
    """A grid is all combinations, the last key fastest; together takes the first values of all, and so on."""
    a, b = read_vary("a.x=1,2"), read_vary("b.y=3..5:3")
    assert grid([a, b]) == [{"a.x": x, "b.y": y} for x in (1, 2) for y in (3, 4, 5)]
    assert together([a, read_vary("b.y=7,8")]) == [{"a.x": 1, "b.y": 7}, {"a.x": 2, "b.y": 8}]
    assert changes_of({"a.x": 0.1, "b.y": "word", "c": [1, 2]}) == ["a.x=0.1", 'b.y="word"', "c=[ 1, 2, ]"]


@pytest.mark.parametrize("samples", [1, 2, 7, 40])
def test_latin_hypercube(samples):
    """Each of as many equal parts of a range has one value, of a logarithmic range each equal factor."""
    varied = [read_vary("a=-2..6"), read_vary("b=1e2..1e6:log"), read_vary("c=p,q")]
    points = latin(varied, samples, seed=3)
    assert points == latin(varied, samples, seed=3)
    assert samples == 1 or points != latin(varied, samples, seed=4)
    shares = (
        [(point["a"] + 2) / 8 for point in points],
        [math.log10(point["b"] / 1e2) / 4 for point in points],
    )
    for share in shares:
        assert sorted(np.floor(np.array(share) * samples)) == [*range(samples)]
    assert abs(sum(point["c"] == "p" for point in points) - samples / 2) <= 0.5


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("snow.xi", "write KEY=VALUE"),
        ("snow.xi=", "write KEY=VALUE"),
        ("snow..xi=1", "write KEY=VALUE"),
        ("snow.xi=1,,2", "write KEY=VALUE"),
        ("snow.xi=[1,2", "not valid TOML"),
        ("snow.xi=5,5", "the value 5 is there twice"),
        ("snow.xi=5..3:2", "to a greater one"),
        ("snow.xi=0..3:2:log", "begins above 0"),
        ("snow.xi=1..3:1", "2 to 100,000 values"),
        ("snow.xi=1..nan:3", "finite"),
        ("snow.xi=1..3:2:lin", "write KEY=VALUE"),
    ],
)
def test_bad_values_are_one_sentence(text, said):
    """The sentence names the option, what stood there and what is allowed."""
    with pytest.raises(RunError, match=said) as told:
        read_vary(text)
    assert "--vary snow" in str(told.value)


def test_bad_designs_are_one_sentence():
    """A range without a count, keys with unlike numbers of values, one key twice, and too many runs."""
    with pytest.raises(RunError, match="a range needs a count"):
        grid([read_vary("a=1..2")])
    with pytest.raises(RunError, match="a has 2, b has 3"):
        together([read_vary("a=1,2"), read_vary("b=1,2,3")])
    with pytest.raises(RunError, match="varied twice"):
        grid([read_vary("a=1,2"), read_vary("a=3,4")])
    with pytest.raises(RunError, match=r"1,000,000 runs: 1 to 100,000"):
        grid([read_vary("a=1..1000:1000"), read_vary("b=1..1000:1000")])


PLAN = """
scene = "ball.toml"
set = ["numerics.dx=0.1"]
frames = 3
[vary]
"snow.xi" = [5, 10]
"snow.E0" = { from = 1e5, to = 1e6, count = 2, scale = "log" }
[[points]]
snow = { xi = 7, nu = 0.3 }
[outputs]
peak = "kinetic@max"
"""


def test_a_plan_says_the_same_as_options(tmp_path):
    """The scene is seen from the plan's folder; single points come after the design."""
    (tmp_path / "ball.toml").write_text("")
    (tmp_path / "plan.toml").write_text(PLAN)
    plan = read_plan(tmp_path / "plan.toml")
    assert plan.scene == str(tmp_path / "ball.toml")
    assert plan.points == [
        *grid([read_vary("snow.xi=5,10"), read_vary("snow.E0=1e5..1e6:2:log")]),
        {"snow.xi": 7, "snow.nu": 0.3},
    ]
    assert (plan.frames, plan.changes, plan.measures[0].name) == (3, ["numerics.dx=0.1"], "peak")


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("samples = 3", "samples is of"),
        ('design = "cube"', "design = 'cube'"),
        ("frames = 0", "frames = 0"),
        ('"snow.mu" = []', "has no values"),
        ('"snow.mu" = { from = 1 }', "vary.snow.mu.to"),
        ("colour = 3", "colour = 3"),
        ("x = [", "not valid TOML"),
    ],
)
def test_bad_plans_are_one_sentence(tmp_path, line, said):
    """File, key and value are named."""
    text = f"scene = 'ball'\n{line}\n" if "snow.mu" not in line else f"scene = 'ball'\n[vary]\n{line}\n"
    (tmp_path / "plan.toml").write_text(text + ("" if "[vary]" in text else '[vary]\n"snow.xi" = [1, 2]\n'))
    with pytest.raises(RunError, match=said):
        read_plan(tmp_path / "plan.toml")

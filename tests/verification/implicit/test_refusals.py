"""What an integrator cannot do is refused by the scene, in one sentence that says what may be set."""

import pytest
from pydantic import ValidationError
from verification.scenes import box, scene

from neve.scene.checks.unused import unused


@pytest.mark.parametrize("integrator", ["semi_implicit", "implicit"])
@pytest.mark.parametrize(
    ("key", "numerics"),
    [("transfer", {"transfer": "asflip"}), ("method", {"method": "sph"}), ("device", {"device": "cuda"})],
)
def test_other_ways_are_refused(integrator, key, numerics):
    """The sentence names the integrator, the key and its value; explicit steps take them all."""
    with pytest.raises(
        ValidationError, match=rf'cannot be "{integrator}" with numerics\.{key} = "{numerics[key]}"'
    ):
        scene([box()], integrator=integrator, **numerics)
    scene([box()], **numerics)


def test_sleep_is_refused():
    """Snow that sleeps is not in the equations."""
    with pytest.raises(
        ValidationError, match=r'with numerics\.sleep = true: set "explicit", or sleep = false'
    ):
        scene([box()], integrator="implicit", sleep=True)
    scene([box()], integrator="explicit", sleep=True)
    scene([box()], integrator="implicit", sleep=False)


@pytest.mark.parametrize("integrator", ["semi_implicit", "implicit"])
def test_heat_is_refused(integrator):
    """Snow that warms is not in the equations; explicit steps take it."""
    from neve.scene.reading.load import scene_from

    def made(word):
        scene_from({"numerics": {"integrator": word}, "heat": {"air_temperature": -5.0}, "sources": [box()]})

    with pytest.raises(
        ValueError, match=rf'cannot be "{integrator}" with heat: set "explicit", or leave heat out'
    ):
        made(integrator)
    made("explicit")


def test_the_midpoint_rule_refuses_what_it_cannot():
    """Bodies, which would bounce, and further modes of velocity; both integrators take bodies otherwise."""
    from neve.scene.reading.load import scene_from

    def made(**more):
        tables = {"numerics": {"integrator": "implicit"} | more, "sources": [box()]}
        return scene_from(tables | {"bodies": [{"shape": "sphere", "radius": 0.1, "center": [1, 0, 0]}]})

    made()
    with pytest.raises(ValueError, match=r'implicit_rule.* cannot be "midpoint" with bodies: set "end"'):
        made(implicit_rule="midpoint")
    with pytest.raises(
        ValidationError, match=r'"midpoint" with numerics\.transfer = "polypic": set transfer'
    ):
        scene([box()], integrator="implicit", implicit_rule="midpoint", transfer="polypic")


def test_the_midpoint_rule_refuses_a_beta_below_one():
    """Only `semi_implicit` reads it. It would add energy in each step, s = (w dt / 2)^2.

    M (w - v) = -dt/2 K (x + beta dt/2 w), x' = x + dt w, v' = 2 w - v have the determinant
    2 (1 + s) / (1 + beta s) - 1, more than 1 for any beta < 1: 1.024 with 20 steps a period and beta 1/2.
    """
    how = {"implicit_rule": "midpoint", "implicit_beta": 0.5}
    with pytest.raises(
        ValidationError, match=r'"midpoint" with numerics\.implicit_beta = 0\.5: set implicit_beta = 1'
    ):
        scene([box()], integrator="semi_implicit", **how)
    scene([box()], integrator="semi_implicit", implicit_rule="midpoint")
    scene([box()], integrator="implicit", **how)


def test_keys_without_effect_are_told():
    """Keys of other integrators are named; those that are read are not."""
    found = list(unused(scene([box()], integrator="implicit", implicit_beta=0.7)))
    assert len(found) == 1
    assert found[0].startswith("numerics.implicit_beta = 0.7 has no effect")

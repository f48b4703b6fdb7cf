"""What laws, transfers and splines publish about themselves: ranges, limits and papers that hold together."""

import numpy as np
import pytest

from neve import _core
from neve.cli.cite import WORKS
from neve.scene.schema.scene import Numerics
from neve.scene.values.choices import LAWS, SPLINES, TRANSFERS


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_defaults_and_draws_are_legal(law):
    """low <= usual <= high, and random trials draw from inside the range, without its open ends."""
    assert len({c.name for c in law.constants}) == len(law.constants)
    for c in law.constants:
        for value in (c.usual, *c.drawn):
            assert c.low <= value <= c.high, c.name
            assert not (c.open_low and value == c.low), c.name
            assert not (c.open_high and value == c.high), c.name
        assert c.drawn[0] < c.drawn[1]
        assert "" not in (c.unit, c.source), c.name
        assert c.meaning.endswith("."), c.name


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_strength_multiplies_thresholds(law):
    """Thresholds times f leave room for a factor 1 / f of what there was; the usual ones are legal."""
    usual = {c.name: c.usual or 1.0 for c in law.constants}
    most = law.most_strength(usual)
    stronger = {c.name: usual[c.name] * (4.0 if c.is_threshold else 1.0) for c in law.constants}
    assert law.most_strength(stronger) == pytest.approx(most / 4, rel=1e-12)
    assert law.most_strength({}) >= 1.0
    assert law.limit


@pytest.mark.parametrize("law", [law for law in LAWS.values() if law.has_elastic_option])
@pytest.mark.parametrize(("xi", "theta"), [(10.0, 0.025), (50.0, 0.008), (2.0, 0.2)])
def test_compression_stays_affordable(law, xi, theta):
    """L = x / xi, (exp(x) - 1) / x = 2 / (3 xi theta), to the 2^-60 of a bisection; strength widens theta."""
    constants = {"xi": xi, "theta_c": theta}
    x = xi * law.max_compression(constants, 1.0)
    assert np.expm1(x) / x == pytest.approx(2 / (3 * xi * theta), rel=1e-12)
    wider = constants | {"theta_c": 1.2 * theta}
    assert law.max_compression(constants, 1.2) == pytest.approx(law.max_compression(wider, 1.0), rel=1e-12)
    assert law.max_compression(constants | {"xi": 0.0}, 1.0) == np.inf


def test_model_takes_the_least_of_its_snows():
    """A snow that is elastic alone, or whose law makes no energy, sets no limit."""
    first, *_ = LAWS
    model = _core.f64.Model(0.1, next(iter(SPLINES)), next(iter(TRANSFERS)), 0.95, np.zeros(3))
    assert model.max_compression(1.0) == np.inf
    model.add_snow(first, "none", {})
    assert model.max_compression(1.0) == np.inf
    limits = []
    for xi in (5.0, 20.0):
        model.add_snow(first, "snow", {"xi": xi})
        limits.append(LAWS[first].max_compression({"xi": xi}, 1.5))
    assert model.max_compression(1.5) == min(limits)


def test_works_and_options_exist():
    """Each key of a paper has its work, each option of a transfer its key in [numerics]."""
    for choice in (*LAWS.values(), *TRANSFERS.values(), *SPLINES.values()):
        assert set(choice.cites) <= set(WORKS), choice.name
        assert choice.meaning.strip(". "), choice.name
        assert not choice.meaning.endswith("."), choice.name
    assert {key for law in LAWS.values() for key in law.plasticity_cites} <= set(WORKS)
    assert {key for transfer in TRANSFERS.values() for key in transfer.options} <= set(Numerics.model_fields)


def test_unknown_words_are_refused_with_what_there_is():
    """A word that is none of the list, and a constant that no law has, are errors that say so."""
    with pytest.raises(ValueError, match=f"law 'ice' is none of '{next(iter(LAWS))}'"):
        _core.f64.law("ice", "snow", {}, np.eye(3)[None], np.ones(1))
    with pytest.raises(ValueError, match="there is no constant 'E'"):
        LAWS[next(iter(LAWS))].most_strength({"E": 1.0})
    with pytest.raises(ValueError, match="spline 'linear' is none of "):
        _core.f64.weights("linear", np.ones(1))

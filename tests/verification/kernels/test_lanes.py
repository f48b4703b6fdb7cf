"""Functions of lane packs that arithmetic does not give, over their whole range."""

import numpy as np
import pytest

TOP = {"float32": 80.0, "float64": 700.0}


def domain(name, precision):
    rng = np.random.default_rng(0)
    small = 10.0 ** rng.uniform(-12, 0, 4000)
    top = TOP[precision]
    x = {
        "exp": [small, -small, rng.uniform(-top, top, 4000)],
        "expm1": [small, -small, rng.uniform(-20, top, 4000)],
        "log1p": [small, -0.9999 * small, 10.0 ** rng.uniform(0, 30, 4000)],
        "sinh": [small, rng.uniform(0, top, 4000)],
        "asinh": [small, 10.0 ** rng.uniform(0, 15, 4000)],
    }[name]
    return np.concatenate([*x, [0.0]]).astype(precision)


@pytest.mark.parametrize("name", ["exp", "expm1", "log1p", "sinh", "asinh"])
def test_functions_keep_their_digits(core, precision, eps, name):
    """Relative error below 3 eps everywhere: the polynomials stop below eps/4, a few operations round.

    exp of 80 in float32 has an argument of 80 eps/2 itself, but the function is held against the exact value
    at the rounded argument. The answer comes from NumPy in long double.
    """
    x = domain(name, precision)
    answer = {"asinh": np.arcsinh}.get(name) or getattr(np, name)
    exact = answer(x.astype(np.longdouble))
    error = np.abs(np.asarray(core.function(name, x)).astype(np.longdouble) - exact)
    assert (error <= 3 * eps * np.abs(exact)).all()


def test_not_a_number_stays_one(core, precision):
    """A lane that has lost its number does not get a new one from log1p, whose bits are taken apart."""
    x = np.array([np.nan, 0.5, np.nan], precision)
    np.testing.assert_array_equal(np.isnan(core.function("log1p", x)), [True, False, True])

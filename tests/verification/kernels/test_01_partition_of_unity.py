"""Known answer 1: what the weights of both splines sum to, at random positions of either sign."""

import numpy as np

SECOND_MOMENT = {"quadratic": 1 / 4, "cubic": 1 / 3}


def moments(core, spline, x):
    base, w, dw = core.weights(spline, x)
    node = np.asarray(base)[:, None] + np.arange(w.shape[1])
    return node - x.astype(float)[:, None], w.astype(float), dw.astype(float)


def test_partition_of_unity(core, precision, eps, spline):
    """Sum w = 1, sum w (x_i - x) = 0, sum dw = 0, sum (x_i - x) dw = 1, sum w (x_i - x)^2 = 1/4 or 1/3.

    Positions are in cells, |x| <= 8, so x itself and its fraction carry an error of eps |x| / 2 = 4 eps.
    The sums are stationary (0, 1) or change by O(1) per unit of x, over K <= 4 terms that are each rounded
    to 2 eps |x_i - x| (<= 4 eps): 4 eps + 16 eps. The constants hold whatever the fraction is, the first
    moment follows it.
    """
    x = np.random.default_rng(1).uniform(-8, 8, 4000).astype(precision)
    r, w, dw = moments(core, spline, x)
    tolerance = 20 * eps
    np.testing.assert_allclose(w.sum(1), 1, atol=tolerance, rtol=0)
    np.testing.assert_allclose((w * r).sum(1), 0, atol=tolerance, rtol=0)
    np.testing.assert_allclose(dw.sum(1), 0, atol=tolerance, rtol=0)
    np.testing.assert_allclose((dw * r).sum(1), 1, atol=tolerance, rtol=0)
    np.testing.assert_allclose((w * r * r).sum(1), SECOND_MOMENT[spline], atol=tolerance, rtol=0)


def test_support(core, precision, spline):
    """The first node is floor(x - 1/2) or floor(x) - 1; weights are never negative; none is missing.

    At |r| = 1.5 or 2 both splines vanish with their first derivative, so a position on a cell's edge has
    one answer.
    """
    x = np.concatenate([np.arange(-3, 3, 0.25), [-1e-7, 1e-7]]).astype(precision)
    base, w, _ = core.weights(spline, x)
    shift = {"quadratic": 0.5, "cubic": 1.0}[spline]
    exact = np.floor((x - np.asarray(shift, precision)).astype(precision))
    np.testing.assert_array_equal(base, exact)
    assert (w >= 0).all()
    assert w.shape == (len(x), {"quadratic": 3, "cubic": 4}[spline])

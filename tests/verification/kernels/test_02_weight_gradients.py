"""Known answer 2: the gradients of the weights against central differences of the weights."""

import numpy as np


def test_gradient_is_the_central_difference(core, precision, eps, spline):
    """dw = (w(x + h) - w(x - h)) / 2h.

    The quadratic's third derivative is zero inside a piece and the cubic's is at most 3, so truncation is
    h^2/2. Rounding: the two positions and weights carry eps |x| / 2 each, |x| <= 4, divided by 2h: 4 eps /
    h. Both are smallest together at h ~ eps^(1/3): 7e-11 (f64) and 5e-5 (f32) with a factor two to spare.
    """
    h = np.asarray(2.0 ** round(np.log2(eps) / 3), precision)
    x = np.random.default_rng(2).uniform(-4, 4, 2000).astype(precision)
    edge = {"quadratic": 0.5, "cubic": 0.0}[spline]
    apart = np.abs((x - edge) - np.round(x - edge))
    x = x[apart > 2 * h]  # the same piece, and the same base node, on both sides
    ahead, behind = x + h, x - h
    w_ahead, w_behind = (np.asarray(core.weights(spline, y)[1], float) for y in (ahead, behind))
    difference = (w_ahead - w_behind) / (ahead.astype(float) - behind.astype(float))[:, None]
    tolerance = 2 * (float(h) ** 2 / 2 + 4 * eps / float(h))
    np.testing.assert_allclose(core.weights(spline, x)[2], difference, atol=tolerance, rtol=0)

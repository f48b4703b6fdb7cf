"""Known answer 25, whole step: cam_clay in a rigid ring follows the rate equations of plasticity."""

import numpy as np
import pytest

from neve.scene.schema.material import Snow
from neve.validate.snow.cam_clay import KINDS, confined, overstress
from neve.validate.snow.oedometer import compress


@pytest.mark.parametrize("kind", KINDS)
def test_rate_equations_stay_on_the_ellipse(kind):
    """The answer is one: past yield |y| < 1e-3 p0^2 and half the steps change the stress by less than 1e-3.

    Explicit steps of 4e-6 strain drift off the ellipse by a few strains of p0 / K = 1e-3 at the most.
    """
    snow = Snow.model_validate({"kind": kind})
    s = np.array([0.95, 0.9, 0.85])
    fine, _, path = confined(snow, s)
    coarse, _, _ = confined(snow, s, 20000)
    np.testing.assert_allclose(coarse, fine, rtol=1e-3)
    p, q, p0 = path[len(path) // 2 :].T
    assert np.abs(overstress(snow, p, q, p0)).max() < 1e-3
    assert p0[-1] > 2 * snow.p0, "it hardens"


@pytest.mark.parametrize("kind", KINDS)
def test_compression(kind):
    """Axial and sideways stress within 3 % of their peak down to s = 0.88, as in known answer 13."""
    snow = Snow.model_validate({"kind": kind})
    r = compress(8, 0.86, 4.0, 12, snow={"kind": kind})
    axial, sideways, _ = confined(snow, r.s)
    assert np.abs(r.axial - axial).max() < 0.03 * np.abs(axial).max()
    assert np.abs(r.sideways - sideways).max() < 0.03 * np.abs(sideways).max()

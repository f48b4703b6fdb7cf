"""Constants of linear elasticity against their definitions."""

import pytest

from neve.scene.values.elastic import bulk_modulus, lame, p_wave_modulus


@pytest.mark.parametrize("nu", [0.0, 0.2, 0.45])
def test_moduli_agree_with_their_definitions(nu):
    """E and nu follow from mu and lam; K = lam + 2/3 mu; M_c = lam + 2 mu."""
    E = 1.4e5
    mu, lam = lame(E, nu)
    assert mu * (3 * lam + 2 * mu) / (lam + mu) == pytest.approx(E, rel=1e-14)
    assert lam / (2 * (lam + mu)) == pytest.approx(nu, abs=1e-15)
    assert bulk_modulus(E, nu) == pytest.approx(lam + 2 * mu / 3, rel=1e-14)
    assert p_wave_modulus(E, nu) == pytest.approx(lam + 2 * mu, rel=1e-14)

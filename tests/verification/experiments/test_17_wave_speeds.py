"""Known answer 17: a pulse of pressure travels at sqrt(M_c / rho), a pulse of shear at sqrt(mu / rho)."""

import numpy as np
import pytest
from reference.snow import Snow
from verification.scenes import box, march, oracle, scene, simulate

DX, DT, PATH, AMPLITUDE = 0.05, 4e-4, 0.25, 1e-2
WIDTH = 2 * DX  # of the pulse


def spread(sim, axis):
    """Second moment of the velocity along the block's axis, sum m z^2 v / sum m v [m2].

    A pulse v0(z) that starts without strain becomes v = (v0(z - c t) + v0(z + c t)) / 2, whose second
    moment is that of v0 plus c^2 t^2. Linear waves of any dispersion do the same with the speed of long
    waves, since the second moment is the curvature of the spectrum at k = 0: cos(omega t) has omega^2 = c^2
    k^2 there.
    """
    p, _ = oracle(sim)
    here = (np.abs(p.x[:, :2]) < 2 * DX).all(1)
    mv = p.m[here] * p.v[here, axis]
    return (mv * p.x[here, 2] ** 2).sum() / mv.sum()


@pytest.mark.parametrize(("wave", "speed"), [("pressure", 19.72), ("shear", 12.08)])
def test_wave_speed(wave, speed, spline, lively_transfer):
    """A plane Gaussian of velocity splits in two that part at +-c, over five cells each way.

    c_p = sqrt(M_c / rho) = 19.72 m/s and c_s = sqrt(mu / rho) = 12.08 m/s. News from the free sides comes
    at c_p and has not reached the axis yet: 0.25 m of the block's half width of 0.4 m during a pressure
    pulse, 0.41 m of 0.55 m during a shear pulse, whose motion leaves the sides across y without traction. 3
    %: particles in jittered places sample the modulus, and their mass the density, to a few percent each,
    over some hundred on the path. The strain, AMPLITUDE / c = 1e-3 at the most, is far from yield.
    """
    law = Snow()
    c = np.sqrt((law.M_c if wave == "pressure" else law.mu0) / law.rho0)
    assert c == pytest.approx(speed, abs=0.01)
    axis, size = (2, (0.8, 0.8, 1.3)) if wave == "pressure" else (0, (1.1, 0.5, 1.3))
    numerics = {"dx": DX, "dt": DT, "spline": spline, "transfer": lively_transfer, "flip_alpha": 1.0}
    sim = simulate(scene([box(size=size)], precision="float32", initial_volume="sampled", **numerics))
    z = np.asarray(sim.state.x, float)[:, 2]
    pulse = AMPLITUDE * np.exp(-(z**2) / (2 * WIDTH**2))
    sim.state.v[:, axis] = pulse.astype(np.float32)
    sim.state.C[:, axis, 2] = (-z / WIDTH**2 * pulse).astype(np.float32)
    start = spread(sim, axis)
    march(sim, round(PATH / c / DT))
    measured = np.sqrt(spread(sim, axis) - start) / sim.time
    assert measured == pytest.approx(c, rel=0.03)

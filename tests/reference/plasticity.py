"""Return maps: from a trial F_E and J_P to those that the snow can bear. J_E J_P = det F F_P stays."""

import numpy as np

from reference.polar import column, polar_svd, transpose


def clamp(F_trial, J_P, snow, elasticity):
    """Stomakhin et al. 2013: stretches into [1 - theta_c, 1 + theta_s]; what is cut off becomes plastic.

    Where that flow would make energy, snow flows within its limits at constant det F_E as far as it can.
    """
    U, sigma, V = polar_svd(F_trial)
    low, high = (
        column(np.broadcast_to(limit, len(sigma)), 1)
        for limit in (1 - snow.strength * snow.theta_c, 1 + snow.strength * snow.theta_s)
    )
    clipped = np.clip(sigma, low, high)
    tau = principal(clipped, snow, elasticity)
    work = tau / clipped * (sigma - clipped)
    pulled = ((work < 0) & (sigma > clipped)).any(-1, keepdims=True)
    J = column(sigma.prod(-1), 1)
    wide, narrow = np.maximum(sigma, clipped), np.minimum(sigma, clipped)
    inside = np.where(
        pulled,
        cut_at_volume(wide, high, np.maximum(J, np.minimum(column(wide.prod(-1), 1), 1))),
        1 / cut_at_volume(1 / narrow, 1 / low, 1 / np.minimum(J, np.maximum(column(narrow.prod(-1), 1), 1))),
    )
    dissipated = work.sum(-1, keepdims=True)
    kept = np.where(dissipated < 0, inside, clipped)
    F_E = (U * kept[:, None, :]) @ transpose(V)
    return F_E, np.minimum(J_P * (sigma / kept).prod(-1), snow.J_P_max)


def principal(s, snow, elasticity):
    """tau_k = s_k dPsi/ds_k of principal stretches s (n, 3) [Pa]."""
    tau = elasticity.stress(s[:, :, None] * np.eye(3), snow.mu0, snow.lam0)
    return np.diagonal(tau, axis1=1, axis2=2)


def cut_at_volume(s, limit, volume):
    """Cut stretches s (n, 3) to `limit` (n, 1); the smallest ones grow to one level: the product is `volume`.

    If that takes more than the limit, all end there.
    """
    cut = np.minimum(s, limit)
    given = volume[:, 0] / cut.prod(-1)
    first, second = np.sort(cut, axis=-1)[:, :2].T
    level = np.where(first * given < second, first * given, np.sqrt(first * second * given))
    return np.maximum(cut, np.minimum(column(level, 1), limit))


def nothing(F_trial, J_P, snow, elasticity):
    """Elasticity alone."""
    return F_trial.copy(), np.ones(len(F_trial)) * J_P


def tension(snow):
    """p_t of drucker_prager, at which snow comes apart [Pa]."""
    return snow.strength * snow.cohesion / np.tan(np.radians(snow.friction_angle))


def drucker_prager(F_trial, J_P, snow, elasticity):
    """q <= M_phi (p + p_t); past the apex tr eps = e_c snow comes apart, which J_P remembers.

    e = tr eps + ln J_P is the volume since rest. e >= e_c: the strain of the apex, J_P = exp(e - e_c).
    e < e_c: J_P = 1, all of e elastic, and the deviator radially onto the cone.
    """
    U, sigma, V = polar_svd(F_trial)
    eps = np.log(sigma)
    e = eps.sum(-1) + np.log(J_P)
    p_t = tension(snow)
    e_c = p_t / snow.K
    sine = np.sin(np.radians(snow.friction_angle))
    deviator = eps - eps.mean(-1, keepdims=True)
    q = np.sqrt(6) * snow.mu0 * np.linalg.norm(deviator, axis=-1)
    q_most = 6 * sine / (3 - sine) * np.maximum(-snow.K * e + p_t, 0)
    factor = np.where(q > q_most, q_most / np.where(q > 0, q, 1), 1)
    kept = column(np.minimum(e, e_c), 1) / 3 + deviator * column(factor, 1)
    F_E = (U * np.exp(kept)[:, None, :]) @ transpose(V)
    return F_E, np.minimum(np.exp(np.maximum(e - e_c, 0)), snow.J_P_max)


def cam_clay_exponents(snow):
    """The least and largest w in p0 = K sinh(w): p0 from 1e-6 K to 10 K."""
    at_rest = np.arcsinh(snow.strength * snow.p0 / snow.K)  # -xi alpha0
    bounds = (at_rest - snow.xi * np.log(J) for J in (snow.J_P_max, snow.J_P_min))
    return tuple(np.clip(w, 1e-6, np.arcsinh(10.0)) for w in bounds)


def cam_clay_size(J_P, snow):
    """p0 = K sinh(xi max(-alpha, 0)), alpha = alpha0 + ln J_P, from 1e-6 K to 10 K [Pa]."""
    w = np.arcsinh(snow.strength * snow.p0 / snow.K) - snow.xi * np.log(J_P)
    return snow.K * np.sinh(np.clip(w, *cam_clay_exponents(snow)))


def cam_clay_yield(p, q, p0, snow):
    """y = (1 + 2 beta) q^2 + M^2 (p + beta p0) (p - p0) [Pa^2]."""
    return (1 + 2 * snow.beta) * q**2 + snow.M**2 * (p + snow.beta * p0) * (p - p0)


def closest_point(p_trial, q_trial, p0, snow):
    """The point of the ellipse of p0 where associative flow ends: strains g dy/dp and g dy/dq, g >= 0.

    p = p_trial - K g dy/dp and q = q_trial - 3 mu g dy/dq are linear in p and q; g by bisection of y = 0, up
    to where both are within 1 / sqrt 2 of the half-axes. A point inside stays where it is.
    """
    M2, shape = snow.M**2, 1 + 2 * snow.beta

    def at(g):
        p = (p_trial + snow.K * g * M2 * (1 - snow.beta) * p0) / (1 + 2 * snow.K * g * M2)
        return p, q_trial / (1 + 6 * snow.mu0 * g * shape)

    a, low = 0.5 * (1 + snow.beta) * p0, np.zeros_like(p_trial)
    along = (np.sqrt(2) * np.abs(p_trial - 0.5 * (1 - snow.beta) * p0) / a - 1) / (2 * snow.K * M2)
    across = (np.sqrt(2 * shape) * q_trial / (snow.M * a) - 1) / (6 * snow.mu0 * shape)
    high = np.maximum(np.maximum(along, across), 0)
    for _ in range(60):
        g = 0.5 * (low + high)
        outside = cam_clay_yield(*at(g), p0, snow) > 0
        low, high = np.where(outside, g, low), np.where(outside, high, g)
    p, q = at(0.5 * (low + high))
    flows = cam_clay_yield(p_trial, q_trial, p0, snow) > 0
    return np.where(flows, p, p_trial), np.where(flows, q, q_trial)


def cam_clay(F_trial, J_P, snow, elasticity):
    """Associative flow to the ellipse of the p0 at the step's end, that of the J_P there: bisection."""
    U, sigma, V = polar_svd(F_trial)
    eps = np.log(sigma)
    e = eps.sum(-1)
    deviator = eps - eps.mean(-1, keepdims=True)
    p_trial = -snow.K * e
    q_trial = np.sqrt(6) * snow.mu0 * np.linalg.norm(deviator, axis=-1)
    p0 = cam_clay_size(J_P, snow)
    flows = cam_clay_yield(p_trial, q_trial, p0, snow) > 0
    least, most = cam_clay_exponents(snow)
    low = np.zeros_like(e) + least
    high = np.minimum(
        np.arcsinh(p0 / snow.K) + snow.xi * np.maximum(-e, 0), most
    )  # J_P falls by exp(e) at most
    for _ in range(50):
        w = 0.5 * (low + high)
        p, q = closest_point(p_trial, q_trial, snow.K * np.sinh(w), snow)
        grows = cam_clay_size(J_P * np.exp(e + p / snow.K), snow) > snow.K * np.sinh(w)
        low, high = np.where(grows, w, low), np.where(grows, high, w)
    p, q = closest_point(p_trial, q_trial, snow.K * np.sinh(0.5 * (low + high)), snow)
    kept = np.where(flows, -p / snow.K, e)
    factor = np.where(flows & (q_trial > 0), q / np.where(q_trial > 0, q_trial, 1), 1)
    F_E = (U * np.exp(column(kept, 1) / 3 + deviator * column(factor, 1))[:, None, :]) @ transpose(V)
    return np.where(column(flows), F_E, F_trial), np.minimum(J_P * np.exp(e - kept), snow.J_P_max)

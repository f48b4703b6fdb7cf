"""One snow per law, and per variant that has branches of its own: what tests over all laws run over."""

from dataclasses import replace

from reference.snow import ELASTICITIES, OWN_PLASTICITY, Snow

SAND = Snow(law="drucker_prager", E0=3.5e5, nu=0.3)
CLAY = Snow(law="cam_clay", E0=3e6, nu=0.3, rho0=250.0, xi=1.0)
CLAMPED = [law for law in ELASTICITIES if law not in OWN_PLASTICITY]
LAWS = {
    **{law: Snow(law=law) for law in CLAMPED},
    **{f"{law} alone": Snow(law=law, plasticity="none") for law in CLAMPED},
    "drucker_prager": SAND,
    "drucker_prager cohesive": replace(SAND, friction_angle=25.0, cohesion=2e3),
    "cam_clay": CLAY,
    "cam_clay cohesive": replace(CLAY, M=1.5, beta=0.3, p0=3e4),
}


def unyielding(law):
    """The same elasticity with yield limits that no strain of a test reaches."""
    if law.law == "drucker_prager":
        return replace(law, cohesion=10 * law.E0)
    if law.law == "cam_clay":
        return replace(law, p0=20 * law.E0, beta=1.0, M=5.0)
    return replace(law, plasticity="none")

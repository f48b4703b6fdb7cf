"""One snow per law, and per variant that has branches of its own: what tests over all laws run over."""

from dataclasses import replace

from reference.snow import Snow

SAND = Snow(law="drucker_prager", E0=3.5e5, nu=0.3)
CLAY = Snow(law="cam_clay", E0=3e6, nu=0.3, rho0=250.0, xi=1.0)
LAWS = {
    "stomakhin2013": Snow(),
    "neo_hookean": Snow(law="neo_hookean"),
    "hencky": Snow(law="hencky"),
    "stomakhin2013 alone": Snow(plasticity="none"),
    "neo_hookean alone": Snow(law="neo_hookean", plasticity="none"),
    "hencky alone": Snow(law="hencky", plasticity="none"),
    "drucker_prager": Snow(law="drucker_prager", E0=3.5e5, nu=0.3),
    "drucker_prager cohesive": Snow(
        law="drucker_prager", E0=3.5e5, nu=0.3, friction_angle=25.0, cohesion=2e3
    ),
    "cam_clay": Snow(law="cam_clay", E0=3e6, nu=0.3, rho0=250.0, xi=1.0),
    "cam_clay cohesive": Snow(law="cam_clay", E0=3e6, nu=0.3, rho0=250.0, xi=1.0, M=1.5, beta=0.3, p0=3e4),
}


def unyielding(law):
    """The same elasticity with yield limits that no strain of a test reaches."""
    if law.law == "drucker_prager":
        return replace(law, cohesion=10 * law.E0)
    if law.law == "cam_clay":
        return replace(law, p0=20 * law.E0, beta=1.0, M=5.0)
    return replace(law, plasticity="none")

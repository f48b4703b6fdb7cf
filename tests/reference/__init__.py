"""The explicit snow step of Stomakhin et al. 2013 in plain NumPy and float64: the oracle for the core.

Nothing here is fast and nothing here is shared with the core: the formulas were written down a second time,
from the paper's section 4.1 and its notation, so that a slip in either shows up as a difference.

* `splines`  weights of a particle at the nodes around it, and their gradients
* `snow`     the constants, and energy, stress and return map by law: `elasticity`, `plasticity`
* `laws`     one snow per law, for tests that run over all of them
* `contact`  signed distances of the collider shapes and the three contact laws
* `modes`    the velocity modes of PolyPIC, by Gram-Schmidt
* `step`     the ten stages, in the paper's order
"""

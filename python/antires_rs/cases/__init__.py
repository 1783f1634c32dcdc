"""Complete studies: a model, its virtual experiment, and the truth to compare with.

Both cases of V. Meruane, J. Sound Vib. 332 (2013) 807-820.

Examples
--------
>>> import antires_rs as ar
>>> case = ar.cases.chain8()
>>> case.model, round(case.truth(level=1)["severity"][4], 2)
(MassSpringChain(8 masses), 0.55)
>>> ar.cases.exhaust().model.n_dof
144
"""

from .chain8 import Chain8, chain8
from .exhaust import Exhaust, exhaust

__all__ = ["Chain8", "Exhaust", "chain8", "exhaust"]

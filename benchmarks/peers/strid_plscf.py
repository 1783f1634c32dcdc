"""strid: poly-reference LSCF of the transmissibilities, a numerator and a denominator of every order."""

from __future__ import annotations

import numpy as np

from .method import Method, transmissibilities


def plscf(record, highest, estimator, nperseg=4096, sign=1):
    """A right matrix fraction of 7 outputs and one input; poles by its own companion matrix."""
    from strid._fdid import PolyReferenceLSCF, find_companion_matrix
    freq, tables = transmissibilities(record, nperseg, estimator)
    rate_hz = 2.0 * freq[-1]
    sweeps = []
    for values in tables:
        fit = PolyReferenceLSCF(values[:, None, :], rate_hz, sgn_exp_basis=sign, constrain_N0=False)
        orders = []
        for order in range(2, highest + 1):
            d = fit.perform(order, max_order=highest, return_numerator=False)
            z = np.linalg.eigvals(find_companion_matrix(d)).astype(complex)
            orders.append(sign * np.log(z) * rate_hz)
        sweeps.append(orders)
    return sweeps


METHODS = (Method("strid pLSCF", "strid", "T_pj", "", plscf),)

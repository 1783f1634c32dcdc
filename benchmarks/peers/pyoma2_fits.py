"""pyOMA2: poly-reference LSCF fed with transmissibilities, and SSI with the reference response as input."""

from __future__ import annotations

import numpy as np

from .method import Method, transmissibilities

DECIMATION = 2


def plscf(source, highest, estimator, nperseg=1024):
    """The spectrum is a matrix of 7 outputs and one input: T_pj.

    With the other sign the poles of a transmissibility lie in the half plane that ``pLSCF_poles`` drops.
    Segments as for strid, whose pLSCF has the same normal equations.
    """
    from pyoma2.functions import plscf as functions

    freq, tables = transmissibilities(source, nperseg, estimator)
    step_s = 1.0 / (2.0 * freq[-1])
    sweeps = []
    for values in tables:
        denominators, numerators = functions.pLSCF(values[:, None, :], step_s, highest, sgn_basf=1)
        poles = functions.pLSCF_poles(denominators, numerators, step_s, methodSy="per", nxseg=nperseg)[3]
        sweeps.append(list(poles.T))
    return sweeps


def ssi_iocov(source, highest, estimator, block_rows=60):
    """Input-output covariance-driven SSI: x_j goes in, the other seven come out.

    At 256 Hz. Found less false of 252: 20 block rows clearly fewer than 40, 40 give 199, 60 give 218.
    """
    from pyoma2.functions import ssi
    from scipy.signal import decimate

    x = decimate(source.of.responses, DECIMATION, ftype="fir", axis=1)
    x = x / x.std(axis=1, keepdims=True)
    step_s = DECIMATION / source.of.fs_hz
    sweeps = []
    for j in range(len(x)):
        y = np.delete(x, j, axis=0)
        hankel, _ = ssi.build_hank(y, y, block_rows, "IOcov", U=x[j : j + 1])
        observability, a, c, _ = ssi.SSI_fast(hankel, block_rows, highest)
        poles = ssi.SSI_poles(observability, a, c, highest, step_s)[3]
        sweeps.append(list(poles.T[2:]))
    return sweeps


METHODS = (
    Method("pyOMA2 pLSCF", "pyoma-2", "T", "orders 1-60, segments of 2 s", plscf, slow=True),
    Method(
        "pyOMA2 SSI-IOcov",
        "pyoma-2",
        "responses",
        "orders 2-60, 60 block rows, records decimated to 256 Hz",
        ssi_iocov,
        needs_record=True,
    ),
)

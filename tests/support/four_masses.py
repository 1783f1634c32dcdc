"""Four masses on three springs: quick to measure, to identify and to draw."""

from functools import cache

import numpy as np

import antires_rs as ar

SPRINGS = np.array([500.0, 450.0, 520.0])
DOFS = [0, 1, 2, 3]
BAND = (0.8, 9.0)


def chain(springs=SPRINGS):
    return ar.MassSpringChain(np.ones(4), springs)


def exact(model, dofs=None):
    """Antiresonances without error, of all dofs by default, force at the first mass."""
    dofs = range(model.n_dof) if dofs is None else dofs
    return ar.AntiresonanceSet(0, dict(zip(dofs, model.antiresonances(dofs, 0), strict=True)))


@cache
def record(rng=0):
    return chain().simulate(
        excitation=0, fs_hz=25.0, duration_s=400.0, damping_ratio=0.01, noise=1e-3, rng=rng
    )


@cache
def identified(rng=0):
    return ar.identify_antiresonances(record(rng), excitation=0, band_hz=BAND, max_order=30)

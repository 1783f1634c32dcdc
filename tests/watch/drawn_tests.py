"""Series of sets drawn from the antiresonances of a chain, for the tests of the watch."""

import numpy as np

import antires_rs as ar

MASSES = np.array([0.9, 1.1, 1.0, 0.8, 1.2, 1.0])
SPRINGS = np.array([5.2e4, 4.8e4, 5.5e4, 4.5e4, 5.0e4])
STD = 5e-4  #: Relative standard deviation of every value.


def chain(loss=0.0, spring=2, factor=1.0):
    """The structure; ``factor`` multiplies all springs."""
    springs = SPRINGS * factor
    springs[spring] *= 1.0 - loss
    return ar.MassSpringChain(MASSES, springs)


def exact(model):
    """Antiresonances by dof."""
    return dict(enumerate(model.antiresonances(list(range(model.n_dof)), 0)))


def drawn(values, rng, *, tails=np.inf, missed=0.0, std=STD, without=()):
    """A set of one test: values with errors of Student's t, some of them missed."""
    found, stds = {}, {}
    for dof, exact_hz in values.items():
        size = exact_hz.size
        error = rng.standard_normal(size) if np.isinf(tails) else rng.standard_t(tails, size)
        keep = rng.random(size) >= missed
        if dof not in without:
            found[dof] = (exact_hz * np.exp(std * error))[keep]
            stds[dof] = (std * exact_hz)[keep]
    return ar.AntiresonanceSet(0, found, std_hz=stds)


def many(values, count, rng, **options):
    """So many tests of one state."""
    return [drawn(values, rng, **options) for _ in range(count)]

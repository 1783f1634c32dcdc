"""Truths drawn from a prior, their antiresonances with errors as stated, and where the posterior has them.

Simulation-based calibration (Talts et al., arXiv:1804.06788): the rank of the truth among the draws of the
posterior is as likely to be one as another.
"""

import numpy as np

import antires_rs as ar

#: A search that is quick; the intervals refine what it finds.
QUICK = ar.IslandGA(islands=2, population=10)
#: Stated errors of the antiresonances, relative, drawn log-uniformly for each value.
ERRORS = (2e-4, 1e-3)


def chain8():
    """The paper's chain, every mass and spring within 10 %: mass 0 and a common scale are not seen."""
    case = ar.cases.chain8()
    parameters = ar.mass_factor(range(8), bounds=(0.9, 1.1)) + ar.stiffness_factor(
        range(7), bounds=(0.9, 1.1)
    )
    return case.model, parameters, (0,)


def grounded():
    """Five masses between two walls, masses known, springs within 30 %, force at mass 2."""
    model = ar.MassSpringChain(
        [1.0, 1.5, 0.8, 1.2, 1.0], [4e4, 3e4, 5e4, 4e4], ground_first_n_per_m=3e4, ground_last_n_per_m=2e4
    )
    return model, ar.stiffness_factor(range(4), bounds=(0.7, 1.3)), (2,)


def two_forces():
    """Six masses, some springs and some masses within 20 %, forces at masses 0 and 4."""
    model = ar.MassSpringChain([2.0, 1.0, 1.0, 3.0, 1.0, 0.5], [2e4, 6e4, 3e4, 3e4, 8e4])
    parameters = ar.stiffness_factor([0, 1, 3, 4], bounds=(0.8, 1.2)) + ar.mass_factor(
        [1, 3, 5], bounds=(0.8, 1.2)
    )
    return model, parameters, (0, 4)


STRUCTURES = {"chain8": chain8, "grounded": grounded, "two forces": two_forces}


def measured(model, forces, rng):
    """Antiresonances with errors as they are stated."""
    sets = []
    for force in forces:
        exact = model.antiresonances(range(model.n_dof), force)
        spread = [np.exp(rng.uniform(*np.log(ERRORS), f.size)) * f for f in exact]
        noisy = {
            i: f + s * rng.standard_normal(f.size) for i, (f, s) in enumerate(zip(exact, spread, strict=True))
        }
        sets.append(ar.AntiresonanceSet(force, noisy, std_hz=dict(enumerate(spread))))
    return sets


def ranks(seed, name, method, draws):
    """Share of the posterior below the truth, and whether the 90 % interval holds it, for every parameter."""
    model, parameters, forces = STRUCTURES[name]()
    rng = np.random.default_rng([seed, sorted(STRUCTURES).index(name)])
    low, high = np.array([p.bounds for p in parameters]).T
    truth = rng.uniform(low, high)
    problem = ar.UpdatingProblem(
        model, parameters, measured(model.with_parameters(parameters, truth), forces, rng)
    )
    found = ar.update(problem, optimizer=QUICK, rng=seed, workers=1, progress=False)
    told = found.intervals(method, draws=draws, rng=seed, workers=1, progress=False)
    below = (told.draws < truth).sum(axis=0)
    share = (below + rng.random(below.size)) / (draws + 1.0)  # ties among draws + 1 places
    bounded = np.array([words != "flat" for words in told.words])
    return share, (told.low <= truth) & (truth <= told.high), bounded, told.model_error > 0.0

"""Chains whose model is wrong by some per cent, for damage against a baseline."""

from __future__ import annotations

import numpy as np

import antires_rs as ar

STD = 3e-4
N = 6


def chain(factors, losses=None):
    """Grounded chain whose masses and springs are off by factors (2 N,), damaged by losses (N - 1,)."""
    losses = np.zeros(N - 1) if losses is None else np.asarray(losses)
    masses = np.array([0.8, 0.5, 0.6, 0.5, 0.7, 0.5]) * factors[:N]
    springs = np.array([4e4, 6e4, 5e4, 3e4, 5e4]) * factors[N : 2 * N - 1] * (1.0 - losses)
    return ar.MassSpringChain(masses, springs, ground_first_n_per_m=3e4 * factors[-1])


NOMINAL = chain(np.ones(2 * N))


def measured(model, rng, std=STD, forces=(0, 3)):
    """Values of two positions of the force with Gaussian errors."""
    sets = []
    for force in forces:
        exact = model.antiresonances(range(N), force)
        freq = {dof: f * (1.0 + std * rng.standard_normal(f.size)) for dof, f in enumerate(exact)}
        sets.append(ar.AntiresonanceSet(force, freq, std_hz={dof: std * f for dof, f in freq.items()}))
    return sets


def truth(seed, off=0.06):
    """Generator, and factors on all masses and springs."""
    rng = np.random.default_rng(seed)
    return rng, 1.0 + off * rng.uniform(-1.0, 1.0, 2 * N)


def assessed(seed, losses, kind=measured, **options):
    """A chain of its own errors, with losses (N - 1,), against its intact state."""
    rng, factors = truth(seed)
    before = kind(chain(factors), rng)
    return ar.assess_damage(NOMINAL, kind(chain(factors, losses), rng), baseline=before, **options)


def states(seed, losses=(0, 0, 0.3, 0, 0)):
    """Intact state and a test of a chain with errors of its own."""
    rng, factors = truth(seed)
    return measured(chain(factors), rng), measured(chain(factors, losses), rng)


def changed(sets, by=1.0, dofs=None, std=1.0):
    """The sets with all values times ``by``, at some of the dofs, and standard deviations times ``std``."""
    made = []
    for each in sets:
        some = each if dofs is None else dofs
        freq, stds = {d: by * each[d] for d in some}, {d: std * each.std_hz[d] for d in some}
        made.append(ar.AntiresonanceSet(each.excitation, freq, std_hz=stds))
    return made

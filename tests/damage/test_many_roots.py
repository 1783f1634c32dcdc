"""Hundreds of antiresonances, many of them close: what a baseline teaches, where a search ends."""

from __future__ import annotations

import numpy as np

import antires_rs as ar
from antires_rs.damage.evidence import refitted
from antires_rs.damage.inference import Search
from antires_rs.damage.likelihood import View
from antires_rs.damage.options import DamagePrior
from antires_rs.damage.likelihood import Question
from reference.grouped_meshes import grouped, measured, of_groups, with_groups
from reference.meshes import MESHES, frame

#: Scatter of the groups' stiffness and mass, as it is put in.
OFF_STIFFNESS, OFF_MASS = 0.02, 0.01


def test_a_wide_first_association_does_not_decide():
    # Values joined to neighbours of their roots were explained by factors that scatter by 60 %.
    n_groups, rng = 60, np.random.default_rng([2, 500])
    mesh = MESHES["tower"](500)
    model = frame(mesh)
    free = [n for n in range(len(mesh.nodes_m)) if n not in set(mesh.held)]
    nodes = rng.choice(free, 12, replace=False)
    sensors = [model.dof(int(node), "uvw"[i % 3]) for i, node in enumerate(nodes)]
    force, limit_hz = sensors[2], float(model.modes(n_modes=30).freq_hz[-1])
    groups = grouped(mesh, n_groups)
    unknown = [
        *of_groups(ar.stiffness_factor, groups, (0.1, 2.0)),
        *of_groups(ar.mass_factor, groups, (0.1, 2.0)),
    ]
    scatter = np.repeat([OFF_STIFFNESS, OFF_MASS], n_groups)
    structure = model.with_parameters(unknown, 1.0 + scatter * rng.standard_normal(2 * n_groups))
    rng.integers(n_groups)
    before = measured(structure, sensors, force, limit_hz, rng)
    grouped_model = with_groups(mesh, model, groups)
    question = Question(grouped_model, (before,), (before,), tuple(range(n_groups)), DamagePrior())
    error = question.prepared(1).error
    assert np.count_nonzero(error.partner < 0) <= 0.02 * error.partner.size
    assert 0.5 * OFF_STIFFNESS < error.s < 2.0 * OFF_STIFFNESS


def seen_from(beta, log_likelihood, gain):
    """A view of 40 values that all have a root."""
    none = np.zeros(40)
    return View(
        beta=beta,
        log_likelihood=log_likelihood,
        gain=gain,
        curvature=1e4 * np.eye(beta.size),
        kappa=0.0,
        times=1.0,
        partner=np.arange(40),
        beside=none,
        residual=none,
        std=none + 1.0,
        chi_square=40.0,
    )


def test_a_single_damage_that_leads_nowhere_does_not_keep_the_search_going():
    class Walks:
        """Element 0 explains all; element 1 little, and every view of it points far away."""

        n = 2
        start = seen_from(np.zeros(2), 0.0, np.array([4000.0, 4000.0]))

        def __init__(self, of_other):
            self.of_other = of_other

        def views(self, betas, extra=0.0):
            right = seen_from(betas[0], 500.0, 1e4 * (np.array([0.4, 0.0]) - betas[0]) * [1.0, 0.0])
            away = 1.0 if betas[1, 1] < 0.5 else -1.0
            other = seen_from(betas[1], self.of_other, np.array([0.0, 6000.0 * away]))
            return [right, other][: len(betas)]

    chosen = {(0,): np.array([0.4, 0.0]), (1,): np.array([0.0, 0.3])}
    for of_other, given_up in ((100.0, True), (490.0, False)):
        likelihood = Walks(of_other)
        search = Search(likelihood, 2)
        search.fits[()] = refitted(likelihood.start, ())
        search._refine(chosen)
        assert (0,) in search.fits
        assert (1,) not in search.fits  # it never came to rest
        assert ((1,) in search.hopeless) is given_up

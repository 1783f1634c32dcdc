"""Damage by modes against a baseline, the model wrong by some per cent (Eq. 18's values, changes of them)."""

from __future__ import annotations

import numpy as np
import pytest

import antires_rs as ar
from reference.wrong_chains import NOMINAL, N, chain, truth
from tests.support.refusals import refused

STD_HZ, STD_SHAPES = 3e-4, 3e-3


def measured(model, rng, dofs=None, n_modes=6, std=(STD_HZ, STD_SHAPES), stated=True):
    dofs = list(range(model.n_dof) if dofs is None else dofs)
    modes = model.modes()
    flexible = np.flatnonzero(modes.freq_hz > 1e-3 * modes.freq_hz.max())[:n_modes]
    freq = modes.freq_hz[flexible] * (1.0 + std[0] * rng.standard_normal(flexible.size))
    shapes = modes.shapes[np.ix_(flexible, dofs)]
    shapes = shapes / np.linalg.norm(shapes, axis=1)[:, None] + std[1] * rng.standard_normal(shapes.shape)
    shapes = shapes * rng.uniform(0.5, 2.0, (freq.size, 1)) * rng.choice([-1.0, 1.0], (freq.size, 1))
    order = np.argsort(freq)
    told = {"std_hz": std[0] * freq[order], "std_shapes": np.full(freq.size, std[1])} if stated else {}
    return ar.ModalSet(freq[order], shapes[order], dofs, **told)


def test_frequencies_alone_take_mirrored_springs_for_one_another_and_shapes_do_not():
    model = ar.MassSpringChain(np.ones(5), np.full(4, 1e4))  # free at both ends, and its own mirror image
    factors = 1.0 + 0.03 * np.random.default_rng(0).uniform(-1.0, 1.0, 9)
    intact = ar.MassSpringChain(factors[:5], 1e4 * factors[5:])
    damaged = intact.with_parameters(ar.stiffness_reduction([0]), [0.2])
    rng = np.random.default_rng(1)
    told = ar.assess_damage(model, measured(damaged, rng), baseline=measured(intact, rng))
    assert told.damaged == [0]
    assert told.probability[0] > 0.99
    rng = np.random.default_rng(1)
    now, before = (measured(each, rng, dofs=[0]) for each in (damaged, intact))
    blind = ar.assess_damage(model, now, baseline=before)
    both = {one.elements: one.probability for one in blind.hypotheses}
    assert both[(0,)] > 0.02
    assert both[(3,)] > 0.02
    assert "cannot tell" in blind.headline or "may be" in blind.headline


def test_modes_that_pass_each_other_are_followed():
    model = ar.MassSpringChain([1.0, 50.0, 1.0], [1.10e4, 1.0e4])
    hurt, rng = model.with_parameters(ar.stiffness_reduction([0]), [0.2]), np.random.default_rng(0)
    result = ar.assess_damage(model, measured(hurt, rng), baseline=measured(model, rng))
    assert result.damaged == [0]
    assert result.severity[0] == pytest.approx(0.2, abs=0.01)


def test_lost_modes_no_stated_errors_several_setups_and_no_baseline():
    rng, factors = truth(40)
    now = measured(chain(factors, [0, 0, 0, 0.35, 0]), rng, n_modes=5, stated=False)
    before = measured(chain(factors), rng, stated=False)
    result = ar.assess_damage(NOMINAL, now, baseline=[before, measured(chain(factors), rng, stated=False)])
    assert result.damaged == [3]
    assert abs(result.severity[3] - 0.35) < 0.04
    assert any("shape's length" in note for note in result.notes)
    assert result.assessment.n_baselines == 2
    rng, factors = truth(50)
    setups = [0, 1, 2, 3], [5, 4, 3]
    now = [measured(chain(factors, [0, 0.3, 0, 0, 0]), rng, dofs) for dofs in setups]
    before = [measured(chain(factors), rng, dofs) for dofs in setups]
    result = ar.assess_damage(NOMINAL, now, baseline=before)
    assert result.damaged == [1]
    assert abs(result.severity[1] - 0.3) < 0.03
    rng = np.random.default_rng(62)
    result = ar.assess_damage(NOMINAL, measured(chain(np.ones(2 * N), [0, 0.4, 0, 0, 0]), rng), rng=0)
    assert result.probability[1] > 0.9


def test_kinds_and_sensors_that_do_not_fit_are_refused():
    rng, factors = truth(70)
    modes = measured(chain(factors), rng)
    zeros = ar.AntiresonanceSet(0, dict(enumerate(NOMINAL.antiresonances(range(N), 0))))
    refused("baseline", ar.assess_damage, NOMINAL, modes, baseline=zeros)
    with pytest.raises(ar.InvalidInputError, match="same sensors"):
        ar.assess_damage(NOMINAL, modes, baseline=measured(chain(factors), rng, dofs=[0, 1]))
    refused("std_shapes", ar.ModalSet, [1.0], [[1.0, 2.0]], std_shapes=[-0.1])

"""Two to five values: modest answers, and no damage of two elements taken for something else."""

import numpy as np
import pytest

import antires_rs as ar

MASSES, SPRINGS = np.full(7, 0.45), np.full(6, 56.7e3)


def assessed(seed, losses, count, off=0.04, std=3e-4):
    """The first ``count`` values at three masses of a chain that is ``off`` its model."""
    rng = np.random.default_rng(seed)
    mass, spring = (1.0 + off * rng.uniform(-1.0, 1.0, n) for n in (7, 6))
    hurt = 1.0 - np.array([losses.get(e, 0.0) for e in range(6)])

    def tested(stiffness):
        model, left, freq = ar.MassSpringChain(MASSES * mass, stiffness, ground_first_n_per_m=3e4), count, {}
        for dof in (0, 3, 5):
            own = model.antiresonances([dof], 0)[0][:left]
            left -= own.size
            freq[dof] = own * (1.0 + std * rng.standard_normal(own.size))
        return ar.AntiresonanceSet(0, freq, std_hz={dof: std * f for dof, f in freq.items()})

    nominal = ar.MassSpringChain(MASSES, SPRINGS, ground_first_n_per_m=3e4)
    return ar.assess_damage(nominal, tested(SPRINGS * spring * hurt), baseline=tested(SPRINGS * spring))


@pytest.mark.parametrize("seed", range(300, 304))
def test_two_damages_are_found_from_five_values(seed):
    # As it was, one element or "something else" counted as explanation enough, and pairs were not looked at.
    losses = {seed % 6: 0.3, (seed + 1) % 6: 0.2}
    result = assessed(seed, losses, 5)
    assert sorted(result.damaged) == sorted(losses)
    for element, loss in losses.items():
        assert abs(result.severity[element] - loss) < 0.03


@pytest.mark.parametrize("count", [2, 3, 5])
def test_one_damage_is_found_and_an_intact_structure_is_not_accused(count):
    for seed in range(310, 313):
        intact, hurt = (assessed(seed, losses, count) for losses in ({}, {seed % 6: 0.3}))
        assert intact.damaged == []
        assert hurt.damaged == [seed % 6]


def test_one_value_says_where_nothing():
    result = assessed(320, {2: 0.3}, 1)
    assert max(result.probability.values()) < 0.9
    assert any(note.startswith("Only ") for note in result.notes)


def test_without_a_partner_for_any_value_there_is_no_chi_square(tmp_path):
    model = ar.MassSpringChain(MASSES, SPRINGS, ground_first_n_per_m=3e4)
    root = model.antiresonances([3], 0)[0][0]
    before, now = (ar.AntiresonanceSet(0, {3: [f]}, std_hz={3: [3e-4 * f]}) for f in (root, 1.35 * root))
    result = ar.assess_damage(model, now, baseline=before)
    assert result.assessment.n_matched == 0
    assert np.isnan(result.chi_square)
    assert not any("chi-square nan" in note for note in result.notes)
    assert any(note.startswith("No value of now has a partner") for note in result.notes)
    result.save(tmp_path / "r.npz")
    assert ar.DamageResult.load(tmp_path / "r.npz").assessment == result.assessment

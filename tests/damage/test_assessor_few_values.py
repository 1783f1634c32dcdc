"""Where a first look misleads, the answer is that of the full run all the same."""

import numpy as np
import pytest

import antires_rs as ar

MASSES = [1.0] * 6
SPRINGS = 100.0 * np.array([510.0, 495.0, 500.0, 520.0, 480.0])
NOMINAL = ar.MassSpringChain(MASSES, [5e4] * 5)


def measured_of(model, dofs, rng, noise=1e-3):
    exact = dict(zip(dofs, model.antiresonances(dofs, 0), strict=True))
    std = {dof: noise * f for dof, f in exact.items()}
    now = {dof: np.sort(f + std[dof] * rng.standard_normal(f.size)) for dof, f in exact.items()}
    return ar.AntiresonanceSet(0, now, std_hz=std)


def most_probable(found):
    best = found.hypotheses[0]
    return best.elements, best.probability


@pytest.mark.parametrize("left", [480.0, 440.0, 400.0, 300.0, 200.0])
def test_one_value_that_no_undamaged_root_is_near(left):
    """The element is judged at no damage first, where nothing belongs to the value and no slope leads on."""
    rng = np.random.default_rng(1)
    before = measured_of(ar.MassSpringChain([1.0, 1.0], [520.0]), [0, 1], rng)
    now = measured_of(ar.MassSpringChain([1.0, 1.0], [left]), [0, 1], rng)
    model = ar.MassSpringChain([1.0, 1.0], [500.0])
    quick = ar.Assessor(model, baseline=before, workers=1).assess(now)
    elements, probability = most_probable(ar.assess_damage(model, now, baseline=before, workers=1))
    assert elements == (0,)
    assert most_probable(quick) == (elements, pytest.approx(probability, abs=0.05))
    assert quick.severity[0] == pytest.approx(1.0 - left / 520.0, abs=0.01)


@pytest.mark.parametrize("seed", [31, 61, 90])
def test_a_small_damage_that_errors_of_three_times_their_size_explain_too(seed):
    """No damage is most probable with such errors, and seen with these no element is worth a look."""
    dofs = [0, 1, 3, 4, 5]
    before = measured_of(ar.MassSpringChain(MASSES, SPRINGS), dofs, np.random.default_rng(1))
    now = measured_of(
        ar.MassSpringChain(MASSES, SPRINGS * [1, 1, 1, 0.98, 1]), dofs, np.random.default_rng(seed)
    )
    quick = ar.Assessor(NOMINAL, baseline=before, workers=1).assess(now)
    full = ar.assess_damage(NOMINAL, now, baseline=before, workers=1)
    assert most_probable(full)[0] == (3,)
    assert most_probable(quick) == ((3,), pytest.approx(most_probable(full)[1], abs=0.03))

"""The chain from record to damage and to updated model, end to end (rows 4, 6 and 7, in small).

The full study with all its seeds is ``benchmarks/chain8_study.py``.
"""

import numpy as np
import pytest

import antires_rs as ar
from tests.support.campaign import some_of
from tests.support.tolerances import IDENTIFIED_PERCENT, NOISY_SEVERITY, UPDATED_PERCENT

DAMAGED, SEVERITY = 4, 0.55


def identify(case, record):
    return ar.identify_antiresonances(record, excitation=case.excitation, band_hz=case.band_hz)


@pytest.mark.parametrize("seed", some_of([0, 1]))
def test_damage_is_located_and_sized_from_a_noisy_record(seed):
    case = ar.cases.chain8()
    zeros = identify(case, case.experiment(level=1, noise=0.01, rng=seed))
    result = ar.assess_damage(case.model, zeros, rng=seed)
    assert result.success
    assert result.damaged == [DAMAGED]
    assert result.severity[DAMAGED] == pytest.approx(SEVERITY, abs=NOISY_SEVERITY)
    assert [beta for element, beta in result.severity.items() if element != DAMAGED] == [0.0] * 6


def test_an_undamaged_structure_comes_out_undamaged():
    case = ar.cases.chain8()
    zeros = identify(case, case.experiment(noise=0.01, rng=2))
    result = ar.assess_damage(case.model, zeros, rng=2)
    np.testing.assert_array_equal(result.x, np.zeros(7))


def test_updating_from_a_record_brings_28_antiresonances_into_place():
    case = ar.cases.chain8(perturbation=0.08, rng=0)
    zeros = identify(case, case.experiment(rng=0))
    for dof, true_hz in case.truth()["freq_hz"].items():
        assert zeros[dof].size == true_hz.size
        np.testing.assert_allclose(zeros[dof], true_hz, rtol=IDENTIFIED_PERCENT / 100)
    result = ar.update(case.updating_problem(zeros), rng=0, optimizer=ar.IslandGA(max_evaluations=40_000))
    assert result.table.measured_hz.size == 28
    assert result.table.largest_before_percent > 2.0
    assert result.table.largest_after_percent <= UPDATED_PERCENT


def test_damage_where_no_candidate_is_comes_with_a_doubt():
    """A shear frame that has lost 30 % of its lowest storey, the spring to ground."""

    def frame(lowest):
        return ar.MassSpringChain(
            [5.2] * 5 + [4.4], [52.5e3, 52.5e3, 50e3, 50e3, 48e3], ground_first_n_per_m=lowest
        )

    zeros = ar.AntiresonanceSet(5, dict(enumerate(frame(0.7 * 55e3).antiresonances(range(6), 5))))
    blamed = ar.assess_damage(frame(55e3), zeros, rng=0)
    assert any(note.startswith("No candidates: first ground spring.") for note in blamed.notes)
    assert any(note.startswith("Hardly explained: the largest difference is ") for note in blamed.notes)
    found = ar.assess_damage(frame(55e3), zeros, elements=range(6), rng=0)
    assert found.damaged == [5]
    assert not any(note.startswith(("No candidates", "Hardly explained")) for note in found.notes)

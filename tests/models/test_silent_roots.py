"""Structures whose antiresonances rounding hides: exact arithmetic says what is missed in silence."""

from dataclasses import replace

import pytest

pytest.importorskip("flint", reason="python-flint is not installed: no exact roots to compare with")
pytest.importorskip("mpmath", reason="mpmath is not installed: no numbers of 50 digits")

from reference.silent_roots import KINDS, judged, silent_model
from tests.support.campaign import some_of


@pytest.mark.parametrize("cancelled", [False, True])
@pytest.mark.parametrize("seeds", some_of([range(30, 42), range(100, 225)]))
@pytest.mark.parametrize("kind", KINDS)
def test_nothing_is_missed_or_invented_in_silence(kind, seeds, cancelled):
    for seed in seeds:
        wrong, told = judged(silent_model(kind, seed), include_cancelled=cancelled)
        assert told or not wrong, f"{seed}: {wrong}"


@pytest.mark.parametrize("size", [1e-12, 1e12])
def test_the_unit_of_stiffness_changes_no_root_of_massless_dofs(size):
    for seed in range(8):
        case = silent_model("massless and free", seed)
        wrong, told = judged(replace(case, stiffness=case.stiffness * size))
        assert told or not wrong, f"{seed}: {wrong}"

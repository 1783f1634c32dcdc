"""Structures whose antiresonances rounding hides: exact arithmetic says what is missed in silence."""

from dataclasses import replace

import pytest

pytest.importorskip("flint", reason="python-flint is not installed: no exact roots to compare with")
pytest.importorskip("mpmath", reason="mpmath is not installed: no numbers of 50 digits")

import mpmath
import numpy as np

import antires_rs as ar
from reference.exact_pencils import ExactRoots
from reference.silent_roots import KINDS, judged, rounded, silent_model, springs
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


@pytest.mark.filterwarnings("ignore::antires_rs.AntiresWarning")
@pytest.mark.parametrize("seed", [50, 54, 245, 247, 298])
def test_a_tie_that_takes_all_digits_of_the_others_leaves_nothing_certain(seed):
    """First order gave bounds of 1e-7 around values that were off by half of themselves."""
    rng = np.random.default_rng([18, seed])
    n = int(rng.integers(3, 8))
    k_mat, mass = springs(rng, n), np.diag(rounded(rng.uniform(0.3, 3, n)))
    k_mat[0, 0] += rounded(rng.uniform(1e3, 1e6))
    a, b = rng.permutation(n)[:2]
    tie = np.median(np.diag(k_mat)) * 1e18 * 10 ** rng.uniform(-2, 1)
    assert rng.random() >= 0.5
    k_mat[[a, b], [a, b]] += tie
    k_mat[[a, b], [b, a]] -= tie
    response, force = map(int, rng.integers(n, size=2))
    roots = ExactRoots(k_mat, mass, response, force).roots
    wanted = np.array([float(mpmath.sqrt(root.x) / (2 * mpmath.pi)) for root in roots])
    found, bounds = ar.MatrixModel(k_mat, mass).antiresonances(response, force, bounds=True)
    for hz, bound in zip(found, bounds, strict=True):
        assert np.abs(wanted - hz).min(initial=np.inf) <= bound

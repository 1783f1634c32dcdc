"""Pencils that are hard on eigensolvers against exact roots: each within its stated bound of the exact one (a
share of ``benchmarks/torture.py``, which has 1,000), and by the plain call all of them and none beside."""

import numpy as np
import pytest

import antires_rs as ar

pytest.importorskip("flint", reason="python-flint is not installed: no exact roots to compare with")
pytest.importorskip("mpmath", reason="mpmath is not installed: no numbers of 50 digits")

import mpmath

from reference.exact_pencils import PRECISION, ExactRoots
from reference.torture import KINDS, OF_EACH, torture
from reference.torture_verdict import verdict
from tests.models.shared import quietly
from tests.support.campaign import some_of

SLOWEST = 5.0  #: Most seconds for one pencil.
#: Kinds in which rounding of the entries moves roots by per cents, so that many cannot be certain.
HOPELESS = {"penalties"}
MOST_UNCERTAIN = 0.02  #: Most roots of the others that may be told to be uncertain.
#: Of roots without bounds. The rules were set on the first forty of each kind, and are judged on others.
RTOL = 1e-6


@pytest.mark.parametrize("seeds", some_of([6, OF_EACH]))
@pytest.mark.parametrize("kind", KINDS)
def test_each_root_is_within_its_bound(kind, seeds):
    judged = [verdict(torture(kind, seed)) for seed in range(seeds)]
    assert not [(seed, v.wrong) for seed, v in enumerate(judged) if v.wrong]
    assert max(v.seconds for v in judged) < SLOWEST
    uncertain, certain = (sum(getattr(v, name) for v in judged) for name in ("uncertain", "certain"))
    if kind not in HOPELESS:
        assert uncertain <= MOST_UNCERTAIN * certain + 1


def both_hz(case):
    ends = case.response, case.excitation
    model = quietly(ar.MatrixModel, case.stiffness, case.mass)
    exact = ExactRoots(case.stiffness, case.mass, *ends)
    mpmath.mp.prec = PRECISION
    real = [] if exact.is_zero else [root for root in exact.roots if root.imaginary == 0]
    hz = [float(mpmath.sqrt(root.x) / (2 * mpmath.pi)) for root in real for _ in range(root.multiplicity)]
    return quietly(model.antiresonances, *ends, include_cancelled=True), np.array(hz)


@pytest.mark.parametrize("seeds", some_of([range(40, 46), range(100)]))
@pytest.mark.parametrize("kind", ["graded_stiffness", "graded_units", "graded_mass", "diagonal", "penalties"])
def test_all_roots_without_bounds(kind, seeds):
    for seed in seeds:
        found, wanted = both_hz(torture(kind, seed))
        np.testing.assert_allclose(found, wanted, rtol=RTOL, err_msg=str(seed))


def line(n):
    return 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)


@pytest.mark.parametrize("size", [1e-12, 1e12])
def test_units_of_the_dofs_change_neither_roots_nor_modes(size):
    n = 9
    k_mat, m_mat = 1e4 * line(n), np.diag(np.random.default_rng(3).uniform(0.5, 2.0, n))
    d = np.exp2(np.round(np.log2(np.geomspace(1.0, size, n))))
    plain = ar.MatrixModel(k_mat, m_mat)
    graded = quietly(ar.MatrixModel, k_mat * np.outer(d, d), m_mat * np.outer(d, d))
    modes, scaled = plain.modes(), graded.modes()
    np.testing.assert_allclose(scaled.freq_hz, modes.freq_hz, rtol=1e-12)
    np.testing.assert_allclose(np.abs(scaled.shapes * d), np.abs(modes.shapes), rtol=1e-9, atol=1e-12)
    for i, k in [(0, 0), (2, 7)]:
        for method in ("modal", "pencil"):
            found = graded.antiresonances(i, k, method=method)
            np.testing.assert_allclose(found, plain.antiresonances(i, k), rtol=1e-11)
    freq = np.linspace(1.0, 40.0, 7)
    ratio = graded.frf(2, 7, freq, damping_ratio=0.01) / plain.frf(2, 7, freq, damping_ratio=0.01)
    np.testing.assert_allclose(ratio * d[2] * d[7], 1.0, rtol=1e-8)


def test_bounds_of_several_responses_and_roots_that_are_not_certain():
    chain = ar.MassSpringChain([1.0, 1.0, 2.0], [500.0, 500.0])
    found = chain.antiresonances([0, 1, 2], 0, bounds=True)
    assert [freq.size for freq, _ in found] == [2, 1, 0]
    for (freq, error), plain in zip(found, chain.antiresonances([0, 1, 2], 0), strict=True):
        np.testing.assert_allclose(freq, plain, rtol=1e-13)
        assert np.all((error > 0) & (error < 1e-11 * freq))
    # A tie of 1e20 N/m has taken the digits of the springs beside it already in the sums of the assembly.
    k_mat = 1e4 * line(8)
    k_mat[1:3, 1:3] += 1e20 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    with pytest.warns(ar.AntiresWarning, match="up to"):
        model = ar.MatrixModel(k_mat, np.eye(8))
    with pytest.warns(ar.AntiresWarning, match="not certain|missing or double"):
        model.antiresonances(0, 0, bounds=True)

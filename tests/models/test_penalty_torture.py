"""Stiff and graded matrices by the plain call: all roots of the matrices as given, none beside them."""

import warnings

import numpy as np
import pytest

import antires_rs as ar

pytest.importorskip("flint", reason="python-flint is not installed: no exact roots to compare with")
pytest.importorskip("mpmath", reason="mpmath is not installed: no numbers of 50 digits")

import mpmath

from reference.exact_pencils import PRECISION, ExactRoots
from reference.torture import torture
from tests.support.campaign import some_of

#: The rules were set on the first forty of each kind, and are judged on others.
SEEDS = some_of([range(40, 50), range(100)])
RTOL = 1e-6


def exact_hz(k, m, response, excitation):
    exact = ExactRoots(k, m, response, excitation)
    mpmath.mp.prec = PRECISION
    real = [root for root in exact.roots if root.imaginary == 0]
    hz = [float(mpmath.sqrt(root.x) / (2 * mpmath.pi)) for root in real for _ in range(root.multiplicity)]
    return exact.is_zero, np.array(hz)


def model_of(case):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ar.AntiresWarning)  # springs so stiff that the assembly rounds others
        return ar.MatrixModel(case.stiffness, case.mass)


@pytest.mark.parametrize("seeds", SEEDS)
@pytest.mark.parametrize("kind", ["graded_stiffness", "graded_units", "graded_mass", "diagonal", "penalties"])
def test_all_roots_without_bounds(kind, seeds):
    wrong = {}
    for seed in seeds:
        case = torture(kind, seed)
        is_zero, wanted = exact_hz(case.stiffness, case.mass, case.response, case.excitation)
        if is_zero:
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ar.AntiresWarning)
            found = model_of(case).antiresonances(case.response, case.excitation, include_cancelled=True)
        if found.size != wanted.size or np.any(np.abs(found - wanted) > RTOL * wanted):
            wrong[seed] = found, wanted
    assert not wrong


def test_a_graded_structure_keeps_its_root():
    case = torture("graded_stiffness", 21)
    found = model_of(case).antiresonances(case.response, case.excitation, include_cancelled=True)
    _, wanted = exact_hz(case.stiffness, case.mass, case.response, case.excitation)
    assert np.min(np.abs(wanted - 104.06)) < 0.01
    np.testing.assert_allclose([np.min(np.abs(found / hz - 1.0)) for hz in wanted], 0.0, atol=RTOL)

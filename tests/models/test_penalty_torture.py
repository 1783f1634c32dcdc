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


@pytest.mark.parametrize("kind", ["graded_stiffness", "graded_units", "diagonal"])
def test_what_is_only_stiff_stays_in_the_matrices(kind):
    assert not [seed for seed in range(40) if "taken out" in repr(model_of(torture(kind, seed)))]


@pytest.mark.parametrize("power", [12, 15, 19])
@pytest.mark.parametrize("force", [0, 1, 2])
def test_both_ends_of_a_tie_and_the_motion_over_it(power, force):
    """Five masses, two on a tie: it has roots of its own, the highest."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ar.AntiresWarning)  # the assembly rounds the springs beside it
        springs = [4e4, 10.0**power, 6e4, 5e4]
        chain = ar.MassSpringChain([1.0, 0.5, 0.7, 1.2, 0.8], springs, ground_first_n_per_m=3e4)
        k, m = (np.asarray(a) for a in (chain.stiffness(), chain.mass()))
        model = ar.MatrixModel(k, m)
        together = model.antiresonances(range(5), force, include_cancelled=True)
    assert "taken out" in repr(model)
    for response, found in enumerate(together):
        _, wanted = exact_hz(k, m, response, force)
        np.testing.assert_allclose(found, wanted, rtol=RTOL)
    assert max(found.max(initial=0.0) for found in together) > 0.1 * 10.0 ** (power / 2)

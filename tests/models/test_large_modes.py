"""Modes up to a limit of models that are too large for dense matrices."""

import numpy as np
import pytest
import scipy.sparse

import antires_rs as ar


def chain(n, n_per_m):
    k = scipy.sparse.diags_array([np.full(n, 2.0), -np.ones(n - 1), -np.ones(n - 1)], offsets=[0, 1, -1])
    return (n_per_m * k).tolil()


def test_what_the_factors_leave_open_is_refused_not_made_dense():
    """A spring of negative stiffness: K + sigma M has no factor."""
    k = chain(9000, 1e9)
    k[4000, 4000] -= 1e10
    model = ar.MatrixModel(k.tocsc(), scipy.sparse.eye_array(9000))
    with pytest.raises(ar.NumericalError, match="modes of 9000 dofs up to a limit.*Check the signs"):
        model.modes(f_max_hz=5.0)


def test_a_long_chain_is_counted():
    n = 9000
    freq = ar.MatrixModel(chain(n, 1e9).tocsc(), scipy.sparse.eye_array(n)).modes(f_max_hz=20.0).freq_hz
    exact = 2.0 * np.sqrt(1e9) * np.sin(0.5 * np.pi * np.arange(1, 60) / (n + 1)) / (2.0 * np.pi)
    np.testing.assert_allclose(freq, exact[exact <= 20.0], rtol=1e-8)

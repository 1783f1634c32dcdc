"""The same bits for any number of BLAS threads."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
import scipy.linalg  # noqa: F401  (its BLAS must be there to be counted)
from threadpoolctl import threadpool_info

from antires_rs.support.progress import one_blas_thread

CURVES = """
import hashlib, numpy as np, antires_rs as ar
rng = np.random.default_rng(3)
n = 12
model = ar.MassSpringChain(rng.uniform(0.3, 0.6, n), rng.uniform(3e4, 8e4, n - 1), ground_first_n_per_m=2e4)
freq_hz = np.arange(4.0, 120.0, 0.125)
h = model.frf(list(range(n)), 0, freq_hz, damping_ratio=0.005)
noise = rng.normal(size=h.shape) + 1j * rng.normal(size=h.shape)
h = h + 0.01 * np.sqrt(np.mean(np.abs(h) ** 2)) * noise
curves = ar.FrequencyResponse(freq_hz, h, dofs=list(range(n)), kind="frf")
zeros = ar.identify_antiresonances(curves, excitation=0, band_hz=(5, 110), check="off")
assert sum(zeros[d].size for d in zeros) > 20
print(hashlib.sha256(b"".join(zeros[d].tobytes() + zeros.std_hz[d].tobytes() for d in zeros)).hexdigest())
"""


def _digest(threads: int) -> str:
    environment = os.environ | {"OPENBLAS_NUM_THREADS": str(threads), "MKL_NUM_THREADS": str(threads)}
    call = [sys.executable, "-c", CURVES]
    return subprocess.run(call, env=environment, capture_output=True, text=True, check=True).stdout.strip()


def test_curves_give_the_same_bits_for_any_number_of_blas_threads() -> None:
    assert _digest(1) == _digest(2)


def _blas_threads() -> list[int]:
    return [library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"]


def test_the_limit_ends_with_the_call_even_where_it_fails() -> None:
    before = _blas_threads()
    assert set(one_blas_thread(_blas_threads)()) == {1}
    assert _blas_threads() == before

    @one_blas_thread
    def fails() -> None:
        raise RuntimeError("inside")

    with pytest.raises(RuntimeError, match="inside"):
        fails()
    assert _blas_threads() == before

"""Other threads of Python run while the core computes: no call holds the interpreter."""

import sys
import threading
import time

import numpy as np
import pytest
import scipy.sparse

import antires_rs as ar


@pytest.fixture(scope="module")
def grid():
    """A square grid of masses and springs, 2,025 dofs, its halves as terms; and a problem with it."""
    side = 45
    off = -np.ones(side - 1)
    line = scipy.sparse.diags_array([off, 2.01 * np.ones(side), off], offsets=(-1, 0, 1))
    k = 1e5 * scipy.sparse.kronsum(line, line, format="csr")
    m = scipy.sparse.diags_array(np.random.default_rng(0).uniform(0.5, 2.0, side * side))
    half = scipy.sparse.diags_array((np.arange(side * side) < side * side // 2).astype(float))
    model = ar.MatrixModel(k, m, stiffness_terms=[2e3 * half])
    unknowns = ar.stiffness_factor(0, bounds=(0.5, 1.5))
    found = ar.AntiresonanceSet(40, {40: model.antiresonances(40, 40, f_max_hz=15.0)}, sees="frf")
    return model, unknowns, ar.UpdatingProblem(model, unknowns, found)


@pytest.mark.parametrize("call", ["with_parameters", "model_at", "cost", "antiresonances", "modes"])
def test_a_second_thread_advances(grid, call):
    model, unknowns, problem = grid
    calls = {
        "with_parameters": lambda: [model.with_parameters(unknowns, 0.9) for _ in range(10)],
        "model_at": lambda: [problem.model_at([0.9]) for _ in range(10)],
        "cost": lambda: problem.cost([0.9]),
        "antiresonances": lambda: model.antiresonances([1, 2, 3], 40, f_max_hz=15.0),
        "modes": lambda: model.modes(f_max_hz=15.0),
    }
    seen, stop = [0], threading.Event()

    def count():
        while not stop.is_set():
            seen[0] += 1
            time.sleep(1e-5)

    before = sys.getswitchinterval()
    thread = threading.Thread(target=count, daemon=True)
    thread.start()
    try:
        sys.setswitchinterval(1000.0)  # only a call that lets go of the interpreter lets the thread run
        for _ in range(20):
            began = seen[0]
            calls[call]()
            if seen[0] > began:
                break
        advanced = seen[0] - began
    finally:
        sys.setswitchinterval(before)
        stop.set()
        thread.join()
    assert advanced > 0

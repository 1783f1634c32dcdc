"""The modal route against SciPy's QZ on random frames, and against 50 digits on some of them.

Run:  python -m benchmarks.frames_against_scipy [frames=200] [of them in 50 digits=20] [first=0]
Plane and space frames, trees and loops, free and supported, up to 300 dofs; the band holds 5 to 40 modes.
Where the two differ by more than 1e-7, or in number, 50 digits say which of them is right. There the
number of roots at the driving point, those that cancel included, is also held against Sylvester's law.
Some are also asked without a limit, and by the pencil: as many roots have to lie below it.
"""

# ruff: noqa: E402  (the number of BLAS threads is read once, when numpy is imported)
import os

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import sys
import time
import warnings

import numpy as np
import scipy.linalg

import antires_rs as ar
from reference.exact_roots import ExactPencil
from reference.random_frames import random_frame, rigid_hz
from reference.random_models import Oracle, cancelled

SAME, PROMISE = 1e-7, 1e-9

#: One frame in so many, of no more dofs than QZ takes a second for, is also asked without a limit and by the
#: pencil.
EVERY, MOST_DOFS = 4, 150


def band_of(k_mat, m_mat, rng):
    """A limit in Hz with 5 to 40 modes below it, in a gap."""
    lam = scipy.linalg.eigvalsh(k_mat, m_mat)
    modes = min(int(rng.integers(5, 41)), lam.size - 1)
    return np.sqrt(0.3 * lam[modes - 1] + 0.7 * lam[modes]) / (2 * np.pi)


def unmatched(ours, theirs):
    """Those of ours that have none of theirs within SAME."""
    return [f for f in ours if theirs.size == 0 or np.abs(theirs / f - 1.0).min() > SAME]


def main(frames=200, digits=20, first=0):
    warnings.simplefilter("ignore")
    counts = {
        "pairs": 0,
        "roots": 0,
        "equal": 0,
        "scipy wrong": 0,
        "ours wrong": 0,
        "miscounted": 0,
        "asked otherwise": 0,
        "unlike": 0,
    }
    apart, errors, ours_s, scipy_s = [], [], 0.0, 0.0
    for seed in range(first, first + frames):
        rng = np.random.default_rng([4, seed])
        k_mat, m_mat = random_frame(rng)
        limit_hz = band_of(k_mat, m_mat, rng)
        excitation = int(rng.integers(0, len(k_mat)))
        responses = [excitation, int(rng.integers(0, len(k_mat)))]
        model = ar.MatrixModel(k_mat, m_mat)
        start = time.perf_counter()
        found = model.antiresonances(responses, excitation, f_max_hz=limit_hz)
        ours_s += time.perf_counter() - start
        exact = ExactPencil(k_mat, m_mat)
        full = model.antiresonances(excitation, excitation, f_max_hz=limit_hz, include_cancelled=True)
        low_hz = rigid_hz(k_mat, m_mat)
        if seed < digits and np.sum(full > low_hz) != exact.driving_zeros(excitation, low_hz, limit_hz):
            counts["miscounted"] += 1
            print(f"  frame {seed}, n = {len(k_mat)}, ({excitation}, {excitation}): {full}", flush=True)
        if seed % EVERY == 0 and len(k_mat) <= MOST_DOFS:
            unlimited = model.antiresonances(responses, excitation)
            pencil = model.antiresonances(responses, excitation, f_max_hz=limit_hz, method="pencil")
            for ours, *others in zip(found, unlimited, pencil, strict=True):
                counts["asked otherwise"] += 1
                sizes = [np.count_nonzero(other <= limit_hz) for other in others]
                if sizes != [ours.size] * 2:
                    counts["unlike"] += 1
                    print(
                        f"  frame {seed}, n = {len(k_mat)}: {ours.size} roots below the limit, without one "
                        f"{sizes[0]}, by the pencil {sizes[1]}",
                        flush=True,
                    )
        for i, ours in zip(responses, found, strict=True):
            start = time.perf_counter()
            theirs = Oracle(k_mat, m_mat, i, excitation).freq_hz(0.0, (2 * np.pi * limit_hz) ** 2)
            scipy_s += time.perf_counter() - start
            theirs = theirs[~cancelled(k_mat, m_mat, i, excitation, theirs)]
            counts["pairs"] += 1
            counts["roots"] += ours.size
            only_ours, only_theirs = unmatched(ours, theirs), unmatched(theirs, ours)
            if ours.size == theirs.size and not only_ours and not only_theirs:
                counts["equal"] += 1
                apart += list(np.abs(ours / theirs - 1.0))
            else:
                wrong = [f for f in only_ours if not kept(exact.error(i, excitation, f))]
                moved = [exact.root_near(i, excitation, f) for f in only_theirs]
                missed = [f for f in moved if f is not None and unmatched([f], ours)]
                counts["ours wrong" if wrong or missed else "scipy wrong"] += 1
                print(
                    f"  frame {seed}, n = {len(k_mat)}, ({i}, {excitation}), {limit_hz:.0f} Hz: "
                    f"ours {only_ours}, scipy {only_theirs}; ours wrong {wrong}, missed {missed}",
                    flush=True,
                )
            if seed < digits:
                errors += [exact.error(i, excitation, f) for f in ours]
    print(f"{frames} frames: {counts}")
    print(
        f"apart from SciPy: q50 {np.quantile(apart, 0.5):.1e}, q99 {np.quantile(apart, 0.99):.1e}, "
        f"max {np.max(apart):.1e}; time of SciPy over ours {scipy_s / ours_s:.0f}"
    )
    if errors:
        error, ulp = np.abs(np.array(errors)).T
        over = error / np.maximum(PROMISE, 20 * ulp)
        print(
            f"{len(errors)} roots in 50 digits: largest error {error.max():.1e}, over one ulp's shift "
            f"{np.max(error / ulp):.1f}, over the promise {over.max():.2f}"
        )


def kept(error):
    """Whether the promise holds."""
    return abs(error[0]) <= max(PROMISE, 20 * error[1])


if __name__ == "__main__":
    main(*(int(a) for a in sys.argv[1:4]))

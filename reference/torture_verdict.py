"""Whether the antiresonances of a pencil are right: each within its stated bound, or told to be uncertain."""

from __future__ import annotations

import time
import warnings
from dataclasses import dataclass, field

import mpmath
import numpy as np

import antires_rs as ar
from reference.exact_pencils import ExactRoots, is_singular

#: A root that an ulp of each entry moves by more than this part is zero or infinite at working precision.
VANISHING = 1e-3
#: What counts as real, and so may be returned: imaginary part over modulus.
NEARLY_REAL = 3e-7
#: An uncertain one within this relative distance stands for a root, which is then not missing.
NEAR = 1e-2


@dataclass
class Verdict:
    """One pencil: wrong statements (refusing sound matrices is one), and how many roots were certain."""

    wrong: list[str] = field(default_factory=list)
    certain: int = 0
    uncertain: int = 0
    refused: str = ""
    seconds: float = 0.0
    largest_bound: float = 0.0
    largest_part: float = 0.0  # of its bound that an error takes


def verdict(case, *, include_cancelled=True):
    """Solve one pencil and hold every root against the exact ones."""
    out = Verdict()
    exact = ExactRoots(case.stiffness, case.mass, case.response, case.excitation)
    started = time.perf_counter()
    try:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            model = ar.MatrixModel(case.stiffness, case.mass)
            freq, error = model.antiresonances(
                case.response, case.excitation, include_cancelled=include_cancelled, bounds=True
            )
    except ar.AntiresError as refusal:
        out.refused = str(refusal)
        if not is_singular(case.stiffness, case.mass):
            out.wrong.append(f"refused: {refusal}")
        return out
    except Exception as broken:  # whatever it is, the other pencils are judged too
        out.wrong.append(f"{type(broken).__name__}: {broken}")
        return out
    finally:
        out.seconds = time.perf_counter() - started
    if exact.is_zero:
        out.wrong += [f"{f:.6g} Hz where H is zero" for f in freq]
        return out
    if any("missing or double" in str(w.message) for w in told):
        out.uncertain += 1
        return out
    compare(out, exact, freq, error)
    return out


def compare(out, exact, freq, error):
    """Give each found root one of its own: certain ones first, then the others."""
    mpmath.mp.prec = 200
    wanted = [
        (mpmath.sqrt(root.x) / (2 * mpmath.pi), abs(root.imaginary / root.x), root)
        for root in exact.roots
        if abs(root.imaginary) <= NEARLY_REAL * root.x
    ]
    free = [[f, root.multiplicity, imaginary, root] for f, imaginary, root in wanted]
    order = np.argsort(error, kind="stable")
    for j in order:
        certain = np.isfinite(error[j])
        # A complex pair is two roots with one real part.
        distances = [
            (abs(f - float(freq[j])) + imaginary * f / 2, at)
            for at, (f, left, imaginary, _) in enumerate(free)
            if left
        ]
        distance, at = min(distances, default=(mpmath.inf, -1))
        if not certain:
            out.uncertain += 1
            if distance <= NEAR * freq[j]:
                free[at][1] -= 1
            continue
        if distance > error[j]:
            out.wrong.append(
                f"{freq[j]:.9g} Hz +- {error[j]:.1e}: the next root is {float(distance):.1e} Hz off"
            )
            continue
        free[at][1] -= 1
        out.certain += 1
        out.largest_bound = max(out.largest_bound, error[j] / freq[j])
        out.largest_part = max(out.largest_part, float(distance / error[j]))
    for f, left, imaginary, root in free:
        if left and not imaginary and exact.ulp(root) <= VANISHING:
            out.wrong.append(
                f"{float(f):.9g} Hz is missing, {left} of {root.multiplicity}, ulp {exact.ulp(root):.0e}"
            )

"""The likeliest numerators: weights and order found together.

Beyond the true order the numerators share a factor that the data do not determine, and the solution of least
misfit loses its accuracy; below it, the fit is wrong. So the order is the one of least

    BIC = (n_data - n_free) log Q(m) + n_free(m) log(n_data)

with n_data the number of independent real data and n_free = (n - 1)(m + 1) (the common factor is not
counted); the level of the noise need not be known. The weights of each iteration come from the one before: of
the lowest order that fits nearly as well as the best, and once that stands, of the best order. Q itself does
not depend on the weights, so that the best of all iterations can be kept.

Reference: G. Schwarz, Ann. Stat. 6 (1978) 461-464.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..signals.eigen import dominant
from ..signals.segments import pieces
from ..support.validation import ComplexArray, FloatArray
from .numerators import NumeratorFit

# Orders settle in two or three iterations of the weights; the others may find better ones.
ITERATIONS = 6
# Relative change of Q from one iteration to the next below which the weights stand, too.
SETTLED = 1e-8
# The weights are those of the lowest order whose misfit is within this factor of the least: a spurious
# common factor of the numerators would distort them.
KNEE = 2.0
# The first iteration looks at every second order, the next ones this far from the knee.
BELOW, ABOVE = 4, 16
# The last fit has so many orders above the likeliest: what is there stays over them, what is noise does not.
HIGHER = 36
# The first look goes up to this order, and twice as far while the likeliest is above this share of it: with
# orders too low for the modes, the criterion has local minima anywhere.
FIRST_LOOK, HIGH = 60, 0.6
# So many lines tell the weights and the order as well as all of them.
ENOUGH_LINES = 1200
# A line at which all numerators nearly vanish must not get all the weight there is.
LEAST_SIZE = 1e-12
LEAST_ORDER = 2


@dataclass(frozen=True)
class Likeliest:
    """Numerators of least misfit.

    ``fit`` holds the weights (and all orders up to its highest), ``coefficients`` are (order + 1, n),
    ``misfit`` is their Rayleigh quotient, the smallest eigenvalue but for rounding.
    """

    fit: NumeratorFit
    order: int
    coefficients: FloatArray
    misfit: float


def likeliest(
    freq_hz: FloatArray,
    covariance: Callable[[slice], ComplexArray],
    cap: float,
    independent: float,
    max_order: int,
    *,
    iterations: int = ITERATIONS,
    start: tuple[int, FloatArray] | None = None,
) -> Likeliest:
    """Iterate weights and order until they stand, or so many times.

    ``max_order`` is the highest order of all: whatever the likeliest is, none above it is fitted.
    ``covariance`` gives the covariances of a slice of the lines, (n_lines, n, n). ``cap`` bounds the
    signal-to-noise power a line may count with; ``independent`` is the number of independent lines over the
    number of lines. ``start`` is the order of an earlier fit and the squared norm of its numerators there.
    """
    n = covariance(slice(0, 1)).shape[1]
    largest = np.empty(freq_hz.size)
    for part in pieces(freq_hz.size, n * n):
        largest[part] = dominant(covariance(part), np.ones(n))[0]
    capped = 1.0 / (1.0 + largest / cap)
    # Weights and order are found on a part of the lines; the last fit has all.
    step = max(1, freq_hz.size // ENOUGH_LINES)
    some = slice(step // 2, None, step)
    data = 2.0 * (n - 1) * len(freq_hz[some]) * min(1.0, independent * step)
    seen = covariance(some)
    orders = np.arange(LEAST_ORDER, min(max_order, FIRST_LOOK) + 1, 2)
    size = np.ones(freq_hz.size)
    looking = start is None
    if start is not None:
        orders = np.arange(max(start[0] - BELOW, LEAST_ORDER), min(start[0] + ABOVE, max_order) + 1)
        size = np.maximum(start[1], LEAST_SIZE * start[1].max())
    best: tuple[float, int, FloatArray] = (np.inf, 0, size)
    last = (-1, -1)
    before = np.inf
    while iterations > 0:
        weights = (capped / size)[some]
        fit = NumeratorFit(freq_hz[some], seen.__getitem__, largest[some], weights, int(orders[-1]))
        solutions = fit.likeliest(*orders.tolist())
        q = _misfits(fit, solutions, seen, largest[some], capped[some])
        free = (n - 1.0) * (orders + 1.0)
        # Q does not depend on the weights, so that iterations can be compared; it need not fall.
        criterion = np.maximum(data - free, 1.0) * np.log(q) + free * np.log(data)
        pick = int(np.argmin(criterion))
        if criterion[pick] < best[0]:
            best = (float(criterion[pick]), int(orders[pick]), size)
        if looking and orders[pick] > HIGH * orders[-1] and orders[-1] + 1 < max_order:
            orders = np.arange(LEAST_ORDER, min(2 * int(orders[-1]), max_order) + 1, 2)
            continue
        looking, iterations = False, iterations - 1
        # The knee first, since spurious factors distort the weights; when it stands, the order itself.
        first = int(np.argmax(q <= KNEE * q.min()))
        stands = (int(orders[first]), int(orders[pick])) == last
        # Many modes: higher orders have not been looked at yet.
        top = pick == orders.size - 1 and FIRST_LOOK <= orders[-1] < max_order
        source = pick if stands or top else first
        last = (int(orders[first]), int(orders[pick]))
        if stands and not top and abs(criterion[pick] - before) <= SETTLED * data:
            break
        before = float(criterion[pick])
        middle = int(orders[source])
        at = fit.basis.at(np.asarray(1j * freq_hz / fit.scale_hz, dtype=np.complex128), middle)
        size = np.sum(np.abs(at @ solutions[source]) ** 2, axis=1)
        size = np.maximum(size, LEAST_SIZE * size.max())
        del fit, at  # before the next one is made
        orders = np.arange(max(middle - BELOW, LEAST_ORDER), min(middle + ABOVE, max_order) + 1)
    _, order, size = best
    del seen  # before the last one is made
    fit = NumeratorFit(freq_hz, covariance, largest, capped / size, min(max_order, order + HIGHER))
    (c,) = fit.likeliest(order)
    return Likeliest(fit, order, c, fit.misfit(c))


def _misfits(
    fit: NumeratorFit,
    solutions: list[FloatArray],
    covariance: ComplexArray,
    largest: FloatArray,
    capped: FloatArray,
) -> FloatArray:
    """Q of every solution."""
    terms, n = fit.max_order + 1, fit.n
    stack = np.zeros((terms, len(solutions), n))
    for i, c in enumerate(solutions):
        stack[: c.shape[0], i] = c
    share = np.empty((largest.size, len(solutions)))
    for lines in pieces(largest.size, n * len(solutions)):
        values = fit.values(stack.reshape(terms, -1), lines).reshape(-1, len(solutions), n)
        seen = values @ covariance[lines].transpose(0, 2, 1)
        # Real parts of the inner products, as those of twice as many real numbers.
        x, y = values.view(np.float64), seen.view(np.float64)
        share[lines] = np.einsum("fsk,fsk->fs", x, y)
        share[lines] /= np.maximum(np.einsum("fsk,fsk->fs", x, x), 1e-300)
    return np.asarray(np.maximum(capped @ (largest[:, None] - share), 1e-300))

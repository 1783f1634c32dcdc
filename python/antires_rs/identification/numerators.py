r"""All numerators at once: the responses to one force as one vector of polynomials.

Under one force at k the responses at a line are x = a N(s): a vector of polynomials N_p, the numerators of
H_pk, times a factor a that holds the force and the common denominator. With covariances C of the responses,
scaled to unit noise in every channel, the likelihood of N (the factors a being free) falls with

    Q(N) = sum_f [ lam_f - N' C_f N / (N' N) ],      lam_f = largest eigenvalue of C_f

so only the *direction* of N counts: the resonances, the force and its spectrum have dropped out. By
Lagrange's identity Q is the sum of the misfits of all transmissibilities T_pq at once: every pair
contributes, which lifts the lowest antiresonances of a response, 20 to 30 dB under its noise, out of it.

With the weights 1 / N'N taken from the iteration before, Q is a quadratic form c' A c in the coefficients. On
Forsythe's polynomials for the same weights the noise adds a multiple of the identity to A: "likeliest", the
eigenvector of the smallest eigenvalue, has no bias for the true order; "low", all of the lowest coefficient
that there can be, sends spurious roots, common to all N_p, to the right half plane, and serves the sweep over
orders. A is ordered by degree: one Cholesky factor serves every order.

References: M. Viberg and B. Ottersten, IEEE Trans. Signal Process. 39 (1991) 1110-1121 (subspace fitting);
C. K. Sanathanan and J. Koerner, IEEE Trans. Autom. Control 8 (1963) 56-58 (reweighting).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..exceptions import NumericalError
from ..signals.spectra import CrossSpectra, dominant, pieces
from ..support.checks import ComplexArray, FloatArray
from .lines import SNR_CAP, Lines
from .rational_fit import Basis, dominance, forsythe_basis, roots
from .scores import shared

# Relative to the mean diagonal: exact data make A singular, and rounding must not make it indefinite. The
# first that serves is taken.
RIDGES = (1e-13, 1e-11, 1e-9)
# Inverse iterations; eigenvalues 2 and 1 lie far apart at the true order, and beyond it any will do.
ITERATIONS = 4


SIGNS = (1.0, 1.0, -1.0, -1.0)  # of i^k: for even k the real number, for odd k the imaginary one
UNDEFINED = "the spectra leave them undefined; check for channels that are copies or hold no signal"


class NumeratorFit:
    """The quadratic form of the weighted direction misfit, factored once for all orders to ``max_order``."""

    step = 1  #: From one order to the next.

    def __init__(
        self,
        freq_hz: FloatArray,
        covariance: Callable[[slice], ComplexArray],
        largest: FloatArray,
        weights: FloatArray,
        max_order: int,
    ) -> None:
        self.n = covariance(slice(0, 1)).shape[1]
        self._lay(freq_hz, weights, max_order, 2 * max_order)
        self._factor(form_of(self.whole, self.weights, covariance, largest, max_order + 1), self.n)

    def _lay(self, freq_hz: FloatArray, weights: FloatArray, max_order: int, degree: int) -> None:
        """Lay the polynomials on the lines up to ``degree``, of which solutions have ``max_order``."""
        self.scale_hz, self.max_order = float(freq_hz[-1]), max_order
        self.weights = weights / weights.sum()
        self.whole = forsythe_basis(freq_hz / self.scale_hz, self.weights, degree)
        terms = max_order + 1
        self.basis = Basis(self.whole.b[:terms], self.whole.p[:, :terms])
        # i^k times a polynomial is real for even k and imaginary for odd k, with the signs SIGNS.
        self._even, self._odd = (np.ascontiguousarray(self.basis.p[:, parity::2]) for parity in (0, 1))
        self._signs = np.resize(SIGNS, terms)

    def _factor(self, form: FloatArray, n: int) -> None:
        self.form, self._upper = form, _upper(form)
        self._first = solved(self._upper, np.eye(form.shape[0], n))

    def low(self, order: int) -> FloatArray:
        """Coefficients (order + 1, n) with the largest lowest coefficient for a given misfit."""
        size = (order + 1) * self.n
        first = self._first[:size]
        best = np.linalg.eigh(first.T @ first)[1][:, -1]
        c = solved(self._upper[:, :size], first @ best, transposed=True)
        return np.asarray(c / np.linalg.norm(c)).reshape(order + 1, self.n)

    def likeliest(self, *orders: int) -> list[FloatArray]:
        """Coefficients (order + 1, n) of least misfit for their norm, of every order."""
        if not orders:
            return []
        sizes = self.n * (np.array(orders) + 1)
        # One column an order: where a column is zero at the end, the whole factor is the leading block's.
        beyond = np.arange(sizes.max())[:, None] >= sizes
        root = self._upper[:, : sizes.max()]
        c = np.array(
            np.broadcast_to(self._first[: sizes.max()].sum(axis=1)[:, None], beyond.shape), order="F"
        )
        for _ in range(ITERATIONS):
            c[beyond] = 0.0
            c = solved(root, c)
            c[beyond] = 0.0
            c = solved(root, c, transposed=True)
            c /= np.linalg.norm(c, axis=0)
        return [own[:size].reshape(-1, self.n) for own, size in zip(c.T, sizes, strict=True)]

    def misfit(self, c: FloatArray) -> float:
        """Quadratic form of coefficients (order + 1, n)."""
        flat, lower = c.ravel(), np.tril(self.form[: c.size, : c.size])
        return float(flat @ (lower + np.tril(lower, -1).T) @ flat)

    def values(self, c: FloatArray, lines: slice = slice(None)) -> ComplexArray:
        """N at the lines, (n_freq, n); ``c`` may hold several solutions side by side."""
        signed = self._signs[: c.shape[0], None] * c
        even, odd = signed[0::2], signed[1::2]
        out = np.empty((len(self.basis.p[lines]), c.shape[1]), dtype=np.complex128)
        out.real = self._even[lines, : even.shape[0]] @ even
        out.imag = self._odd[lines, : odd.shape[0]] @ odd
        return out

    def projected(self, fields: ComplexArray, order: int, lines: slice) -> FloatArray:
        """Sums over some lines of Re(conj(phi_k) w x), (order + 1, n_columns), x the ``fields`` there."""
        out = np.empty((order + 1, fields.shape[1]))
        count = (order + 2) // 2, (order + 1) // 2
        weighted = fields * self.weights[lines, None]
        out[0::2] = self._even[lines, : count[0]].T @ weighted.real
        out[1::2] = self._odd[lines, : count[1]].T @ weighted.imag
        return np.asarray(out * self._signs[: order + 1, None])

    def zeros(self, own: FloatArray, near: ComplexArray | None = None) -> ComplexArray:
        """Roots in rad/s of a numerator ``own``, (order + 1,); ``near``: of the order before, if known."""
        unit = 2 * np.pi * self.scale_hz
        own = np.ascontiguousarray(own)
        return roots(own, self.basis.b[: own.size], None if near is None else near / unit) * unit

    def slopes(self, own: FloatArray, s: ComplexArray) -> ComplexArray:
        """Derivatives of simple roots (rad/s) of a numerator by its coefficients, (n_roots, order + 1)."""
        unit = 2 * np.pi * self.scale_hz
        u = s / unit
        return np.asarray(-self.basis.at(u, own.size - 1) / self.changes(own, u)[:, None] * unit)

    def changes(self, own: FloatArray, u: ComplexArray) -> ComplexArray:
        """Derivatives of a numerator at points (in units of 2 pi f_max), (n_points,)."""
        order, step = own.size - 1, 1e-6 * np.abs(u)
        # A central difference: an error of 1e-12 of what needs three digits.
        return np.asarray(
            (self.basis.at(u + step, order) - self.basis.at(u - step, order)) @ own / (2 * step)
        )

    def dominances(self, c: FloatArray, row: int, s: ComplexArray, others: Sequence[int]) -> FloatArray:
        """Share of each root's own peak in the quotients of ``others`` over ``row`` at its frequency.

        ``c`` is one solution, (order + 1, n), or one for each root.
        """
        above = c[..., list(others)].swapaxes(-1, -2)
        return dominance((self.basis, above), (self.basis, c[..., row]), s / (2 * np.pi * self.scale_hz))


def form_of(
    whole: Basis,
    weights: FloatArray,
    covariance: Callable[[slice], ComplexArray],
    largest: FloatArray,
    terms: int,
) -> FloatArray:
    """A of Q = c' A c, ordered by degree, then by channel; its lower half.

    Its entries are sums over the lines of z phi_i phi_j, z the weighted entries of lam I - C. By
    b_{i+1} <i+1, j> + b_i <i-1, j> = b_{j+1} <i, j+1> + b_j <i, j-1> all follow from the sums <0, k>.
    """
    n, b = covariance(slice(0, 1)).shape[1], whole.b[:, None]
    one, other = np.triu_indices(n)
    z = np.empty((largest.size, one.size), dtype=np.complex128)
    # Some lines at a time: half of the entries are enough, and all of them are never held.
    for some in pieces(largest.size, n * n):
        np.negative(np.take(covariance(some).reshape(-1, n * n), one * n + other, axis=1), out=z[some])
    z[:, one == other] += largest[:, None]
    z *= weights[:, None]
    # Even products see the real part of z, odd ones the imaginary part.
    row = np.empty((2 * terms - 1, one.size))
    row[0::2] = whole.p[:, 0 : 2 * terms - 1 : 2].T @ z.real
    row[1::2] = whole.p[:, 1 : 2 * terms - 1 : 2].T @ z.imag
    del z
    row /= whole.b[0]
    place = np.empty((n, n), dtype=int)
    place[one, other] = place[other, one] = np.arange(one.size)
    # Re(i^m z): the real part for even m, the imaginary one, which is antisymmetric, for odd m.
    signs = np.resize(SIGNS, terms)[:, None, None] * np.ones((n, n))
    signs[1::2] *= np.where(np.arange(n)[:, None] < np.arange(n), 1.0, -1.0)
    form = np.zeros((terms, n, terms, n))
    before = np.zeros_like(row)
    for i in range(terms):  # Row i holds <i, i>, <i, i + 1>, ... only: those before are known.
        np.multiply(np.take(row[: terms - i], place, axis=1), signs[: terms - i], out=form[i:, :, i])
        last = i + row.shape[0]
        after = b[i + 2 : last] * row[2:]
        after += b[i + 1 : last - 1] * row[:-2]
        if i:
            after -= b[i] * before[2:-2]
        before, row = row, after / whole.b[i + 1]
    return form.reshape(terms * n, terms * n)


def _upper(form: FloatArray) -> FloatArray:
    """Transpose of the Cholesky factor; a direction without any misfit at all is left to the ridge."""
    from scipy.linalg.lapack import dpotrf  # slow to import

    ridge = max(float(np.trace(form)) / form.shape[0], 1e-300)
    for share in RIDGES:
        ridged = form.copy()
        ridged.flat[:: form.shape[0] + 1] += share * ridge
        # BLAS reads columns: of a symmetric matrix they are the rows.
        upper, info = dpotrf(ridged.T, lower=0, clean=0, overwrite_a=1)
        if info == 0:
            return np.asarray(upper)
    raise NumericalError("the numerators of all responses", UNDEFINED)


def solved(upper: FloatArray, right: FloatArray, *, transposed: bool = False) -> FloatArray:
    """Solution with a lower triangular factor or its transpose, which ``upper`` is, or its first columns."""
    from scipy.linalg.lapack import dtrtrs  # slow to import

    return np.asarray(dtrtrs(upper, right, lower=0, trans=int(not transposed))[0])


class NumeratorSweep:
    """Zeros of one response's numerator, order by order: what the stabilization diagram asks for."""

    refines = False

    def __init__(
        self, fit: NumeratorFit, row: int, others: Sequence[int], solutions: dict[int, FloatArray]
    ) -> None:
        self.fit, self.row, self.others = fit, row, tuple(others)
        self._solutions = solutions  # shared by the rows of one fit
        self._roots: dict[int, ComplexArray] = {}
        #: Sweeps of the other rows, if roots that all rows share are to count as spurious.
        self.companions: list[NumeratorSweep] = []

    def _solution(self, order: int) -> FloatArray:
        if order not in self._solutions:
            self._solutions[order] = self.fit.low(order)
        return self._solutions[order]

    def roots(self, order: int, norm: bool = False) -> ComplexArray:
        """All roots in rad/s. There is one solution an order; ``norm`` asks for the same."""
        if order not in self._roots:
            own = self._solution(order)[:, self.row]
            self._roots[order] = self.fit.zeros(own, self._roots.get(order - self.fit.step))
        return self._roots[order]

    def dominances(self, order: int | NDArray[np.int64], s: ComplexArray) -> FloatArray:
        """Share of each root's own peak in the curves at its frequency; none if all rows have the root."""
        orders, at = np.unique(np.broadcast_to(order, s.shape), return_inverse=True)
        c = np.zeros((orders.size, orders.max(initial=0) + 1, self.fit.n))
        for one, own in zip(c, orders.tolist(), strict=True):
            one[: own + 1] = self._solution(own)
        share = self.fit.dominances(c[at], self.row, s, self.others)
        beside = []
        for other in self.companions:  # roots of each order, infinite where one has fewer
            every = np.full((orders.size, orders.max(initial=0)), np.inf, dtype=np.complex128)
            for one, order_of_one in zip(every, orders.tolist(), strict=True):
                found = other.roots(order_of_one)
                one[: found.size] = found
            beside.append(every[at])
        return np.where(shared(s, beside), 0.0, share)


# -- The likeliest numerators: weights and order found together
#
# Beyond the true order the numerators share a factor that the data do not determine; below it, the fit is
# wrong. So the order is the one of least
#
#     BIC = (n_data - n_free) log Q(m) + n_free(m) log(n_data)
#
# with n_data independent real data and n_free = (n - 1)(m + 1) (the common factor is not counted); the level
# of the noise need not be known. The weights of each iteration come from the one before; Q itself does not
# depend on them, so that the best of all iterations can be kept.
#
# Reference: G. Schwarz, Ann. Stat. 6 (1978) 461-464.

# Orders settle in two or three iterations of the weights; the others may find better ones.
ITERATIONS_LIKELIHOOD = 6
SETTLED = 1e-8  # relative change of Q from one iteration to the next below which the weights stand, too
# The weights are those of the lowest order whose misfit is within this factor of the least: a spurious
# common factor of the numerators would distort them.
KNEE = 2.0
BELOW, ABOVE = 4, 16  # the first iteration looks at every second order, the next ones this far from the knee
# The last fit has so many orders above the likeliest: what is there stays over them, what is noise does not.
HIGHER = 36
# The first look goes up to this order, and twice as far while the likeliest is above this share of it: with
# orders too low for the modes, the criterion has local minima anywhere.
FIRST_LOOK, HIGH = 60, 0.6
ENOUGH_LINES = 1200  # so many lines tell the weights and the order as well as all of them
LEAST_SIZE = 1e-12  # a line at which all numerators nearly vanish must not get all the weight there is
LEAST_ORDER = 2


@dataclass(frozen=True)
class Likeliest:
    """Numerators of least misfit: ``coefficients`` (order + 1, n), ``misfit`` their Rayleigh quotient."""

    fit: NumeratorFit
    order: int
    coefficients: FloatArray
    misfit: float

    def influence(self, lines: Lines) -> Influence:
        """What the draws of these lines would move its zeros by."""
        return Influence(self, lines)


def likeliest(
    freq_hz: FloatArray,
    covariance: Callable[[slice], ComplexArray],
    cap: float,
    independent: float,
    max_order: int,
    *,
    iterations: int = ITERATIONS_LIKELIHOOD,
    start: tuple[int, FloatArray] | None = None,
) -> Likeliest:
    """Iterate weights and order until they stand, or so many times; no order above ``max_order`` is fitted.

    ``covariance`` gives the covariances of a slice of the lines, (n_lines, n, n). ``cap`` bounds the
    signal-to-noise power a line may count with; ``independent`` is the number of independent lines over all.
    ``start`` is the order of an earlier fit and the squared norm of its numerators.
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
    # N' C N for N as twice as many real numbers: half the work of complex ones.
    square = np.empty((len(seen), n, 2, n, 2))
    square[:, :, 0, :, 0] = square[:, :, 1, :, 1] = seen.real
    square[:, :, 1, :, 0], square[:, :, 0, :, 1] = seen.imag, -seen.imag
    forms = square.reshape(len(seen), 2 * n, 2 * n)
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
        q = _misfits(fit, solutions, forms, largest[some], capped[some])
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
    del seen, square, forms  # before the last one is made
    fit = NumeratorFit(freq_hz, covariance, largest, capped / size, min(max_order, order + HIGHER))
    (c,) = fit.likeliest(order)
    return Likeliest(fit, order, c, fit.misfit(c))


def _misfits(
    fit: NumeratorFit, solutions: list[FloatArray], forms: FloatArray, largest: FloatArray, capped: FloatArray
) -> FloatArray:
    """Q of every solution."""
    terms, n = fit.max_order + 1, fit.n
    stack = np.zeros((terms, len(solutions), n))
    for i, c in enumerate(solutions):
        stack[: c.shape[0], i] = c
    share = np.empty((largest.size, len(solutions)))
    for lines in pieces(largest.size, n * len(solutions)):
        values = fit.values(stack.reshape(terms, -1), lines).reshape(-1, len(solutions), n)
        x = values.view(np.float64)
        share[lines] = np.einsum("fsk,fsk->fs", x, x @ forms[lines])
        share[lines] /= np.maximum(np.einsum("fsk,fsk->fs", x, x), 1e-300)
    return np.asarray(np.maximum(capped @ (largest[:, None] - share), 1e-300))


# -- How far an identified value may be off: standard deviations from the scatter of the segments
#
# The coefficients c solve (A - mu I) c = 0, so a change dA moves them by
#
#     dc = -(A - mu I)^+ dA c,      dA c = -sum_f g_f Re phi' (dC_f N - (N' dC_f N / N'N) N)
#
# and a zero s of N_j by its slope ds/dc. Each Welch segment (without segments: each block of neighbouring
# lines) is one independent draw of all C_f; what its own x x' would move the zero by is its influence, and
# the variance of the mean of K influences is the variance of the zero (the infinitesimal jackknife). Nothing
# is assumed of the noise.
#
# R records of one test, R impacts, or the curves of R tests are R draws with R - 1 degrees of freedom, whose
# scatter b^2 holds whatever differs from record to record. The scatter inside the records, w^2, has many,
# and knows noise and leakage alone. Their ratio is much the same for all zeros of a test:
#
#     q = max(1, median of b^2 / w^2 over all zeros / median of chi^2_{R-1} / (R - 1)),
#
# and the variance of one zero is ((R - 1) b^2 + n_0 q w^2) / (R - 1 + n_0), with n_0 = 8.
#
# References: B. Efron, The Jackknife, the Bootstrap and Other Resampling Plans, SIAM 1982, ch. 6; H. White,
# Econometrica 50 (1982) 1-25; G. K. Smyth, Stat. Appl. Genet. Mol. Biol. 3 (2004) article 3 (moderated
# variances).

PRIOR = 8.0  # degrees of freedom with which the whole test speaks on the variance of one zero
BLOCKS = 64  # without segments: so many blocks of neighbouring lines stand for independent draws
# Directions of the coefficients that the data do not determine (a common factor) move no zero of one
# numerator; below this share of the largest eigenvalue they are left out.
UNDETERMINED = 1e-12
WIDEST = 0.15  # roots of more damping than this are no zeros of a structure


def excess(between: FloatArray, within: FloatArray, n_draws: int) -> float:
    """q, from the variances of many zeros, (n,) each."""
    from scipy.stats import chi2  # slow to import

    if not between.size:
        return 1.0
    middle = float(chi2.ppf(0.5, n_draws - 1)) / (n_draws - 1)
    return max(1.0, float(np.median(between / np.maximum(within, 1e-300))) / middle)


def freedom(n_draws: int) -> float:
    """Degrees of freedom of a variance that :func:`combined` gives."""
    return n_draws - 1.0 + PRIOR


def combined(between: FloatArray, within: FloatArray, n_draws: int, q: float) -> FloatArray:
    """Variance of each zero."""
    return np.asarray(((n_draws - 1.0) * between + PRIOR * q * within) / freedom(n_draws))


def independent_averages(spectra: CrossSpectra) -> float:
    """How many independent averages stand behind the standard deviations that these spectra give."""
    if spectra.draws is None:
        return spectra.n_effective
    return min(freedom(np.unique(spectra.draws).size), max(spectra.n_effective, PRIOR))


class Influence:
    """Derivatives of zeros of the ``best`` solution by the covariances.

    What a draw x x' would move the coefficients' right-hand side by is summed over its lines once for all
    zeros, ``(n_coefficients, n_draws)``; a zero's influences are one product with it.
    """

    def __init__(self, best: Likeliest, lines: Lines) -> None:
        self.fit = best.fit
        self.c, form, offset = self._unknowns(best)
        self._values = self.fit.values(self.c)
        self._sums: FloatArray | None = None
        self._excess = 1.0
        values, self._vectors = np.linalg.eigh(form)
        gap = values - offset
        # The solution itself, the smallest, is a matter of scale.
        keep = gap > max(UNDETERMINED * values[-1], 1e-300)
        keep[0] = False
        self._inverse = np.where(keep, 1.0 / np.where(keep, gap, 1.0), 0.0)
        n_lines = lines.freq_hz.size  # Neighbouring lines that stand for independent draws.
        ends = np.linspace(0, n_lines, min(BLOCKS, n_lines) + 1).round().astype(int)
        blocks = [slice(a, b) for a, b in zip(ends[:-1], ends[1:], strict=True)]
        if lines.segments is None:
            single = (np.sqrt(lines.snr) * lines.vectors).T[:, :, None]
            push = np.concatenate([self._pushed(single.__getitem__, block, 1) for block in blocks], axis=1)
            self._push = push - push.mean(axis=1, keepdims=True)
            self._scale = len(blocks) / (len(blocks) - 1)
            return
        draws, count = lines.segments.at, lines.segments.count
        push = self._pushed(draws, slice(0, n_lines), count)
        self._push = push - push.mean(axis=1, keepdims=True)
        self._scale = lines.averages_ratio / count**2 * count / (count - 1)
        if lines.draws is None:
            return
        by_draw = [self._push[:, lines.draws == draw].sum(axis=1) for draw in np.unique(lines.draws)]
        self._sums = np.stack(by_draw, axis=1) / count
        if len(by_draw) == count:  # of one impact each: inside it, blocks of lines
            each = np.stack([self._pushed(draws, block, count) for block in blocks], axis=1)
            self._push = (each - each.mean(axis=2, keepdims=True)).reshape(len(each), -1)
            self._scale = 1.0 / (count * (count - 1.0))

    def _unknowns(self, best: Likeliest) -> tuple[FloatArray, FloatArray, float]:
        """The unknowns, (terms, n_columns), their quadratic form, and mu."""
        size = best.coefficients.size
        return best.coefficients, self.fit.form[:size, :size], best.misfit

    def _push_of(self, at: slice, x: ComplexArray) -> ComplexArray:
        """x x' N less its part along N, (n_lines, n_columns, n_draws), of draws at some lines."""
        n = self._values[at]
        along = n.conj()[:, None, :] @ x
        length = np.sum(np.abs(n) ** 2, axis=1)[:, None, None]
        part = x * along.conj()
        part -= n[:, :, None] * (np.abs(along) ** 2 / length)
        return part

    def _pushed(self, draws: Callable[[slice], ComplexArray], lines: slice, n_draws: int) -> FloatArray:
        """Products of the polynomials with what draws push by, (n_coefficients, n_draws).

        Summed over some lines; the draws x at lines are (n_lines, n, n_draws).
        """
        total = np.zeros((self.c.shape[0], self.c.shape[1] * n_draws))
        for some in pieces(lines.stop - lines.start, self._values.shape[1] * n_draws):
            at = slice(lines.start + some.start, lines.start + some.stop)
            part = self._push_of(at, draws(at))
            total += self.fit.projected(part.reshape(len(part), -1), self.c.shape[0] - 1, at)
        return total.reshape(self.c.size, -1)

    def pool(self, roots: Sequence[ComplexArray]) -> None:
        """Let the zeros of all rows tell how much repeats of the test scatter beyond what is inside each."""
        if self._sums is None:
            return
        light = [s[(s.imag > 0.0) & (np.abs(s.real) <= WIDEST * np.abs(s))] for s in roots]
        both = [self.variances(row, s) for row, s in enumerate(light) if s.size]
        within, between = np.concatenate([np.empty((2, 0)), *map(np.stack, both)], axis=1)
        self._excess = excess(between, within, self._sums.shape[1])

    def standard_deviations(
        self, row: int | FloatArray, s: ComplexArray, means: FloatArray | None = None
    ) -> FloatArray:
        """Standard deviation in Hz of zeros ``s`` (rad/s) of one row, or of a weighted sum of all rows.

        With ``means`` (n_means, n_zeros) those of such means of the zeros.
        """
        within, between = self.variances(row, s, means)
        if self._sums is not None:
            within = combined(between, within, self._sums.shape[1], self._excess)
        return np.asarray(np.sqrt(within))

    def variances(
        self, row: int | FloatArray, s: ComplexArray, means: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Variances in Hz^2 from the scatter inside the draws, and from that between them (0 for one)."""
        slope = self._slopes(row, s)
        if means is not None:
            s, slope = means @ s, means @ slope
        by_size = (slope * s.conj()[:, None]).real / np.abs(s)[:, None]
        flat = by_size @ self._vectors
        moves = (flat * self._inverse) @ self._vectors.T / (2 * np.pi)
        within = self._scale * np.sum((moves @ self._push) ** 2, axis=1)
        if self._sums is None:
            return within, np.zeros(s.size)
        n = self._sums.shape[1]
        return within, n / (n - 1.0) * np.sum((moves @ self._sums) ** 2, axis=1)

    def _slopes(self, row: int | FloatArray, s: ComplexArray) -> ComplexArray:
        """Derivatives of zeros of one row, or of a weighted sum, by the unknowns, (n_zeros, n_unknowns)."""
        weights = np.eye(self.c.shape[1])[row] if isinstance(row, int) else row
        slope = self.fit.slopes(self.c @ weights, s)
        return np.asarray((slope[:, :, None] * weights).reshape(s.size, self.c.size))


# -- Whether the fit predicts what it has not seen, to the noise that the segments tell

#: Lines that are looked at, parts of the band, and the largest misfit of a part over what noise makes of it.
LINES_AHEAD, PARTS, LARGEST_AHEAD = 1200, 8, 2.5
LEAST_SEGMENTS = 4  # segments without which halves tell nothing
CLEAN = 3e4  # signal-to-noise power at the median line from which few impacts are as good as curves


def misfit_ahead(cuts: Sequence[tuple[Lines, Likeliest]]) -> float:
    """Misfit of held-back segments to the numerators of the others, in the band's worst part.

    ``cuts`` are the lines of each window and their fit, which gives order and weights. One is what noise
    makes of it: the directions of the held-back half scatter by (n - 1) / (K SNR) in power, K its independent
    averages.
    """
    off = np.concatenate([_off(lines, best) for lines, best in cuts])
    parts = (float(np.median(part)) for part in np.array_split(off, PARTS) if part.size)
    return max(parts, default=np.inf)


def _off(lines: Lines, best: Likeliest) -> FloatArray:
    """Squared distance of held-back directions from a fit to the others, over that of noise, by line."""
    assert lines.segments is not None
    part = slice(None, None, -(-lines.freq_hz.size // LINES_AHEAD))
    x = lines.segments.at(part)
    halves = (np.ascontiguousarray(x[..., first::2]) for first in (0, 1))
    fitted, held = (half @ half.conj().transpose(0, 2, 1) / half.shape[2] for half in halves)
    unit = np.ones(x.shape[1])
    top, weights = dominant(fitted, unit)[0], best.fit.weights[part]
    fit = NumeratorFit(lines.freq_hz[part], fitted.__getitem__, top, weights, best.order)
    n = fit.values(fit.likeliest(best.order)[0])
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    largest, rest, v = dominant(held.conj(), unit)
    snr = largest / np.maximum(rest, 1e-12 * largest)
    count = x.shape[2] // 2 / lines.averages_ratio / max(n.shape[1] - 1, 1)
    distance = 1.0 - np.abs(np.sum(n.conj() * v, axis=1)) ** 2
    told = lines.snr[part] >= lines.least_snr
    return np.asarray(distance * snr / (1.0 + snr / SNR_CAP) * count)[told]

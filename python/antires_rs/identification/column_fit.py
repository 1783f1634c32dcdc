r"""Several forces: the columns of their receptances as polynomials, fitted to the subspace of the responses.

Under r forces the responses at a line span the columns of H_J = N(s) D(s)^-1: N (n, r) of polynomials, known
up to a factor N R from the right. With the dominant subspace U (n, r) of a line, in units of equal noise, and
its eigenvalues l, the fit that uses all the record tells (Viberg and Ottersten) has the least

    Q(N) = sum_f tr(P U W U'),    P = I - N (N'N)^-1 N',    W = diag((l - 1)^2 / l).

Its unknowns are those of the subspace. Fits of the minors as independent polynomials have several times as
many, for what is noise in one is not in all: their zeros scattered 3 to 30 times as much.

*Start.* With one weight a line, sum_f w N'(I - U U')N is quadratic in each column, and the r vectors of least
misfit serve, of every degree from one Cholesky factor. *Refined*: with B = N^+ U a change dN moves P U by
-P dN B, so that the steps of Gauss and Newton solve

    A dN = sum_f phi' P~ U W B',    A = sum_f phi' phi (B W B')' x P,

x the product of Kronecker, damped (Levenberg and Marquardt) and orthogonal to N R. *Zeros* are those of the
minors det N[I, :], polynomials of degree r m if the columns have degree m. Their slopes by N are cofactors,
so A tells their errors (:class:`MinorInfluence`): with du = P x (x' u_j) / (l_j - 1) of every segment x.

*Leakage.* A window puts shares g_k of a line's power k lines further, so that S_f has the columns of its
neighbours: L = sum_k g_k S_{f+k}, the same in every segment, of which no scatter tells. With
S_{f+k} = N B diag(l - 1) B' N' of a first fit what lies outside the columns, L - (I - P) L (I - P), is taken
out of S before the last one. Zeros of frames were off by up to two standard deviations, and of three forces
without noise by more. What scatters of it alternates from one overlapping segment to the next, so that it
averages out sooner than noise, which their correlation tells.

Sources: M. Viberg and B. Ottersten, IEEE Trans. Signal Process. 39 (1991) 1110-1121 (weighted subspace
fitting); D. W. Marquardt, J. SIAM 11 (1963) 431-441.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..support.checks import ComplexArray, FloatArray
from .lines import Lines
from .minors import MinorLines, Subspaces, minors_of
from .numerators import (
    FIRST_LOOK,
    HIGH,
    KNEE,
    LEAST_SIZE,
    Influence,
    Likeliest,
    NumeratorFit,
    form_of,
    solved,
)

SEARCH_LINES = 600  # so many tell the degree
PASSES = 5  # of inverse iteration, for the vectors of least misfit
STEPS, SETTLED = 10, 1e-2  # damped steps of a search, and the relative gain at which they end
LAST_STEPS, LAST_SETTLED = 20, 1e-6  # of the last fit
FIRST_STEPS = 2  # tell whether one more degree gains
DAMPING, LESS, MORE, LEAST_DAMPING, MOST_DAMPING = 1e-8, 0.05, 20.0, 1e-13, 1e6  # shares of the diagonal
LEAST_DIAGONAL = 1e-3  # of its mean
PATIENCE = 2  # degrees without gain after which none is looked for
LOOSE = 0.1  # share of all coefficients that noise moves a direction by, from which it is not linear
HIGHER = 16  # degrees above the likeliest over which roots are followed


class ColumnFit(NumeratorFit):
    """Polynomial columns of every degree to ``max_degree``; orders are those of their minors, ``rows``.

    Starts and sweep are fitted to the subspaces ``shown``, by default as measured, what is refined to these.
    """

    def __init__(
        self,
        seen: Subspaces,
        size: FloatArray,
        rows: NDArray[np.intp],
        max_degree: int,
        lines: slice,
        shown: ComplexArray | None = None,
    ) -> None:
        self._basis, self._worth = seen.vectors[lines, :, : seen.order], seen.worth[lines]
        self._above = seen.above[lines]
        self.step, self.n, self._rows = seen.order, len(rows), rows
        weights = self._worth[:, -1] / np.maximum(size, LEAST_SIZE * size.max())
        self._lay(seen.freq_hz[lines], weights, self.step * max_degree, max(2, self.step) * max_degree)
        ones = np.ones(len(weights))
        span = self._basis if shown is None else shown

        def projector(some: slice) -> ComplexArray:
            return np.asarray(span[some] @ span[some].conj().transpose(0, 2, 1))

        form = form_of(self.whole, self.weights, projector, ones, max_degree + 1)
        self._factor(form, self._basis.shape[1])
        self.columns = np.empty(0)  # those from which higher orders start

    def start(self, degree: int) -> FloatArray:
        """Columns (degree + 1, n, r) of least misfit under one weight a line."""
        n = self._basis.shape[1]
        size = n * (degree + 1)
        root = self._upper[:, :size]
        c = np.linalg.qr(self._first[:size])[0]
        for _ in range(PASSES):
            c = solved(root, solved(root, np.asfortranarray(c)), transposed=True)
            c = np.linalg.qr(c)[0]
        lower = np.tril(self.form[:size, :size])
        _, turn = np.linalg.eigh(
            c.T @ (lower @ c) + (lower.T @ c).T @ c - c.T @ (np.diag(lower)[:, None] * c)
        )
        return np.asarray(c @ turn[:, : self.step]).reshape(degree + 1, n, self.step)

    def low(self, order: int) -> FloatArray:
        """Coefficients of the minors of the columns with the largest lowest coefficients."""
        n = self._basis.shape[1]
        size = n * (order // self.step + 1)
        first = self._first[:size]
        best = np.linalg.eigh(first.T @ first)[1][:, -self.step :]
        c = solved(self._upper[:, :size], first @ best, transposed=True)
        return self.minors(_orthonormal(c.reshape(-1, n, self.step)))

    def likeliest(self, *orders: int) -> list[FloatArray]:
        """Coefficients of the minors, of every order, from the columns that are known."""
        found = []
        for order in orders:
            columns = self.padded(self.columns, order // self.step)
            found.append(self.minors(self.refined(columns, STEPS, SETTLED)[0]))
        return found

    def padded(self, columns: FloatArray, degree: int) -> FloatArray:
        """The same columns with coefficients for a higher degree."""
        return np.concatenate([columns, np.zeros((degree + 1 - len(columns), *columns.shape[1:]))])

    def minors(self, columns: FloatArray) -> FloatArray:
        """Coefficients (order + 1, n_minors) of the minors of columns."""
        order = self.step * (len(columns) - 1)
        return self.projected(minors_of(self.on_lines(columns), self._rows), order, slice(None))

    def on_lines(self, columns: FloatArray) -> ComplexArray:
        """N at the lines, (n_freq, n, r)."""
        return self.values(columns.reshape(len(columns), -1)).reshape(-1, *columns.shape[1:])

    def state(self, columns: FloatArray) -> _State:
        """What columns leave of the subspaces."""
        n = self.on_lines(columns)
        across = n.conj().transpose(0, 2, 1)
        try:
            inverse = np.linalg.solve(across @ n, across)
        except np.linalg.LinAlgError:  # columns that are dependent at a line span nothing there
            none = np.zeros_like(across)
            return _State(n, none, none @ self._basis, self._basis, np.inf)
        b = inverse @ self._basis
        left = self._basis - n @ b
        misfit = float(np.sum(np.sum(np.abs(left) ** 2, axis=1) * self._worth))
        return _State(n, np.asarray(inverse, dtype=np.complex128), b, left, misfit)

    def information(self, state: _State, terms: int) -> FloatArray:
        """A, (n_unknowns, n_unknowns)."""
        n_lines, n, order = state.n.shape
        worth = (state.b * self._worth[:, None]) @ state.b.conj().transpose(0, 2, 1)
        worth /= self.weights[:, None, None]

        def covariance(some: slice) -> ComplexArray:
            project = state.n[some] @ state.inverse[some] - np.eye(n)
            both = project[:, :, None, :, None] * worth[some].transpose(0, 2, 1)[:, None, :, None, :]
            return np.asarray(both.reshape(-1, n * order, n * order))

        lower = form_of(self.whole, self.weights, covariance, np.zeros(n_lines), terms)
        return np.asarray(np.tril(lower) + np.tril(lower, -1).T)

    def refined(self, columns: FloatArray, steps: int, settled: float) -> tuple[FloatArray, float]:
        """Columns of least Q from these on, and Q."""
        columns = _orthonormal(columns)
        terms, n, order = columns.shape
        now, damping = self.state(columns), DAMPING
        for _ in range(steps):
            a = self.information(now, terms)
            left = (now.left * self._worth[:, None]) @ now.b.conj().transpose(0, 2, 1)
            left /= self.weights[:, None, None]
            pull = self.projected(left.reshape(len(left), -1), terms - 1, slice(None)).ravel()
            free = np.einsum("kpa,bc->kpbac", columns, np.eye(order)).reshape(a.shape[0], -1)
            diagonal = np.diag(a).copy()
            middle = float(diagonal.mean())
            diagonal = np.maximum(diagonal, LEAST_DIAGONAL * middle)
            a += middle * free @ free.T
            better = None
            while damping <= MOST_DAMPING:
                damped = a.copy()
                damped.flat[:: len(a) + 1] += damping * diagonal
                moved = _orthonormal(columns + np.linalg.solve(damped, pull).reshape(columns.shape))
                better = self.state(moved)
                if better.misfit <= now.misfit:
                    break
                better, damping = None, max(damping * MORE, 1e-10)
            if better is None:
                break
            gain = 1.0 - better.misfit / max(now.misfit, 1e-300)
            columns, now, damping = moved, better, max(damping * LESS, LEAST_DAMPING)
            if gain < settled:
                break
        return columns, now.misfit

    def without_leakage(self, seen: Subspaces, shares: FloatArray, columns: FloatArray) -> None:
        """Take out what the window leaks into the spectra from lines beside, as these columns tell it.

        ``shares`` are those of the power that go to the next line, the one after it, ... to either side.
        """
        state, power = self.state(columns), self._above[:, None] * seen.floor[:, None, None]
        signal = (state.b * power) @ state.b.conj().transpose(0, 2, 1)
        spacing_hz = float(np.diff(seen.freq_hz).min())
        of_columns = np.zeros((*state.n.shape[:2], state.n.shape[1]), dtype=np.complex128)
        for k, share in enumerate(shares.tolist(), 1):
            # Of one neighbour alone, at an end of the band or beside hum, the slope would rule.
            both = seen.freq_hz[2 * k :] - seen.freq_hz[: -2 * k] < (2 * k + 0.5) * spacing_hz
            for there in (slice(2 * k, None), slice(-2 * k)):
                n = (share * both)[:, None, None] * state.n[there]
                of_columns[k:-k] += n @ signal[there] @ state.n[there].conj().transpose(0, 2, 1)
        inside = state.n @ state.inverse
        of_columns = (of_columns - inside @ of_columns @ inside) / seen.floor[:, None, None]
        matrix = (seen.vectors * seen.values[:, None]) @ seen.vectors.conj().transpose(0, 2, 1) - of_columns
        self._basis = np.linalg.eigh(matrix)[1][:, :, : -self.step - 1 : -1]


@dataclass(frozen=True)
class _State:
    """N at the lines, N^+, B, P U and Q."""

    n: ComplexArray
    inverse: ComplexArray
    b: ComplexArray
    left: ComplexArray
    misfit: float


def _orthonormal(columns: FloatArray) -> FloatArray:
    """The same span."""
    return np.asarray(np.linalg.qr(columns.reshape(-1, columns.shape[2]))[0]).reshape(columns.shape)


@dataclass(frozen=True)
class LikeliestColumns(Likeliest):
    """With the ``columns`` whose minors have the coefficients."""

    columns: FloatArray

    def influence(self, lines: Lines) -> Influence:
        """What the draws of these lines would move the zeros of minors by."""
        return MinorInfluence(self, lines)


def likeliest_columns(lines: MinorLines, max_order: int) -> LikeliestColumns:
    """Degree and columns together, by the criterion of the numerators of one force."""
    seen, rows = lines.subspaces, lines.rows
    n, order = seen.vectors.shape[1], seen.order
    count = len(seen.freq_hz)
    step = max(1, count // SEARCH_LINES)
    some = slice(step // 2, None, step)
    data = 2.0 * order * (n - order) * len(seen.freq_hz[some]) * min(1.0, lines.independent * step)
    most = max_order // order
    top = min(most, FIRST_LOOK // order)
    size = np.ones(len(seen.freq_hz[some]))
    while True:
        search = _Search(ColumnFit(seen, size, rows, top, some), data)
        degree = search.likeliest(top)
        if degree <= HIGH * top or top == most:
            break
        top = min(2 * top, most)
    # The subspaces as fitted have hardly any noise, so that starts of a lower degree that serves are good.
    fit, columns = search.fit, search.tried[degree][1]
    shown = fit.on_lines(columns)
    size = np.sum(np.abs(shown) ** 2, axis=(1, 2))
    again = _Search(ColumnFit(seen, size, rows, degree, some, np.linalg.qr(shown)[0]), data)
    lower = again.likeliest_below(search.tried[degree])
    if lower is not None:
        fit, columns = again.fit, again.tried[lower][1]
    degree = len(columns) - 1
    # The same columns on all lines:
    at = fit.basis.at(np.asarray(1j * seen.freq_hz / fit.scale_hz, dtype=np.complex128), degree)
    n_at = at @ columns.reshape(degree + 1, -1)
    size = np.sum(np.abs(n_at) ** 2, axis=1)
    most = min(most, degree + HIGHER)
    last = ColumnFit(seen, size, rows, most, slice(None))
    columns = last.projected(n_at, degree, slice(None)).reshape(columns.shape)
    last.without_leakage(seen, lines.leakage, columns)
    columns, misfit = last.refined(columns, LAST_STEPS, LAST_SETTLED)
    # All lines tell of more degrees than some did; roots move by those that are left out.
    data = 2.0 * order * (n - order) * count * min(1.0, lines.independent)
    while degree < most:
        more, less = last.refined(last.padded(columns, degree + 1), FIRST_STEPS, LAST_SETTLED)
        if criterion(less, more, data) >= criterion(misfit, columns, data):
            break
        columns, misfit = last.refined(more, LAST_STEPS, LAST_SETTLED)
        degree += 1
    last.columns = columns
    return LikeliestColumns(last, order * degree, last.minors(columns), misfit, columns)


def criterion(misfit: float, columns: FloatArray, data: float) -> float:
    """Of Schwarz, of columns that leave so much of so many independent data."""
    terms, n, order = columns.shape
    free = order * (n - order) * terms
    return float(max(data - free, 1.0) * np.log(max(misfit, 1e-300)) + free * np.log(data))


class _Search:
    """Degrees that were tried: their criterion and columns."""

    def __init__(self, fit: ColumnFit, data: float) -> None:
        self.fit, self.data = fit, data
        self.tried: dict[int, tuple[float, FloatArray]] = {}

    def judged(self, degree: int) -> float:
        """The criterion of a degree."""
        if degree not in self.tried:
            columns = self.fit.start(degree)
            if degree - 1 in self.tried:  # whose columns are among those of this degree
                before = self.fit.padded(self.tried[degree - 1][1], degree)
                columns = min(columns, before, key=lambda one: self.fit.state(one).misfit)
            columns, q = self.fit.refined(columns, STEPS, SETTLED)
            self.tried[degree] = (criterion(q, columns, self.data), columns)
        return self.tried[degree][0]

    def likeliest(self, top: int) -> int:
        """The likeliest degree: first between none and the knee of the starts, then about what is found."""
        high, low = self._knee(range(1, top + 1, 2)), 0
        while high - low > 1:
            middle = (low + high) // 2
            if self.judged(middle) <= self.judged(high):
                high = middle
            else:
                low = middle
        return self._about(high, top)

    def likeliest_below(self, known: tuple[float, FloatArray]) -> int | None:
        """The likeliest degree below that of the columns ``known``; None if it is less likely than they."""
        top = len(known[1]) - 2
        if top < 1:
            return None
        best = self._about(self._knee(range(1, top + 1)), top)
        return best if self.judged(best) < known[0] else None

    def _knee(self, degrees: range) -> int:
        """The lowest degree whose start misses little more than the best."""
        q = np.array([self.fit.state(self.fit.start(degree)).misfit for degree in degrees])
        return degrees[int(np.argmax(q <= KNEE * q.min()))]

    def _about(self, best: int, top: int) -> int:
        """The likeliest degree, looked for from one on to either side."""
        self.judged(best)
        for way, patience in ((1, PATIENCE), (-1, 1)):
            degree, idle = best, 0
            while idle < patience and 1 <= degree + way <= top:
                degree += way
                idle = 0 if self.judged(degree) < self.judged(best) else idle + 1
                best = degree if idle == 0 else best
        return best


class MinorInfluence(Influence):
    """Derivatives of zeros of the minors by what the segments are.

    Directions that noise moves by ``LOOSE`` of all coefficients are those of a factor that all minors share.
    """

    def __init__(self, best: Likeliest, lines: Lines) -> None:
        super().__init__(best, lines)
        pushed = self._scale * np.sum((self._vectors.T @ self._push) ** 2, axis=1)
        self._inverse[np.sqrt(pushed) * self._inverse > LOOSE] = 0.0
        assert isinstance(lines, MinorLines)
        if self._sums is None and lines.overlapping:
            self._scale *= self._together(lines.overlapping) / lines.averages_ratio
        # What is left beyond noise, as by leakage, adds to the errors as to the misfit.
        by_noise = lines.subspaces.by_noise(slice(None), lines.averages_ratio)
        self._scale *= max(1.0, best.misfit / by_noise)

    def _together(self, overlapping: int) -> float:
        """Variance of a sum over all segments, over that of as many independent ones.

        By the correlation of segments with the next ones, the mean of all directions: what a window leaks at
        the end of one it takes back at the begin of another, so that leakage averages out sooner than noise.
        """
        pushed = self._vectors[:, self._inverse > 0.0].T @ self._push
        pushed /= np.linalg.norm(pushed, axis=1, keepdims=True)
        count = pushed.shape[1]
        by_mean = 1.0 / count  # that was taken away
        both = [np.mean(np.sum(pushed[:, :-k] * pushed[:, k:], axis=1)) for k in range(1, overlapping + 1)]
        return float(max(1.0 + 2.0 * sum(one + by_mean for one in both), by_mean))

    def _unknowns(self, best: Likeliest) -> tuple[FloatArray, FloatArray, float]:
        assert isinstance(best, LikeliestColumns)
        assert isinstance(best.fit, ColumnFit)
        self._columns, self._minors = best.columns, best.coefficients
        terms = len(best.columns)
        state = best.fit.state(best.columns)
        self._state, self._rows = state, best.fit._rows
        return best.columns.reshape(terms, -1), best.fit.information(state, terms), 0.0

    def _push_of(self, at: slice, x: ComplexArray) -> ComplexArray:
        """P x (x' u_j) / (l_j - 1), weighted, (n_lines, n_columns, n_draws)."""
        fit, state = self.fit, self._state
        assert isinstance(fit, ColumnFit)
        across = x - state.n[at] @ (state.inverse[at] @ x)
        along = (fit._basis[at].conj().transpose(0, 2, 1) @ x).conj()
        along = (
            state.b[at].conj() * (fit._worth[at] / fit._above[at] / fit.weights[at, None])[:, None, :]
        ) @ along
        return np.asarray(across[:, :, None, :] * along[:, None, :, :]).reshape(len(x), -1, x.shape[2])

    def _slopes(self, row: int | FloatArray, s: ComplexArray) -> ComplexArray:
        assert isinstance(row, int)
        u = s / (2 * np.pi * self.fit.scale_hz)
        terms, n, order = self._columns.shape
        at = self.fit.basis.at(u, terms - 1)
        own = self._rows[row]
        matrix = (at @ self._columns[:, own].reshape(terms, -1)).reshape(-1, order, order)
        change = self.fit.changes(self._minors[:, row], u)
        slopes = np.zeros((s.size, terms, n, order), dtype=np.complex128)
        for i, p in enumerate(own):
            for j in range(order):
                left = np.delete(np.delete(matrix, i, axis=1), j, axis=2)
                cofactor = (-1.0) ** (i + j) * np.linalg.det(left)
                slopes[:, :, p, j] = -at * (cofactor / change)[:, None] * (2 * np.pi * self.fit.scale_hz)
        return slopes.reshape(s.size, terms * n * order)

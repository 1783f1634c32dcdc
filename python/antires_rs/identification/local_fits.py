r"""Local fits of the direction of the responses, many at a time.

Under one force the responses at a line are x = a N(f): N is a vector of numerators, the factor a holds force
and resonances. Over a short stretch of lines N is a vector of complex polynomials, N(f) = sum_i c_i P_i(f),
and the direction v = x / abs(x) tells it up to a factor a line:

    minimize sum_f w_f [ N' N - abs(v' N)^2 ] / (N' N)

With 1 / N'N taken from the fit before, and polynomials that are orthonormal for these weights, it is the
smallest eigenvalue of I - A' A, where A has a row sqrt(w) P_i conj(v) for each line. Degrees are in
ascending order, so that one Cholesky factor serves every order. Zeros of N_p near the axis are antiresonances
of response p. Nothing of the structure outside the stretch has to be modelled.

Noise is not asked to be white over the band, nor of rank one to be right at lines far away: what holds for
records that somebody measured.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from ..support.checks import ComplexArray, FloatArray

#: (highest over lowest frequency, least number of lines, orders) of the stretches of each scale.
SCALES = ((2.2, 48, (4, 6, 8)), (1.5, 48, (3, 4, 6)), (1.25, 40, (2, 3, 5)))
#: Stretches of one scale that cover a frequency, and the share that the band must leave of one.
OVERLAP, LEAST_SHARE = 4, 0.6
MOST_LINES, LEAST_LINES = 96, 16  # lines of a stretch that are fitted: more tell hardly more of a few zeros
MOST_DIRECTIONS = 5  # directions of the channels that a fit keeps: polynomials of order m span at most m + 1
PASSES = 3  # passes of "weights from the fit before"
#: Inverse iterations to the smallest eigenvalue, so many that where they began has hardly any part in it,
#: and what keeps exact data from being singular.
ITERATIONS, RIDGE = 20, 1e-11
LEAST_SIZE = 1e-6  # least squared size of N over the largest of the stretch
AT_A_TIME = 1 << 21  # numbers that are worked on at a time


@dataclass(frozen=True)
class Stretch:
    """Lines of one local fit: indices of those fitted, (n_fitted,), and the edges in Hz."""

    lines: NDArray[np.intp]
    low_hz: float
    high_hz: float

    @property
    def middle_hz(self) -> float:
        """Its middle."""
        return 0.5 * (self.low_hz + self.high_hz)


def stretches(freq_hz: FloatArray, ratio: float, least: int) -> list[Stretch]:
    """All stretches of one scale, on a grid that depends on the spacing of the lines and not on the band."""
    spacing = float(np.median(np.diff(freq_hz)))
    edges = [0.0]
    while edges[-1] < freq_hz[-1] * ratio:
        edges.append(max(edges[-1] * ratio ** (1.0 / OVERLAP), edges[-1] + least * spacing / OVERLAP))
    found = []
    for low, high in zip(edges[:-OVERLAP], edges[OVERLAP:], strict=True):
        kept = min(high, freq_hz[-1]) - max(low, freq_hz[0])
        first, last = np.searchsorted(freq_hz, (low, high))
        if kept >= LEAST_SHARE * (high - low) and last - first >= max(LEAST_LINES, least // 2):
            found.append(_stretch(freq_hz, int(first), int(last)))
    return found or [_stretch(freq_hz, 0, freq_hz.size)]


def around(freq_hz: FloatArray, value_hz: float, ratio: float, least: int) -> Stretch:
    """The stretch of a scale with this value in its middle, as far as the band reaches."""
    half = max(value_hz * (np.sqrt(ratio) - 1.0), 0.5 * least * float(np.median(np.diff(freq_hz))))
    first, last = np.searchsorted(freq_hz, (value_hz - half, value_hz + half))
    return _stretch(freq_hz, int(first), max(int(last), int(first) + 2))


def _stretch(freq_hz: FloatArray, first: int, last: int) -> Stretch:
    step = max(1, (last - first) // MOST_LINES)
    return Stretch(
        np.arange(first, last)[(last - first - 1) % step // 2 :: step],
        float(freq_hz[first]),
        float(freq_hz[last - 1]),
    )


@dataclass(frozen=True)
class LocalFits:
    """Fits of one stretch to several vectors: coefficients of Chebyshev polynomials by order.

    ``by_order`` has arrays (n_views, order + 1, n_rows); ``fitted`` is the direction that the middle order of
    the first view gives at the stretch's lines, (n_fitted, n_rows), of unit norm. ``misfit`` is what is left
    of each view, (n_views,), by order, as a share.
    """

    stretch: Stretch
    by_order: dict[int, ComplexArray]
    fitted: ComplexArray
    misfit: dict[int, FloatArray]

    def zeros(self, order: int, rows: list[int]) -> ComplexArray:
        """Zeros in Hz of some rows, complex: Im / abs is the damping ratio, (n_views, n_rows, order)."""
        c = self.by_order[order][:, :, rows].transpose(0, 2, 1)
        half = 0.5 * (self.stretch.high_hz - self.stretch.low_hz)
        return np.asarray(self.stretch.middle_hz + half * chebyshev_roots(c))


def fits(
    over: Sequence[Stretch],
    freq_hz: FloatArray,
    vectors: Sequence[ComplexArray],
    weights: FloatArray,
    orders: tuple[int, ...],
) -> list[LocalFits]:
    """Fit vectors (n_views, n_fitted, n_rows), unit or zero, over stretches, with the first one's weights."""
    numbers = max(own.size for own in vectors) * (orders[-1] + 1)
    count = max(1, AT_A_TIME // numbers)
    if len(over) > count:
        cuts = [slice(k, k + count) for k in range(0, len(over), count)]
        return [one for some in cuts for one in fits(over[some], freq_hz, vectors[some], weights, orders)]
    longest = max(one.lines.size for one in over)
    n_views, _, n_rows = vectors[0].shape
    v = np.zeros((len(over), n_views, longest, n_rows), dtype=np.complex128)
    w, powers = np.zeros((len(over), longest)), np.zeros((len(over), longest, orders[-1] + 1))
    for b, (one, own) in enumerate(zip(over, vectors, strict=True)):
        x = (freq_hz[one.lines] - one.middle_hz) / (0.5 * (one.high_hz - one.low_hz))
        v[b, :, : x.size], w[b, : x.size] = own, weights[one.lines]
        powers[b, : x.size] = chebyshev.chebvander(x, orders[-1])
    kept = min(n_rows, MOST_DIRECTIONS)
    held = np.linalg.eigh((v * w[:, None, :, None]).transpose(0, 1, 3, 2) @ v.conj())[1][..., -kept:]
    u = v @ held.conj()
    size = np.ones(w.shape)
    middle = orders[len(orders) // 2]
    for _ in range(PASSES):
        root = np.sqrt(w / size)[..., None]
        q, _ = np.linalg.qr(root * powers)
        ((c, _),) = _smallest(q, u[:, :1], held[:, :1], (middle,))
        values = (q[..., : middle + 1] @ c[:, 0]) / np.where(root > 0.0, root, np.inf)
        size = np.sum(np.abs(values) ** 2, axis=2)
        size = np.maximum(size, LEAST_SIZE * size.max(axis=1, keepdims=True))
    fitted = values / np.sqrt(np.maximum(np.sum(np.abs(values) ** 2, axis=2), 1e-300))[..., None]
    fitted = fitted @ held[:, 0].transpose(0, 2, 1)
    q, r = np.linalg.qr(np.sqrt(w / size)[..., None] * powers)
    solved = np.linalg.inv(r)
    by_order, misfit = {}, {}
    for m, (c, misfit[m]) in zip(orders, _smallest(q, u, held, orders), strict=True):
        by_order[m] = solved[:, None, : m + 1, : m + 1] @ c @ held.transpose(0, 1, 3, 2)
    return [
        LocalFits(
            one,
            {m: c[b] for m, c in by_order.items()},
            fitted[b, : one.lines.size],
            {m: left[b] for m, left in misfit.items()},
        )
        for b, one in enumerate(over)
    ]


def _smallest(
    q: FloatArray, u: ComplexArray, held: ComplexArray, orders: tuple[int, ...]
) -> list[tuple[ComplexArray, FloatArray]]:
    """Coefficients (n_stretches, n_views, order + 1, n_directions) of least misfit, and it, by order."""
    *shape, n_lines, n = u.shape
    terms = orders[-1] + 1
    a = (q[:, None, :, :terms, None] * u.conj()[..., None, :]).reshape(*shape, n_lines, terms * n)
    form = np.eye(terms * n) * (1.0 + RIDGE) - a.conj().swapaxes(-1, -2) @ a
    inverse = np.linalg.inv(np.linalg.cholesky(form))
    # From the same numerators whatever signs the eigenvectors have, which rounding may change.
    begin = np.exp(1j * np.arange(terms * held.shape[-2])).reshape(terms, -1) @ held.conj()
    found = []
    for m in orders:
        size = (m + 1) * n
        low = inverse[..., :size, :size]
        adjoint = low.conj().swapaxes(-1, -2)
        c = begin[..., : m + 1, :].reshape(*shape, size, 1)
        for _ in range(ITERATIONS):
            c = adjoint @ (low @ c)
            c = c / np.linalg.norm(c, axis=-2, keepdims=True)
        left = np.sum(c.conj() * (form[..., :size, :size] @ c), axis=(-2, -1)).real
        found.append((c.reshape(*shape, m + 1, n), left))
    return found


def chebyshev_roots(c: ComplexArray) -> ComplexArray:
    """Roots of Chebyshev series, (..., m + 1) -> (..., m); those at infinity stand far outside."""
    m = c.shape[-1] - 1
    top = c[..., -1:]
    least = 1e-12 * np.abs(c).max(axis=-1, keepdims=True)
    top = np.where(np.abs(top) > least, top, least + 1e-300)
    colleague = np.zeros((*c.shape[:-1], m, m), dtype=np.complex128)
    colleague[..., np.arange(1, m), np.arange(m - 1)] = 0.5
    colleague[..., np.arange(m - 1), np.arange(1, m)] = 0.5
    if m > 1:
        colleague[..., 0, 1] = 1.0
        colleague[..., -1, :] -= 0.5 * c[..., :-1] / top
    else:
        colleague[..., 0, 0] = -(c[..., 0] / top[..., 0])
    return np.asarray(np.linalg.eigvals(colleague), dtype=np.complex128)

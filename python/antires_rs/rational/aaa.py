r"""AAA for many curves at once: barycentric rational functions with common poles.

r_o(z) = sum_k w_k Y_o(z_k) / (z - z_k)  /  sum_k w_k / (z - z_k): with lines z_k as supports, one set of
barycentric weights w_k for all outputs o. The next support is the line of largest misfit; then w is the right
singular vector, for the smallest singular value, of the Loewner matrices of all outputs on the other lines,
one under the other. Lines carry the weights of the fit, so that noise attracts no supports. The poles are
those of an arrowhead pencil.

References: Y. Nakatsukasa, O. Sete and L. N. Trefethen, SIAM J. Sci. Comput. 40 (2018) A1494-A1522;
P. Lietaert, K. Meerbergen, J. Perez and B. Vandereycken, IMA J. Numer. Anal. 42 (2022) 1087-1115
(set-valued).
"""

from __future__ import annotations

import numpy as np

from ..support.validation import ComplexArray, FloatArray
from .dominance import share_of_curve

__all__ = ["set_valued_aaa"]

#: Weighted misfit over the weighted norm of the data at which exact data are exhausted.
EXHAUSTED = 1e-12


def set_valued_aaa(
    freq_hz: FloatArray, values: ComplexArray, weights: FloatArray, n_poles: int
) -> tuple[ComplexArray, FloatArray]:
    """Poles of the outputs and how much of the curves each owns.

    Parameters
    ----------
    freq_hz : (n_freq,)
    values : (n_outputs, n_freq) complex
    weights : (n_freq,)
        Of squared residuals.
    n_poles : int
        Most poles, less than ``n_freq``. There are fewer once the misfit is nil.

    Returns
    -------
    s : (n,) complex, rad/s
        Poles in the upper half plane; those below stand for nothing, as only positive frequencies are used.
    dominance : (n,)
        Norm of its residues over ``abs(Re s)``, over the norm of the fitted curves at its frequency.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.rational.aaa import set_valued_aaa
    >>> f = np.linspace(1.0, 20.0, 200)
    >>> y = 1.0 / (5**2 - f**2 + 0.1j * f) - 1.0 / (10**2 - f**2 + 0.2j * f)
    >>> s, dominance = set_valued_aaa(f, y[None, :], np.ones(200), 4)
    >>> strong = dominance > 0.3
    >>> np.sort(np.abs(s[strong]) / (2 * np.pi)).round(6).tolist()
    [5.0, 10.0]
    """
    z = 1j * freq_hz / freq_hz[-1]
    root = np.sqrt(weights / weights.sum())
    size = float(np.linalg.norm(root * values))
    rest = np.ones(z.size, dtype=bool)
    fitted = np.repeat(values.mean(axis=1, keepdims=True), z.size, axis=1)
    supports: list[int] = []
    w = np.empty(0, dtype=np.complex128)
    for _ in range(n_poles + 1):
        misfit = np.where(rest, root * np.linalg.norm(values - fitted, axis=0), 0.0)
        if np.linalg.norm(misfit) <= EXHAUSTED * size:
            break
        supports.append(int(np.argmax(misfit)))
        rest[supports[-1]] = False
        cauchy = 1.0 / (z[rest, None] - z[supports])
        weighed = root[rest, None] * cauchy
        loewner = np.concatenate([weighed * (y[rest, None] - y[supports]) for y in values])
        w = np.linalg.svd(np.linalg.qr(loewner, mode="r"))[2][-1].conj()
        fitted = values.copy()
        fitted[:, rest] = ((cauchy @ (w[:, None] * values[:, supports].T)) / (cauchy @ w)[:, None]).T
    poles = _poles(z[supports], w)
    return poles * (2 * np.pi * freq_hz[-1]), _dominance(z[supports], values[:, supports].T, w, poles)


def _poles(supports: ComplexArray, w: ComplexArray) -> ComplexArray:
    """Finite eigenvalues of the arrowhead pencil that lie above the real axis."""
    from scipy.linalg import eigvals  # slow to import

    m = supports.size
    if m < 2:
        return np.empty(0, dtype=np.complex128)
    arrow, unit = np.zeros((m + 1, m + 1), dtype=np.complex128), np.eye(m + 1)
    unit[0, 0] = 0.0
    arrow[0, 1:], arrow[1:, 0] = w, 1.0
    arrow[1:, 1:] = np.diag(supports)
    with np.errstate(divide="ignore", invalid="ignore"):  # two eigenvalues are infinite by construction
        found = eigvals(arrow, unit)
    found = found[np.isfinite(found)]
    return np.asarray(found[found.imag > 0.0], dtype=np.complex128)


def _dominance(
    supports: ComplexArray, values: ComplexArray, w: ComplexArray, poles: ComplexArray
) -> FloatArray:
    """Residue = numerator over the slope of the denominator; ``values`` are (n_supports, n_outputs)."""
    above = w[:, None] * values
    cauchy = _cauchy(poles, supports)
    residue = np.linalg.norm(cauchy @ above, axis=1) / np.maximum(np.abs(cauchy**2 @ w), 1e-300)
    beside = _cauchy(np.asarray(1j * poles.imag), supports)
    curve = np.linalg.norm(beside @ above, axis=1) / np.maximum(np.abs(beside @ w), 1e-300)
    return share_of_curve(residue, poles.real, curve)


def _cauchy(z: ComplexArray, supports: ComplexArray) -> ComplexArray:
    gap = z[:, None] - supports
    # A point on a support itself: the limit is reached to rounding a hair beside it.
    return np.asarray(1.0 / np.where(gap == 0.0, 1e-15, gap))

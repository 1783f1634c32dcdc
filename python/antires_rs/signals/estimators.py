r"""Two-channel estimators, and how far each estimate scatters.

With S_ab the average of conj(A) B over n_d independent pieces, and j the input:

    H1 = S_jp / S_jj    H2 = S_pp / S_pj    Hv: total least squares on (x_j, x_p)

Noise on the input makes H1 too small by the factor 1 / (1 + noise_j / signal_j), noise on the output makes H2
too large by 1 + noise_p / signal_p. An estimate H scatters, in its real and its imaginary part alike, by

    std^2 = abs(H)^2 (1 - g2) / (2 g2 (n_d - 1)),    g2 the ordinary coherence.

That is the textbook's expression (there with n_d: the coherence itself is estimated from the same averages
and comes out too high by one part in n_d). It is exact to first order for H1 and H2, and an upper limit for
Hv, whose magnitude may scatter less by up to sqrt(g2).

For the rank-one estimate T = v_p / v_j, v the dominant eigenvector of a matrix whose channels are scaled to
equal noise, first-order perturbation moves v along every other eigenvector e_k (eigenvalue l_k, that of v
l_1) by a random amount of variance l_1 l_k / (n_d (l_1 - l_k)^2), hence

    std^2 = sum_k abs(e_kp - T e_kj)^2 / abs(v_j)^2  l_1 l_k / (2 (n_d - 1) (l_1 - l_k)^2).

In white noise that is abs(T)^2 (1 + 1/q) (1/q_p + 1/q_j) / (2 n_d), q the signal-to-noise power of all
channels together, q_p that of one; for H1 the factor (1 + 1/q) (1/q_p + 1/q_j) reads
1/q_p + 1/q_j + 1/(q_p q_j). So the eigenvector gains over H1 where both channels are weak; with two channels
both are the same.

References: J. S. Bendat and A. G. Piersol, Random Data, 4th ed., 2010, ch. 9 (random errors of H1 and H2);
G. T. Rocklin, J. Crowley, H. Vold, Proc. IMAC 3 (1985) 272-278 (Hv); T. W. Anderson, Ann. Math. Stat. 34
(1963) 122-148 (scatter of eigenvectors).
"""

from __future__ import annotations

import numpy as np

from ..exceptions import UnsuitableDataError
from ..support.checks import ComplexArray, FloatArray
from .noise import noise_power, scaled_eigh

# Below this a coherence is that of a line without energy.
LEAST_COHERENCE = 1e-12
# Two largest eigenvalues closer than this leave the eigenvector undetermined.
LEAST_GAP = 1e-3


def two_channel(matrix: ComplexArray, j: int, estimator: str) -> tuple[ComplexArray, FloatArray]:
    """Every channel over channel j by H1, H2 or Hv, and ordinary coherence; both (n_channels, n_freq)."""
    auto = np.einsum("fii->if", matrix).real
    s_jp, s_jj = matrix[:, j, :].T, auto[j]
    if not s_jj[1:].all() or not auto.any(axis=1).all():
        silent = ~auto.any(axis=1)
        dead = int(np.flatnonzero(silent)[0]) if silent.any() else j
        raise UnsuitableDataError(
            "responses",
            f"channel {dead} without energy at some frequencies",
            "signals that are not zero",
            "Leave the dead channel out.",
        )
    with np.errstate(divide="ignore", invalid="ignore"):
        coherence = np.clip(np.abs(s_jp) ** 2 / (s_jj * auto), 0.0, 1.0)
        if estimator == "h1":
            values = s_jp / s_jj
        elif estimator == "h2":
            values = auto / s_jp.conj()
        else:
            scale = np.sqrt(auto.mean(axis=1) / s_jj.mean())[:, None]
            a, b, c = s_jj, auto / scale**2, s_jp / scale
            # Dominant eigenvector of [[a, conj c], [c, b]], from the row that does not cancel.
            largest = 0.5 * (a + b + np.hypot(a - b, 2.0 * np.abs(c)))
            values = np.where(a >= b, c / (largest - b), (largest - a) / c.conj()) * scale
    # Lines without energy (often zero frequency, after the mean was removed) carry no information.
    return np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0), np.nan_to_num(coherence)


def std_of_coherence(values: ComplexArray, coherence: FloatArray, n_averages: float) -> FloatArray:
    """Standard deviation of real and imaginary part, (n_channels, n_freq).

    A line without any coherence knows nothing; its deviation is kept finite, and very large.
    """
    known = np.maximum(coherence, LEAST_COHERENCE)
    # H1 is zero where coherence is: the scatter there must not be.
    size = np.maximum(np.abs(values), LEAST_COHERENCE * np.abs(values).max(axis=1, keepdims=True))
    return np.asarray(size * np.sqrt((1.0 - known) / (2.0 * known * (n_averages - 1.0))), dtype=np.float64)


def std_of_rank_one(matrix: ComplexArray, j: int, n_averages: float) -> FloatArray:
    """Standard deviation of real and imaginary part of the rank-one T_pj, (n_channels, n_freq)."""
    noise = noise_power(matrix, n_averages)
    root = np.sqrt(noise)
    values, vectors = scaled_eigh(matrix, noise)
    first = np.maximum(values[:, -1:], 1e-300)
    values = np.clip(values[:, :-1], 0.0, (1.0 - LEAST_GAP) * first)
    own, others = vectors[:, :, -1], vectors[:, :, :-1]
    # The eigenvector errs along every other one; the ratio to component j takes the projections.
    share = first * values / (first - values) ** 2
    v_j = np.where(own[:, j] == 0.0, 1e-300, own[:, j])[:, None]
    t = own / v_j
    error = (
        np.abs((others - t[:, :, None] * others[:, j : j + 1, :]) / v_j[:, :, None]) ** 2 @ share[:, :, None]
    )
    std = (np.sqrt(error[:, :, 0] / (2.0 * (n_averages - 1.0))) * root / root[j]).T
    std[j] = 0.0
    return np.asarray(std, dtype=np.float64)

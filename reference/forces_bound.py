r"""How well a record of several unknown forces tells its antiresonances: the Cramer-Rao bound.

At a line the responses are Gaussian with covariance S = A S_f A' + I: A (n, r) the receptances of the exact
structure over the noise of each channel, S_f the spectra of the forces, unknown at every line. What a record
of T seconds tells of parameters t of A is then (P. Stoica and A. Nehorai, IEEE Trans. Acoust. Speech Signal
Process. 38 (1990) 1783-1795; with one look at each of the lines 1 / T apart)

    J_ij = 2 T int Re tr(A_i' P A_j S_f A' S^-1 A S_f) df,      P = I - A (A'A)^-1 A',   A_i = dA / dt_i.

The parameters are those of all modes of the structure: shape at every sensor, participation at every force,
frequency and damping; nothing is known of them beforehand. A zero s of the minor of rows I moves by
-u'(A_i)v / u'(dA / ds)v, u and v the null vectors of A[I] there, and its variance is g' J^+ g with g the
slope of abs(s) / 2 pi: what J leaves open (scales of modes, factors of the forces) moves no zero. Nothing of
antires_rs is used, and no fit.
"""

from __future__ import annotations

import numpy as np

#: Lines of the integral, and of those that are formed at a time; least eigenvalue of J that tells anything.
LINES, TOGETHER, LEAST = 4000, 250, 1e-11
#: Exact values this close are one, of which the mean of the roots is what can be known.
SAME = 1e-3


class Receptances:
    """Receptances of modes to some forces, and their derivatives by the parameters."""

    def __init__(self, structure, forces):
        self.rows, self.columns = structure.sensors, structure.sensors[list(forces)]
        self.own, self.damping = 2 * np.pi * structure.freq_hz, structure.damping

    def _oscillators(self, s):
        s = np.asarray(s)[..., None]
        return s**2 / (s**2 + 2 * self.damping * self.own * s + self.own**2)

    def at(self, s):
        """A, (..., n, r)."""
        return np.einsum("pm,...m,jm->...pj", self.rows, self._oscillators(s), self.columns)

    def slope(self, s):
        """dA / ds."""
        step = 1e-6 * abs(s)
        return (self.at(s + step) - self.at(s - step)) / (2 * step)

    def by_parameters(self, s):
        """dA / dt, (n_parameters, ..., n, r), by shares of the largest shape, and by per cents."""
        g, s = self._oscillators(s), np.asarray(s)
        (n, m), r = self.rows.shape, len(self.columns)
        out = np.zeros(((n + r + 2) * m, *s.shape, n, r), complex)
        shapes, parts, modes = np.split(out, [n * m, (n + r) * m])
        for p in range(n):
            for k in range(m):
                size = np.abs(self.rows[:, k]).max()
                shapes[p * m + k][..., p, :] = size * g[..., k, None] * self.columns[:, k]
        for j in range(r):
            for k in range(m):
                size = np.abs(self.columns[:, k]).max()
                parts[j * m + k][..., :, j] = size * g[..., k, None] * self.rows[:, k]
        below = s[..., None] ** 2 + 2 * self.damping * self.own * s[..., None] + self.own**2
        of_own = -0.01 * g / below * (2 * self.damping * s[..., None] + 2 * self.own) * self.own
        of_damping = -0.01 * g / below * 2 * self.own * s[..., None]
        for k in range(m):
            shape = np.outer(self.rows[:, k], self.columns[:, k])
            modes[2 * k] = of_own[..., k, None, None] * shape
            modes[2 * k + 1] = of_damping[..., k, None, None] * shape
        return out


def information(exact, freq_hz, noise, looks):
    """J of lines with so many ``looks`` each under white forces; ``noise`` (n,) over the forces, in power."""
    s, root = 2j * np.pi * np.asarray(freq_hz), np.sqrt(noise)[:, None]
    total = 0.0
    for some in np.array_split(s, -(-len(s) // TOGETHER)):
        a = exact.at(some) / root
        across = a.conj().transpose(0, 2, 1)
        covariance = np.eye(len(noise)) + a @ across
        worth = np.linalg.cholesky(across @ np.linalg.solve(covariance, a))
        beside = np.eye(len(noise)) - a @ np.linalg.solve(across @ a, across)
        d = exact.by_parameters(some) / root
        d = (beside @ d @ worth).reshape(len(d), -1)
        total = total + 2.0 * looks * (d.conj() @ d.T).real
    return total


def inverse(j):
    """J^+, scaled before, so that units do not decide what is left open."""
    size = np.sqrt(np.diag(j))
    size = np.maximum(size, 1e-12 * size.max())
    values, vectors = np.linalg.eigh(j / np.outer(size, size))
    keep = values > LEAST * values[-1]
    return (vectors[:, keep] / values[keep]) @ vectors[:, keep].T / np.outer(size, size)


class Bound:
    """Standard deviations of the zeros of a structure under white forces of equal strength at some sensors.

    ``noise`` is white, of this share of the root mean square of each channel.
    """

    def __init__(self, structure, forces, duration_s, noise):
        self.structure, self.forces = structure, list(forces)
        self.exact, self.covariance = Receptances(structure, forces), None
        if noise > 0.0:
            every = np.linspace(0.0, 0.5 * structure.fs_hz, 5 * LINES + 1)[1:]
            power = np.mean(np.sum(np.abs(self.exact.at(2j * np.pi * every)) ** 2, axis=2), axis=0)
            low, high = structure.band_hz
            lines = low + (high - low) * (np.arange(LINES) + 0.5) / LINES
            looks = duration_s * (high - low) / LINES
            self.covariance = inverse(information(self.exact, lines, noise**2 * power, looks))

    def slope(self, rows, s):
        """Of abs(s) / 2 pi by the parameters, at a zero s of the minor of some rows."""
        left, _, right = np.linalg.svd(self.exact.at(s)[list(rows)])
        u, v = left[:, -1].conj(), right[-1].conj()
        moves = u @ self.exact.by_parameters(s)[:, list(rows)] @ v
        ds = -moves / (u @ self.exact.slope(s)[list(rows)] @ v)
        return (ds * np.conj(s)).real / abs(s) / (2 * np.pi)

    def zeros(self, rows, exact_hz):
        """Zeros with damping, in rad/s, of each exact value without; of one that is there twice both."""
        freq, damping = self.structure.zeros(list(rows), self.structure.sensors[self.forces])
        s = 2 * np.pi * freq * (-damping + 1j * np.sqrt(1.0 - damping**2))
        counts = [int(np.sum(np.abs(exact_hz / value - 1.0) < SAME)) for value in exact_hz]
        return [s[np.argsort(np.abs(freq - v))[:count]] for v, count in zip(exact_hz, counts, strict=True)]

    def std_hz(self, rows, exact_hz):
        """Of exact values of the minor of some rows; of one that is there twice that of the mean."""
        if self.covariance is None:
            return np.zeros(len(exact_hz))
        slopes = [np.mean([self.slope(rows, s) for s in near], axis=0) for near in self.zeros(rows, exact_hz)]
        return np.array([np.sqrt(g @ self.covariance @ g) for g in slopes])

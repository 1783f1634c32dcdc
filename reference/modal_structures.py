r"""Five structures by their modes, the exact zeros that transmissibilities see, and how well they are known.

Portal frame, free beam, plate strip, truss and tower; each is its modes (up to four times the band) at the
sensors, at the place of the force and at dofs beside it, so that a force of any place and angle, and modes
that no model of it has, keep exact zeros. Nothing of antires_rs is used.

*Zeros.* Response p to a force with modal participations b is sum_r phi_pr b_r s^2 / (s^2 + 2 z_r w_r s +
w_r^2). Its zeros are the finite eigenvalues of the pencil bordered by b and phi_p (frequency abs(s) / 2 pi).

*Standard deviation.* At a line x = a N(f) + noise, with the factor a (force, resonances) unknown at every
line. In a window of 25 % to either side of a zero the model is N_q = R_q(f) Z_q(f): Z_q has unknown
coefficients and the degree of the zeros of q in the window plus two (a smooth factor), R_q is known. With
noise powers C = diag(s_q^2) of a line and a profiled out, the information on the coefficients c is

    J = sum_f abs(a)^2 G' C^-1/2 (I - u u') C^-1/2 G,   G = dN/dc,   u = C^-1/2 N / norm,

and var(Re z_p) = g' J^-1 g / 2 with g = dz_p/dc = -(dN_p/dc)(z_p) / N_p'(z_p): the Cramer-Rao bound of this
local model, for all channels together. A factor common to all N_q changes no zero; J is regularized along it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg

#: Zeros with more damping are none: they shape a trend.
MOST_DAMPING = 0.1
#: Modes are kept up to this multiple of the band's end.
MODES_TO = 4.0
#: Half width of the window of the Cramer-Rao bound, by ratio, and degree of its smooth factor.
WINDOW, SMOOTH = 1.25, 2


@dataclass(frozen=True)
class ModalStructure:
    """Modes at the sensors (n, n_modes), at the force (n_modes,), and beside it (n_beside, n_modes)."""

    name: str
    freq_hz: np.ndarray
    damping: np.ndarray
    sensors: np.ndarray
    force: np.ndarray
    beside: np.ndarray
    driven: int
    band_hz: tuple[float, float]
    fs_hz: float

    def with_modes(self, freq_hz, damping, sensors, force, beside):
        """With further modes, such as sideways ones."""
        return replace(
            self,
            freq_hz=np.append(self.freq_hz, freq_hz),
            damping=np.append(self.damping, damping),
            sensors=np.hstack([self.sensors, sensors]),
            force=np.append(self.force, force),
            beside=np.hstack([self.beside, beside]),
        )

    def accelerance(self, freq_hz, force=None):
        """Of every sensor, (n, n_freq), to a force of these modal participations (default: in its place)."""
        return (self.sensors * (self.force if force is None else force)) @ self.oscillators(freq_hz)

    def oscillators(self, freq_hz):
        """Acceleration of every mode to a unit modal force, (n_modes, n_freq)."""
        f = np.asarray(freq_hz, float)
        own = self.freq_hz[:, None]
        return -(f**2) / (own**2 - f**2 + 2j * self.damping[:, None] * own * f)

    def zeros(self, row, force=None):
        """(frequencies in Hz, damping ratios) of the zeros of one sensor in the band, ascending.

        Of several forces, modal participations (r, n_modes), those of the minor of r sensors.
        """
        b = np.atleast_2d(self.force if force is None else force)
        rows = self.sensors[np.atleast_1d(row)]
        m, r = self.freq_hz.size, len(b)
        w = self.freq_hz / self.freq_hz.max()
        # States: displacements and velocities of the modes, and the forces that keep the sensors still.
        left = np.zeros((2 * m + r, 2 * m + r))
        left[:m, m : 2 * m] = np.eye(m)
        left[m : 2 * m, :m] = -np.diag(w**2)
        left[m : 2 * m, m : 2 * m] = -np.diag(2 * self.damping * w)
        left[m : 2 * m, 2 * m :] = (b / np.abs(b).max(axis=1, keepdims=True)).T
        left[2 * m :, :m] = rows / np.abs(rows).max(axis=1, keepdims=True)
        right = np.diag(np.append(np.ones(2 * m), np.zeros(r)))
        alpha, beta = scipy.linalg.eig(left, right, right=False, homogeneous_eigvals=True)
        finite = np.abs(beta) > 1e-9 * np.abs(alpha)
        s = alpha[finite] / beta[finite] * self.freq_hz.max()
        s = s[s.imag > 1e-9 * np.abs(s)]
        freq, damping = np.abs(s), -s.real / np.abs(s)
        keep = (freq >= self.band_hz[0]) & (freq <= self.band_hz[1]) & (np.abs(damping) <= MOST_DAMPING)
        order = np.argsort(freq[keep])
        return freq[keep][order], damping[keep][order]


def cramer_rao(structure, zeros, power, noise, freq_hz, force=None, live=None):
    """Standard deviations in Hz of ``zeros`` (one (freq, damping) a sensor), one array a sensor.

    ``power`` (n_freq,) is abs(F)^2 of the lines and ``noise`` (n,) the noise power of a line by channel, both
    of the same transform of the record; channels that are not ``live`` tell nothing.
    """
    n = len(structure.sensors)
    live = np.ones(n, bool) if live is None else np.asarray(live)
    found = [np.full(z[0].size, np.inf) for z in zeros]
    for row in np.flatnonzero(live):
        for i, (f0, damping) in enumerate(zip(*zeros[row], strict=True)):
            low, high = max(f0 / WINDOW, structure.band_hz[0]), min(f0 * WINDOW, structure.band_hz[1])
            some = (freq_hz >= low) & (freq_hz <= high)
            if some.sum() < 3:
                continue
            local = _Window(structure, zeros, freq_hz[some], np.flatnonzero(live), force, (low, high))
            found[row][i] = local.deviation(power[some], noise, row, f0, damping)
    return found


class _Window:
    """The local model of the bound, about one zero."""

    def __init__(self, structure, zeros, freq_hz, rows, force, edges):
        self.rows, self.freq = rows, freq_hz
        self.middle, self.half = 0.5 * sum(edges), 0.5 * (edges[1] - edges[0])
        self.response = structure.accelerance(freq_hz, force)[rows]
        self.structure, self.force = structure, force
        self.inside = []
        for row in rows:
            f, d = zeros[row]
            keep = (f >= edges[0]) & (f <= edges[1])
            self.inside.append(f[keep] * (np.sqrt(1 - d[keep] ** 2) + 1j * d[keep]))

    def scaled(self, f):
        return (f - self.middle) / self.half

    def deviation(self, power, noise, row, f0, damping):
        x = self.scaled(self.freq)
        at = list(self.rows).index(row)
        z = f0 * (np.sqrt(1 - damping**2) + 1j * damping)
        blocks, gauge, offset, sensitivity = [], [], 0, None
        sizes = [len(own) + SMOOTH + 1 for own in self.inside]
        total = sum(sizes)
        common = np.zeros((SMOOTH + 1, total), complex)
        for q, own in enumerate(self.inside):
            roots = self.scaled(own)
            known = np.polynomial.chebyshev.chebfromroots(roots)
            smooth = self.response[q] / np.prod(x[:, None] - roots[None, :], axis=1)
            basis = np.polynomial.chebyshev.chebvander(x, sizes[q] - 1)
            blocks.append(smooth[:, None] * basis)
            for k in range(SMOOTH + 1):
                unit = np.zeros(k + 1)
                unit[k] = 1.0
                times = np.polynomial.chebyshev.chebmul(unit, known)
                common[k, offset : offset + times.size] = times
            if q == at:
                # dz = -P(z) / Z'(z), P any polynomial of the block, for the zero as scaled.
                others = np.delete(roots, np.argmin(np.abs(own - z)))
                slope = np.prod(self.scaled(z) - others)
                values = np.polynomial.chebyshev.chebvander(np.array([self.scaled(z)]), sizes[q] - 1)[0]
                sensitivity = np.zeros(total, complex)
                sensitivity[offset : offset + sizes[q]] = -self.half * values / slope
            offset += sizes[q]
        gain = np.zeros((x.size, len(self.rows), total), complex)
        offset = 0
        for q, block in enumerate(blocks):
            gain[:, q, offset : offset + sizes[q]] = block / np.sqrt(noise[self.rows[q]])
            offset += sizes[q]
        u = (self.response / np.sqrt(noise[self.rows])[:, None]).T
        u = u / np.linalg.norm(u, axis=1, keepdims=True)
        gain = gain - u[:, :, None] * np.einsum("fq,fqc->fc", u.conj(), gain)[:, None, :]
        gain = (np.sqrt(power)[:, None, None] * gain).reshape(-1, total)
        information = gain.conj().T @ gain
        size = np.sqrt(np.maximum(np.diag(information).real, 1e-300))
        gauge = np.linalg.qr((common * size).T)[0]
        scaled = information / np.outer(size, size) + gauge @ gauge.conj().T
        g = sensitivity.conj() / size
        return float(np.sqrt(max(0.5 * np.real(g.conj() @ np.linalg.solve(scaled, g)), 0.0)))


# -- Finite elements


def _beam(length, ea, ei, mass):
    """Stiffness and consistent mass (6, 6) along x, dofs (u, v, theta); Przemieniecki (1968)."""
    k, m, a = np.zeros((6, 6)), np.zeros((6, 6)), length
    axial, bending = np.ix_([0, 3], [0, 3]), np.ix_([1, 2, 4, 5], [1, 2, 4, 5])
    k[axial] = ea / a * np.array([[1, -1], [-1, 1]])
    m[axial] = mass * a / 6 * np.array([[2, 1], [1, 2]])
    stiff = [
        [12, 6 * a, -12, 6 * a],
        [0, 4 * a**2, -6 * a, 2 * a**2],
        [0, 0, 12, -6 * a],
        [0, 0, 0, 4 * a**2],
    ]
    heavy = [
        [156, 22 * a, 54, -13 * a],
        [0, 4 * a**2, 13 * a, -3 * a**2],
        [0, 0, 156, -22 * a],
        [0, 0, 0, 4 * a**2],
    ]
    for target, upper, factor in ((k, stiff, ei / a**3), (m, heavy, mass * a / 420)):
        upper = np.array(upper, float)
        target[bending] = factor * (upper + np.triu(upper, 1).T)
    return k, m


def _plane_frame(nodes, members):
    """Matrices of plane beams: members are (node, node, EA, EI, mass per metre)."""
    size = 3 * len(nodes)
    stiffness, mass = np.zeros((size, size)), np.zeros((size, size))
    for p, q, ea, ei, heavy in members:
        along = np.subtract(nodes[q], nodes[p])
        length = float(np.hypot(*along))
        cos, sin = along / length
        turn = scipy.linalg.block_diag(*[[[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]]] * 2)
        dofs = np.ix_(*[np.r_[3 * p : 3 * p + 3, 3 * q : 3 * q + 3]] * 2)
        k, m = _beam(length, ea, ei, heavy)
        stiffness[dofs] += turn.T @ k @ turn
        mass[dofs] += turn.T @ m @ turn
    return stiffness, mass


def _plate_element(a, b, thickness, young, poisson, density):
    """Rectangle of Adini, Clough and Melosh: w and both slopes at the corners, (12, 12) by integration."""
    powers = [(i, j) for i in range(4) for j in range(4) if i + j <= 3] + [(3, 1), (1, 3)]

    def row(x, y, dx, dy):
        def term(n, v, d):
            factor = np.prod([n - i for i in range(d)]) if d else 1.0
            return factor * v ** max(n - d, 0) if n >= d else 0.0

        return np.array([term(i, x, dx) * term(j, y, dy) for i, j in powers])

    corners = [(0, 0), (a, 0), (a, b), (0, b)]
    shape = np.linalg.inv(
        np.array([row(x, y, *d) for x, y in corners for d in ((0, 0), (1, 0), (0, 1))], float)
    )
    flexural = young * thickness**3 / (12 * (1 - poisson**2))
    law = flexural * np.array([[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]])
    at, weights = np.polynomial.legendre.leggauss(5)
    k, m = np.zeros((12, 12)), np.zeros((12, 12))
    for u, wu in zip(at, weights, strict=True):
        for v, wv in zip(at, weights, strict=True):
            x, y, area = a * (u + 1) / 2, b * (v + 1) / 2, wu * wv * a * b / 4
            curve = np.array([row(x, y, 2, 0), row(x, y, 0, 2), 2 * row(x, y, 1, 1)]) @ shape
            value = row(x, y, 0, 0) @ shape
            k += area * curve.T @ law @ curve
            m += area * density * thickness * np.outer(value, value)
    return k, m


def _modal(name, matrices, free, sensors, driven, beside, band_hz, fs_hz, rng, ratios=(0.005, 0.015)):
    """Modes of the free dofs; sensors, the driven one among them and dofs beside are those of the whole."""
    k, m = (a[np.ix_(free, free)] for a in matrices)
    lam, phi = scipy.linalg.eigh(k, m)
    whole = np.zeros((len(matrices[0]), lam.size))
    whole[free] = phi
    freq = np.sqrt(np.maximum(lam, 0.0)) / (2 * np.pi)
    keep = freq <= MODES_TO * band_hz[1]
    return ModalStructure(
        name,
        np.maximum(freq[keep], 1e-3 * band_hz[1]),
        rng.uniform(*ratios, keep.sum()),
        whole[sensors][:, keep],
        whole[sensors[driven]][keep],
        whole[beside][:, keep],
        driven,
        band_hz,
        fs_hz,
    )


# -- The five structures; no symmetry is exact


def frame():
    """Two storeys of 0.5 m, one bay of 0.6 m, steel strip; six sensors across columns and beams."""
    rng = np.random.default_rng(1)
    storey, bay, width = 0.5, 0.6, 0.05
    corners = [(x, y * storey) for y in range(3) for x in (0.0, bay)]
    nodes, members, inner = list(corners), [], {}
    for a, b, thick in ((0, 2, 5e-3), (1, 3, 5e-3), (2, 4, 5e-3), (3, 5, 5e-3), (2, 3, 10e-3), (4, 5, 10e-3)):
        path = [a, *range(len(nodes), len(nodes) + 3), b]
        nodes += [tuple(np.add(corners[a], np.subtract(corners[b], corners[a]) * i / 4)) for i in (1, 2, 3)]
        inner[a, b] = path[1:-1]
        thick *= rng.uniform(0.95, 1.05)
        area, inertia = width * thick, width * thick**3 / 12
        members += [
            (p, q, 210e9 * area, 210e9 * inertia, 7850 * area)
            for p, q in zip(path[:-1], path[1:], strict=True)
        ]
    matrices = _plane_frame(nodes, members)
    for node in (2, 3, 4, 5):
        for d in (0, 1):
            matrices[1][3 * node + d, 3 * node + d] += rng.uniform(0.3, 0.7)
    u, v = (lambda node: 3 * node), (lambda node: 3 * node + 1)
    sensors = [u(4), u(2), u(inner[0, 2][1]), u(inner[3, 5][1]), v(inner[4, 5][1]), v(inner[2, 3][0])]
    beside = [u(inner[2, 4][2]), 3 * 4 + 2, v(inner[4, 5][0])]
    return _modal("frame", matrices, range(6, 3 * len(nodes)), sensors, 0, beside, (3.0, 120.0), 500.0, rng)


def beam():
    """A free steel beam of 1.2 m on soft cords; six sensors, force near one end."""
    rng = np.random.default_rng(2)
    count, length, width, thick = 16, 1.2, 0.04, 8e-3
    nodes = [(length * i / count, 0.0) for i in range(count + 1)]
    area, inertia = width * thick, width * thick**3 / 12
    members = [
        (i, i + 1, 210e9 * area, 210e9 * inertia * rng.uniform(0.95, 1.05), 7850 * area) for i in range(count)
    ]
    matrices = _plane_frame(nodes, members)
    across = [d for d in range(3 * (count + 1)) if d % 3]
    for node, stiff in ((3, 900.0), (13, 800.0)):
        matrices[0][3 * node + 1, 3 * node + 1] += stiff
    sensors = [3 * node + 1 for node in (0, 3, 6, 9, 12, 16)]
    beside = [3 * 1 + 1, 2, 3 * 2 + 2]
    return _modal("beam", matrices, across, sensors, 0, beside, (10.0, 400.0), 1024.0, rng)


def plate_strip():
    """A clamped aluminium strip of 0.9 by 0.18 m, 4 mm: bending and torsion; six sensors."""
    rng = np.random.default_rng(3)
    along, across, length, width = 10, 2, 0.9, 0.18
    number = (across + 1) * (along + 1)
    matrices = np.zeros((3 * number, 3 * number)), np.zeros((3 * number, 3 * number))
    for i in range(along):
        for j in range(across):
            k, m = _plate_element(length / along, width / across, 4e-3, 70e9, 0.33, 2700.0)
            corner = [(across + 1) * p + q for p, q in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))]
            dofs = np.ix_(*[[3 * node + d for node in corner for d in range(3)]] * 2)
            matrices[0][dofs] += k * rng.uniform(0.93, 1.07)
            matrices[1][dofs] += m
    place = [(7, 0), (10, 0), (10, 2), (6, 1), (4, 2), (3, 0)]
    sensors = [3 * ((across + 1) * i + j) for i, j in place]
    for dof in sensors:
        matrices[1][dof, dof] += 0.02
    beside = [3 * ((across + 1) * i + j) for i, j in ((7, 1), (6, 0), (8, 0))]
    free = range(3 * (across + 1), 3 * number)
    return _modal("plate strip", matrices, free, sensors, 0, beside, (5.0, 160.0), 512.0, rng)


def truss():
    """A plane truss of six panels of 1 m, simply supported; seven sensors, vertical and one along."""
    rng = np.random.default_rng(4)
    panels = 6
    nodes = [(float(i), 0.0) for i in range(panels + 1)] + [(i + 1.0, 0.8) for i in range(panels - 1)]
    top = panels + 1
    pairs = [(i, i + 1) for i in range(panels)] + [(top + i, top + i + 1) for i in range(panels - 2)]
    pairs += [(0, top), (panels, top + panels - 2)] + [(i + 1, top + i) for i in range(panels - 1)]
    pairs += [(i + 1, top + i + 1) for i in range(panels - 2)]
    size = 2 * len(nodes)
    stiffness, mass = np.zeros((size, size)), np.zeros((size, size))
    for p, q in pairs:
        along = np.subtract(nodes[q], nodes[p])
        span = float(np.hypot(*along))
        area = 2.0e-4 * rng.uniform(0.9, 1.1)
        unit = np.append(-along, along) / span
        dofs = np.array([2 * p, 2 * p + 1, 2 * q, 2 * q + 1])
        stiffness[np.ix_(dofs, dofs)] += 70e9 * area / span * np.outer(unit, unit)
        mass[dofs, dofs] += 2700 * area * span / 2
    for node in range(1, panels):
        mass[2 * node, 2 * node] += (heavy := rng.uniform(15, 25))
        mass[2 * node + 1, 2 * node + 1] += heavy
    free = [d for d in range(size) if d not in (0, 1, 2 * panels + 1)]
    sensors = [2 * 2 + 1, 3, 7, 9, 11, 2 * 3, 2 * (top + 1) + 1]
    beside = [2 * 2, 2 * 1 + 1, 2 * (top + 1)]
    return _modal(
        "truss", (stiffness, mass), free, sensors, 0, beside, (5.0, 100.0), 400.0, rng, (0.004, 0.012)
    )


def tower():
    """A tapered tower of 60 m with a heavy head on a soft footing; six sensors, shaker at two thirds."""
    rng = np.random.default_rng(5)
    count, height = 20, 60.0
    nodes = [(0.0, height * i / count) for i in range(count + 1)]
    members = []
    for i in range(count):
        wide = 1.0 - 0.6 * (i + 0.5) / count
        members.append((i, i + 1, 2e9, 2.4e9 * wide**3 * rng.uniform(0.95, 1.05), 400.0 * wide))
    matrices = _plane_frame(nodes, members)
    matrices[1][3 * count, 3 * count] += 600.0
    matrices[0][0, 0] += 2e7
    matrices[0][2, 2] += 3e9
    across = [d for d in range(3 * (count + 1)) if d % 3 != 1]
    sensors = [3 * node for node in (13, 20, 17, 10, 7, 4)]
    beside = [3 * 12, 3 * 13 + 2, 3 * 15]
    return _modal("tower", matrices, across, sensors, 0, beside, (0.5, 12.0), 100.0, rng, (0.006, 0.02))


#: Those on which rules may be set, and those that judge them.
TUNING: dict[str, Callable[[], ModalStructure]] = {"frame": frame, "beam": beam, "truss": truss}
KEPT_BACK: dict[str, Callable[[], ModalStructure]] = {"plate strip": plate_strip, "tower": tower}
STRUCTURES = TUNING | KEPT_BACK

"""Structures that identification was not made on, each drawn anew from a seed, with their exact records.

Random chains, a chain with a local dashpot (damping that is not proportional), one with a spring to ground,
springs between all masses, a steel portal frame, and the eight-mass chain with sensor noise that is
coloured, drifting or unequal. Truth is what the undamped matrices say.

Records are synthesised in the frequency domain from (K + i w C - w^2 M)^-1 over twice the length wanted,
and a window is cut out of the middle: no integration error, not periodic, and no modal assumption.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

import antires_rs as ar
from reference.virtual_records import CHAIN8_MASSES, CHAIN8_SPRINGS, chain8_matrices, chain_matrices

FS_HZ = 512.0
#: Modal damping of every elastic mode, before a dashpot is added.
DAMPING_RATIO = 0.01
LOWEST_HZ = 3.0
#: The band ends this much above the highest mode, as it does for the eight-mass chain (115 and 130 Hz).
HEADROOM = 1.13
#: Below this part of the highest eigenfrequency lies rounding: sqrt of some ulp; a frame spans 1e-3.
RIGID = 1e-6
#: A reference for dashpots: sqrt(k m) of the eight-mass chain, N s/m.
CHAIN8_IMPEDANCE = float(np.sqrt(CHAIN8_SPRINGS[0] * CHAIN8_MASSES[1]))
#: Antiresonances in band of the fully coupled structure of the project's first study.
FULL_ZEROS = 36


@dataclass(frozen=True)
class Structure:
    """Matrices (n, n), one force, the dofs that are measured, and the band to identify in.

    With ``by_model`` the records come from ``MatrixModel.simulate``, as a user of a finite-element code would
    make them; else from the matrices themselves, whatever their damping.
    """

    stiffness: np.ndarray
    mass: np.ndarray
    damping: np.ndarray
    excitation: int
    responses: tuple[int, ...]
    band_hz: tuple[float, float]
    by_model: bool = False

    def truth(self):
        """Antiresonances of the undamped structure inside the band, by response."""
        model = ar.MatrixModel(self.stiffness, self.mass)
        zeros = model.antiresonances(list(self.responses), self.excitation, f_max_hz=self.band_hz[1])
        return {dof: f[f >= self.band_hz[0]] for dof, f in zip(self.responses, zeros, strict=True)}

    def damped_zeros(self, response):
        """Zeros s (rad/s, upper half plane) of H_ik with its damping, by ascending abs(s).

        The roots of det(K + s C + s^2 M)_ik = 0 as eigenvalues of the companion pencil.
        """
        k, c, m = (
            np.delete(np.delete(a, response, 0), self.excitation, 1)
            for a in (self.stiffness, self.damping, self.mass)
        )
        n = len(k)
        # s = s' w0 brings the blocks to one size.
        w0 = np.sqrt(np.abs(np.diag(self.stiffness)).max() / np.diag(self.mass).max())
        left = np.block([[np.zeros((n, n)), np.eye(n)], [-k / w0**2, -c / w0]])
        right = np.block([[np.eye(n), np.zeros((n, n))], [np.zeros((n, n)), m]])
        alpha, beta = scipy.linalg.eig(left, right, right=False, homogeneous_eigvals=True)
        finite = np.abs(beta) > 1e-9 * np.abs(alpha)
        s = alpha[finite] / beta[finite] * w0
        s = s[s.imag > 1e-6 * np.abs(s)]
        return s[np.argsort(np.abs(s))]

    def accelerance(self, freq_hz):
        """Accelerances of the responses, (n_responses, n_freq)."""
        w = 2 * np.pi * np.asarray(freq_hz, float)
        force = np.zeros((len(self.mass), 1))
        force[self.excitation] = 1.0
        out = np.empty((len(self.responses), w.size), complex)
        for a in range(0, w.size, 4096):
            part = w[a : a + 4096, None, None]
            dynamic = self.stiffness + 1j * part * self.damping - part**2 * self.mass
            x = np.linalg.solve(dynamic, force[None])[:, self.responses, 0]
            out[:, a : a + 4096] = (-(part[:, :, 0] ** 2) * x).T
        return out

    def record(self, *, noise=0.0, seed=0, duration_s=200.0, sensors="white"):
        """Recording under a white force up to 0.45 of the sampling rate; ``noise`` as in ``sensor_noise``."""
        if self.by_model:
            if sensors not in ("white", "floor"):
                raise ValueError("MatrixModel.simulate offers white noise only")
            clean = ar.MatrixModel(self.stiffness, self.mass).simulate(
                excitation=self.excitation,
                fs_hz=FS_HZ,
                duration_s=duration_s,
                damping_ratio=DAMPING_RATIO,
                band_hz=(0.0, 0.45 * FS_HZ),
                noise=0.0 if sensors == "floor" else noise,
                responses=list(self.responses),
                rng=seed,
            )
            if sensors == "white":
                return clean
            x = clean.responses
            rough = sensor_noise(x.std(axis=1), x.shape[1], noise, sensors, np.random.default_rng([seed, 1]))
            return ar.Recording(x + rough, FS_HZ, dofs=clean.dofs, force=clean.force)
        rng = np.random.default_rng(seed)
        n = round(duration_s * FS_HZ)
        freq = np.fft.rfftfreq(2 * n, 1 / FS_HZ)
        inside = (freq > 0) & (freq <= 0.45 * FS_HZ)
        spectrum = np.zeros(freq.size, complex)
        spectrum[inside] = rng.standard_normal(inside.sum()) + 1j * rng.standard_normal(inside.sum())
        both = np.zeros((len(self.responses) + 1, freq.size), complex)
        both[:-1, inside] = self.accelerance(freq[inside]) * spectrum[inside]
        both[-1] = spectrum
        x = np.fft.irfft(both, 2 * n)[:, n // 2 : n // 2 + n]
        x[:-1] += sensor_noise(x[:-1].std(axis=1), n, noise, sensors, rng)
        return ar.Recording(x[:-1], FS_HZ, dofs=list(self.responses), force=x[-1])


def sensor_noise(rms, n, noise, sensors, rng):
    """Noise of every channel, (n_channels, n), of standard deviation ``noise * rms``.

    ``sensors`` is "white"; "pink" (power as 1/f from 0.1 Hz); "drift" (white, and ten times as much
    below 1 Hz with power as 1/f^2); "unequal" (white, levels of the channels spread from 1 to 10 about
    their geometric mean ``noise``); or "floor" (white, the same absolute level in all channels, ``noise``
    times their mean rms).
    """
    white = rng.standard_normal((rms.size, n))
    if sensors == "floor":
        return noise * rms.mean() * white
    level = noise * rms[:, None]
    if sensors == "white":
        return level * white
    if sensors == "unequal":
        spread = np.geomspace(10**-0.5, 10**0.5, rms.size)
        return level * rng.permutation(spread)[:, None] * white
    freq = np.fft.rfftfreq(n, 1 / FS_HZ)
    shape = np.zeros(freq.size)
    if sensors == "pink":
        shape[freq >= 0.1] = freq[freq >= 0.1] ** -0.5
    else:
        slow = (freq >= 0.02) & (freq <= 1.0)
        shape[slow] = 1.0 / freq[slow]
    coloured = np.fft.irfft(np.fft.rfft(rng.standard_normal((rms.size, n))) * shape, n)
    coloured /= coloured.std(axis=1, keepdims=True)
    return level * coloured if sensors == "pink" else level * (white + 10.0 * coloured)


def modal_damping_matrix(stiffness, mass, ratio=DAMPING_RATIO):
    """C of one damping ratio for all elastic modes; rigid-body motion stays undamped."""
    lam, phi = scipy.linalg.eigh(stiffness, mass)
    w = np.sqrt(np.maximum(lam, 0.0))
    w[w < RIGID * w.max()] = 0.0
    left = mass @ phi
    return left @ np.diag(2 * ratio * w) @ left.T


def structure(
    stiffness, mass, *, excitation=0, responses=None, added_damping=0.0, band_hz=None, by_model=False
):
    """With one per cent of modal damping, all dofs measured and the band up to above the highest mode."""
    if band_hz is None:
        highest = np.sqrt(scipy.linalg.eigvalsh(stiffness, mass)[-1]) / (2 * np.pi)
        band_hz = (LOWEST_HZ, float(min(HEADROOM * highest, 0.44 * FS_HZ)))
    dofs = tuple(range(len(mass))) if responses is None else tuple(responses)
    return Structure(
        stiffness,
        mass,
        modal_damping_matrix(stiffness, mass) + added_damping,
        excitation,
        dofs,
        band_hz,
        by_model,
    )


def chain8(seed):
    """The nominal eight-mass chain; the seed does not matter."""
    return structure(*chain8_matrices())


def random_chain(seed, excitation=0):
    """Eight masses and seven springs, each within 50 % of those of the eight-mass chain."""
    rng = np.random.default_rng([seed, 1])
    return structure(
        *chain_matrices(CHAIN8_MASSES * rng.uniform(0.5, 1.5, 8), CHAIN8_SPRINGS * rng.uniform(0.5, 1.5, 7)),
        excitation=excitation,
    )


def random_chain_inner_force(seed):
    """A random chain with the force at mass 3."""
    return random_chain(seed, excitation=3)


def dashpot_between(seed):
    """The eight-mass chain with a dashpot across one spring: 5 to 20 % of sqrt(k m)."""
    rng = np.random.default_rng([seed, 2])
    at = int(rng.integers(7))
    c = np.zeros((8, 8))
    c[at : at + 2, at : at + 2] = (
        rng.uniform(0.05, 0.2) * CHAIN8_IMPEDANCE * np.array([[1.0, -1.0], [-1.0, 1.0]])
    )
    return structure(*chain8_matrices(), added_damping=c)


def dashpot_to_ground(seed):
    """The eight-mass chain with a dashpot from one mass to ground: 5 to 20 % of sqrt(k m)."""
    rng = np.random.default_rng([seed, 3])
    c = np.zeros((8, 8))
    at = int(rng.integers(8))
    c[at, at] = rng.uniform(0.05, 0.2) * CHAIN8_IMPEDANCE
    return structure(*chain8_matrices(), added_damping=c)


def spring_to_ground(seed):
    """The eight-mass chain with a spring to ground at one mass, 0.2 to 2 times the others."""
    rng = np.random.default_rng([seed, 4])
    stiffness, mass = chain8_matrices()
    at = int(rng.integers(8))
    stiffness[at, at] += rng.uniform(0.2, 2.0) * CHAIN8_SPRINGS[0]
    return structure(stiffness, mass)


def full_stiffness(seed):
    """Eight masses and a full random stiffness A A' whose responses have 36 antiresonances in band."""
    rng = np.random.default_rng([seed, 5])
    while True:
        factor = rng.standard_normal((8, 8))
        stiffness = factor @ factor.T + 0.05 * np.eye(8)
        mass = np.diag(0.42 * rng.uniform(0.8, 1.2, 8))
        highest = scipy.linalg.eigvalsh(stiffness, mass)[-1]
        drawn = structure(stiffness * (2 * np.pi * 115.0) ** 2 / highest, mass)
        if sum(f.size for f in drawn.truth().values()) == FULL_ZEROS:
            return drawn


# ---- the frame ----------------------------------------------------------------------------------------

#: Steel strip, 40 mm wide; a bay of 0.7 m, two storeys of 0.45 m; three elements a member.
STEEL_PA, STEEL_KG_PER_M3, WIDTH_M = 210e9, 7850.0, 0.04
BAY_M, STOREY_M, DIVISIONS = 0.7, 0.45, 3


def beam_matrices(start, end, thickness_m):
    """Stiffness and consistent mass (6, 6) of a plane Euler-Bernoulli beam, dofs (u, v, theta) at each end.

    Przemieniecki, Theory of Matrix Structural Analysis (1968), sections 5.6 and 11.4.
    """
    along = np.asarray(end, float) - start
    length = np.hypot(*along)
    area, inertia = WIDTH_M * thickness_m, WIDTH_M * thickness_m**3 / 12
    ea, ei = STEEL_PA * area / length, STEEL_PA * inertia / length**3
    k, m = np.zeros((6, 6)), np.zeros((6, 6))
    axial, bending = np.ix_([0, 3], [0, 3]), np.ix_([1, 2, 4, 5], [1, 2, 4, 5])
    a = length
    k[axial] = ea * np.array([[1, -1], [-1, 1]])
    k[bending] = ei * np.array(
        [
            [12, 6 * a, -12, 6 * a],
            [6 * a, 4 * a**2, -6 * a, 2 * a**2],
            [-12, -6 * a, 12, -6 * a],
            [6 * a, 2 * a**2, -6 * a, 4 * a**2],
        ]
    )
    weight = STEEL_KG_PER_M3 * area * length
    m[axial] = weight / 6 * np.array([[2, 1], [1, 2]])
    m[bending] = (
        weight
        / 420
        * np.array(
            [
                [156, 22 * a, 54, -13 * a],
                [22 * a, 4 * a**2, 13 * a, -3 * a**2],
                [54, 13 * a, 156, -22 * a],
                [-13 * a, -3 * a**2, -22 * a, 4 * a**2],
            ]
        )
    )
    cos, sin = along / length
    turn = scipy.linalg.block_diag(*[[[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]]] * 2)
    return turn.T @ k @ turn, turn.T @ m @ turn


def _portal(seed):
    """Of the portal frame: nodes, where sensors look, elements (node, node, thickness), masses by node."""
    rng = np.random.default_rng([seed, 6])
    corners = [(x, y * STOREY_M) for y in range(3) for x in (0.0, BAY_M)]
    members = [(0, 2), (1, 3), (2, 4), (3, 5), (2, 3), (4, 5)]
    nodes = list(corners)
    # The sensor of each free node looks across its member: u on columns and at corners, v on beams.
    across = [0] * len(corners)
    parts = []
    for a, b in members:
        inner = list(range(len(nodes), len(nodes) + DIVISIONS - 1))
        nodes += [
            tuple(np.add(corners[a], np.subtract(corners[b], corners[a]) * i / DIVISIONS))
            for i in range(1, DIVISIONS)
        ]
        across += [int(corners[a][1] == corners[b][1])] * (DIVISIONS - 1)
        path = [a, *inner, b]
        thickness = 6e-3 * rng.uniform(0.85, 1.15)
        parts += [(p, q, thickness) for p, q in zip(path[:-1], path[1:], strict=True)]
    heavy = rng.choice(np.arange(2, len(nodes)), 4, replace=False)
    return nodes, across, parts, [(node, rng.uniform(0.1, 0.4)) for node in heavy]


def portal_elements(seed):
    """Stiffness of each of the 18 elements of :func:`portal_frame`, (48, 48); columns first, then beams."""
    nodes, _, parts, _ = _portal(seed)
    made = []
    for p, q, thickness in parts:
        whole = np.zeros((3 * len(nodes),) * 2)
        whole[np.ix_(*[np.r_[3 * p : 3 * p + 3, 3 * q : 3 * q + 3]] * 2)] = beam_matrices(
            nodes[p], nodes[q], thickness
        )[0]
        made.append(whole[6:, 6:])
    return made


def portal_frame(seed):
    """Two storeys, one bay, clamped feet, 48 dofs; 16 accelerometers across the members, force at a corner.

    Thickness (6 mm) of each member within 15 %, and four lumped masses at random nodes.
    """
    nodes, across, parts, heavy = _portal(seed)
    size = 3 * len(nodes)
    stiffness, mass = np.zeros((size, size)), np.zeros((size, size))
    for p, q, thickness in parts:
        dofs = np.ix_(*[np.r_[3 * p : 3 * p + 3, 3 * q : 3 * q + 3]] * 2)
        k, m = beam_matrices(nodes[p], nodes[q], thickness)
        stiffness[dofs] += k
        mass[dofs] += m
    for node, kg in heavy:
        mass[3 * node : 3 * node + 2, 3 * node : 3 * node + 2] += kg * np.eye(2)
    free = slice(6, None)  # the two feet are clamped
    sensors = [3 * node + across[node] - 6 for node in range(2, len(nodes))]
    return structure(
        stiffness[free, free],
        mass[free, free],
        excitation=sensors[0],
        responses=sensors,
        band_hz=(LOWEST_HZ, 200.0),
        by_model=True,
    )


#: Name: (maker, kind of sensor noise).
STRUCTURES = {
    "random chain, force at 1": (random_chain, "white"),
    "random chain, force at 4": (random_chain_inner_force, "white"),
    "dashpot between masses": (dashpot_between, "white"),
    "dashpot to ground": (dashpot_to_ground, "white"),
    "spring to ground": (spring_to_ground, "white"),
    "full random stiffness": (full_stiffness, "white"),
    "plane frame, 16 sensors": (portal_frame, "white"),
    "chain8, pink noise": (chain8, "pink"),
    "chain8, drift": (chain8, "drift"),
    "chain8, unequal noise": (chain8, "unequal"),
}

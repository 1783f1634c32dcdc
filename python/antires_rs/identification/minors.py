r"""Several unknown forces: the minors of the responses, of which every line knows one complex vector again.

Under r forces at J, not all coherent, of unknown spectra, the spectral matrix of the n responses is
H_J S_f H_J^H, of rank r beside the noise. Its dominant subspace has a basis U = H_J R, R (r, r) unknown. For
r rows I the minor

    P_I = det U[I, :] = det H[I, J] det R,      det H[I, J] = +- det A(rows J, columns I deleted) / det A

(Jacobi, A = K - w^2 M + i w C) is known up to det R, one factor a line: ratios P_I / P_I' have lost the r
forces and the resonances, and their poles are the antiresonances of order r, the roots of the deleted
determinant. r = 1 is the transmissibility. The vector of all P_I is what the fits start from
(:class:`~antires_rs.identification.lines.Lines`); its rows are named by sets of r responses.

Noise. With channels scaled to equal noise and S = V diag(l) V^H, a change dS moves v_j by

    dv_j = sum_i v_i e_ij,      e_ij = v_i^H dS v_j / (l_j - l_i),      i in the noise, j <= r,

and the vector of minors by sum e_ij T_ij, T_ij the minors of U with column j replaced by v_i: to first order,
all of it orthogonal to P, and the T_ij are orthonormal. The mean square l_i l_j / (l_j - l_i)^2 of e_ij tells
what the line is worth, and which minors are more than noise. A record is fitted by its subspaces
(:mod:`~antires_rs.identification.column_fit`), curves by their minors.

Sources: C. G. J. Jacobi, J. reine angew. Math. 22 (1841) 285-318 (minors of the inverse); W. V. D. Hodge and
D. Pedoe, Methods of Algebraic Geometry I, Cambridge 1947, ch. VII (coordinates of a subspace); T. W.
Anderson, Ann. Math. Stat. 34 (1963) 122-148 (scatter of eigenvectors).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from math import comb
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ..exceptions import Argument, UnsuitableDataError, reject
from ..measured.response_table import MOST_SETS, key_of
from ..signals.averaging import Averages
from ..signals.channel_checks import SAME
from ..signals.data_check import ROUGH
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..signals.repeats import as_first
from ..signals.spectra import EXACT, FLOOR_LINES, GAIN, LINES, Segments, pieces, second_differences
from ..support.checks import ComplexArray, Dofs, FloatArray
from .lines import SNR_CAP, Lines, require_live, unit

MOST_FORMED = 200_000  # of more no choice is made
IN_ONE_FIT, ANCHORS = 64, 12  # rows of one fit; of several fits those that all have, the strongest
CHOICE_LINES = 64  # lines that tell which minors are strong
LEAST_SNR = 4.0  # a line below it has no subspace of r dimensions by which a fit may be judged
# A minor is none if it is not so many times its noise in power, or this share of the typical one, which
# leaves leakage out. Of minors that are zero the ratio was 0.7 to 0.9, and without noise 2e-4 of the typical.
LEAST_RATIO, SILENT_SHARE = 10.0, 3e-4
PASSES = 8  # passes of "subspace, residual noise of each channel, scale"
LEAST_LEFT, LEAST_CHANGE = 1e-3, 0.05  # of a channel beside the signal; of its noise in one pass
LEAKS = 3  # lines to either side into which a window leaks
LEAST_GAP = 0.25  # a signal eigenvalue counts as no nearer to the noise than this share of itself


def minors_of(basis: ComplexArray, rows: NDArray[np.intp]) -> ComplexArray:
    """Determinants of some rows, (..., n_minors), of bases (..., n, r); ``rows`` are (n_minors, r)."""
    return _determinants([basis[..., rows[:, k], :] for k in range(rows.shape[1])])


def _determinants(rows: list[ComplexArray]) -> ComplexArray:
    """By the first row: for the few columns there are quicker than a factorization of each."""
    if len(rows) == 1:
        return rows[0][..., 0]
    total = np.zeros(rows[0].shape[:-1], dtype=np.complex128)
    for k in range(len(rows)):
        total += (-1.0) ** k * rows[0][..., k] * _determinants([np.delete(one, k, -1) for one in rows[1:]])
    return total


def tangents(basis: ComplexArray, others: ComplexArray, rows: NDArray[np.intp]) -> ComplexArray:
    """Minors with one column replaced by one of the ``others``, (..., n_minors, n_others, r)."""
    count, order = others.shape[-1], basis.shape[-1]
    out = np.empty((*basis.shape[:-2], len(rows), count, order), dtype=np.complex128)
    for j in range(order):
        for i in range(count):
            changed = basis.copy()
            changed[..., j] = others[..., i]
            out[..., i, j] = minors_of(changed, rows)
    return out


# -- Which minors, and what they are called


@dataclass(frozen=True)
class Named:
    """Sets of r channels: ``rows`` (n_minors, r) their indices, ``dofs`` their names."""

    rows: NDArray[np.intp]
    dofs: tuple[Dofs, ...]


def formed(size: Callable[[NDArray[np.intp]], FloatArray], channels: tuple[Any, ...], order: int) -> Named:
    """All sets of r channels, or those of the largest ``size``, (n_minors,), if there are very many."""
    check_channels(len(channels), order)
    rows = np.array(list(combinations(range(len(channels)), order)), dtype=np.intp)
    if len(rows) > MOST_SETS:  # those of most information
        rows = rows[np.sort(np.argsort(-size(rows), kind="stable")[:MOST_SETS])]
    named = key_of(Dofs(range(order)), (), channels)
    dofs = tuple(named("dofs", [channels[k] for k in own]) for own in rows.tolist())
    return Named(rows, dofs)


def check_channels(n: int, order: int) -> None:
    """Refuse more forces than so many responses can tell of."""
    if n <= order:
        got = f"{order} forces with {n} channels"
        wanted = f"at least {order + 1} channels: of r forces the sets of r responses are compared"
        raise UnsuitableDataError("excitation", got, wanted, "Add channels, or let fewer forces act at once.")
    if comb(n, order) > MOST_FORMED:
        got = f"{order} forces with {n} channels, {comb(n, order)} sets of responses"
        remedy = "Give the record with the channels that matter."
        reject("excitation", got, f"at most {MOST_FORMED} sets", remedy)


def groups(strength: FloatArray) -> list[NDArray[np.intp]]:
    """Rows that are fitted together: all, or parts of them beside the strongest, which every part has."""
    n = strength.size
    if n <= IN_ONE_FIT:
        return [np.arange(n)]
    ranked = np.argsort(-strength, kind="stable")
    anchors, rest = ranked[:ANCHORS], np.sort(ranked[ANCHORS:])
    parts = np.array_split(rest, -(-rest.size // (IN_ONE_FIT - ANCHORS)))
    return [np.concatenate([anchors, part]) for part in parts]


# -- The minors of a record


def subspace(matrix: ComplexArray, scale: FloatArray) -> tuple[FloatArray, ComplexArray]:
    """Eigenvalues, largest first, (n_freq, n), and eigenvectors, (n_freq, n, n), of scaled spectra."""
    root = 1.0 / np.sqrt(scale)
    values, vectors = np.linalg.eigh((matrix * (root[:, None] * root)).conj())
    return values[:, ::-1], vectors[:, :, ::-1]


def noise_beside(matrix: ComplexArray, start: FloatArray, order: int) -> FloatArray:
    """Relative noise power of every channel, (n_channels,).

    With P = (p_ij) on the eigenvectors beyond r the diagonal of P S P is sum_j abs(p_ij)^2 N_j, and N is what
    fits all lines: a channel that the signal nearly fills shows little of its own noise, but that of others.
    """
    from scipy.optimize import nnls  # slow to import

    some = matrix[:: max(1, len(matrix) // LINES)]
    scale = np.where(start > 0.0, start, 1.0)
    for _ in range(PASSES):
        values, vectors = subspace(some, scale)
        level = values[:, order:].mean(axis=1)
        quiet = level <= np.median(level)  # beside resonances leakage adds to it
        level = np.maximum(level, EXACT * values[:, 0] + 1e-300)[quiet, None]
        values, vectors = np.maximum(values[quiet, order:] / level, 0.0), vectors[quiet, :, order:]
        left = np.sum(np.abs(vectors) ** 2 * values[:, None], axis=2)
        share = np.abs(vectors @ vectors.conj().transpose(0, 2, 1)) ** 2
        weight = 1.0 / np.maximum(share.sum(axis=2), LEAST_LEFT)
        share = (share * weight[:, :, None]).reshape(-1, scale.size)
        change = nnls(share.T @ share, share.T @ (left * weight).ravel())[0]
        scale = scale * np.maximum(change / max(float(change.mean()), 1e-300), LEAST_CHANGE)
    return np.asarray(scale)


def floor_of(values: FloatArray, order: int) -> FloatArray:
    """Noise level of every line, (n_freq,), of the mean of what is beyond r eigenvalues.

    Its running median, and its own where more leaks to a line.
    """
    from scipy.ndimage import median_filter  # slow to import

    own = values[:, order:].mean(axis=1)
    rest = np.maximum(median_filter(own, size=FLOOR_LINES, mode="nearest"), own)
    return np.asarray(np.maximum(rest, 1e-15 * float(values[:, 0].max())))


@dataclass(frozen=True)
class Subspaces:
    """The dominant subspaces of a record by line, in units in which all channels have unit noise.

    ``values`` (n_freq, n), largest first, ``vectors`` (n_freq, n, n), ``segments`` those of the channels;
    ``floor`` (n_freq,) is what the powers of each line were divided by.
    """

    freq_hz: FloatArray
    values: FloatArray
    vectors: ComplexArray
    segments: Segments | None
    order: int
    floor: FloatArray

    @property
    def gaps(self) -> FloatArray:
        """l_j - l_i of the module, (n_freq, n - r, r); no smaller than a share of l_j."""
        signal, noise = self.values[:, None, : self.order], self.values[:, self.order :, None]
        return np.maximum(signal - noise, LEAST_GAP * signal)

    @property
    def above(self) -> FloatArray:
        """Signal of the r largest eigenvalues, l - 1, (n_freq, r); no smaller than a share of l."""
        signal = self.values[:, : self.order]
        return np.asarray(np.maximum(signal - 1.0, LEAST_GAP * signal))

    @property
    def snr(self) -> FloatArray:
        """Their power over that of what noise turns them by, (n_freq, r)."""
        return np.asarray(self.above**2 / self.values[:, : self.order])

    @property
    def worth(self) -> FloatArray:
        """Their weights in a fit of the subspaces, (n_freq, r); leakage never rules."""
        return np.asarray(self.snr / (1.0 + self.snr / SNR_CAP))

    def by_noise(self, lines: slice, averages_ratio: float) -> float:
        """What noise makes of the misfit of the subspaces, under these weights."""
        if self.segments is None:
            return 1e-300
        count = self.segments.count / averages_ratio
        over = self.worth[lines] / self.snr[lines]
        return float((self.vectors.shape[1] - self.order) * np.sum(over)) / count

    def part(self, lines: slice) -> Subspaces:
        """Some of the lines."""
        segments = None if self.segments is None else self.segments.part(lines)
        return replace(
            self,
            freq_hz=self.freq_hz[lines],
            values=self.values[lines],
            vectors=self.vectors[lines],
            segments=segments,
            floor=self.floor[lines],
        )

    @property
    def noise(self) -> FloatArray:
        """Mean square of the e_ij of one segment, (n_freq,): noise power of the minors over their size."""
        each = self.values[:, None, : self.order] * self.values[:, self.order :, None] / self.gaps**2
        return np.asarray(np.maximum(each.mean(axis=(1, 2)), 1e-15))

    def minors(self, rows: NDArray[np.intp], lines: slice = slice(None)) -> ComplexArray:
        """The minors of some rows, (n_freq, n_minors); all of them are a vector of unit norm."""
        return minors_of(self.vectors[lines, :, : self.order], rows)

    def moves(self, rows: NDArray[np.intp], lines: slice) -> ComplexArray:
        """What each segment would move the minors by, (n_lines, n_minors, n_segments), to first order."""
        assert self.segments is not None
        vectors, x = self.vectors[lines], self.segments.at(lines)
        along = vectors.conj().transpose(0, 2, 1) @ x
        e = along[:, self.order :, None] * along[:, None, : self.order].conj()
        e /= self.gaps[lines][..., None]
        t = tangents(vectors[:, :, : self.order], vectors[:, :, self.order :], rows)
        return np.asarray(t.reshape(*t.shape[:2], -1) @ e.reshape(len(e), -1, e.shape[3]))


def subspaces(averages: Averages, order: int) -> Subspaces:
    """Those of averaged spectra."""
    spectra = averages.spectra
    start = spectra.noise if spectra.noise is not None else spectra.noise_power
    noise = noise_beside(spectra.matrix, start, order)
    values, vectors = subspace(spectra.matrix, noise)
    floor = floor_of(values, order)
    segments = spectra.segments
    if segments is not None:
        segments = segments.times(1.0 / np.sqrt(noise * floor[:, None]))
    return Subspaces(spectra.freq_hz, values / floor[:, None], vectors, segments, order, floor)


@dataclass(frozen=True, kw_only=True)
class MinorLines(Lines):
    """Minors of the ``rows`` (n_minors, r) of ``subspaces``; the segments are those of the channels.

    Of the power at a line the window puts the shares ``leakage`` one line, two lines ... to either side; a
    segment shares samples with so many ``overlapping`` ones after it.
    """

    subspaces: Subspaces
    rows: NDArray[np.intp]
    leakage: FloatArray
    overlapping: int = 0

    def part(self, first: int, last: int) -> Self:
        """Some of the lines."""
        return replace(super().part(first, last), subspaces=self.subspaces.part(slice(first, last)))


def lines_of_minors(averages: Averages, some: Subspaces, rows: NDArray[np.intp]) -> MinorLines:
    """The vectors of some minors, with the subspaces that they are of."""
    vectors = some.minors(rows)
    share = np.sum(np.abs(vectors) ** 2, axis=1)  # of all minors, some of which may be left out
    window = np.zeros(1) if averages.taper is None else np.abs(np.fft.fft(averages.taper)) ** 2
    overlapping = 0
    if averages.nperseg is not None:
        shared = averages.options.noverlap
        step = averages.nperseg - (averages.nperseg // 2 if shared is None else shared)
        overlapping = -(-averages.nperseg // step) - 1
    return MinorLines(
        some.freq_hz,
        unit(vectors.T),
        share / some.noise,
        averages.spectra.added_decay_per_s,
        some.segments if averages.spectra.n_averages >= 2 else None,
        *averages.scatter,
        least_snr=LEAST_SNR,
        order=some.order,
        subspaces=some,
        rows=rows,
        leakage=(window / max(window.sum(), 1e-300))[1 : LEAKS + 1],
        overlapping=overlapping,
    )


def _copies(matrix: ComplexArray) -> NDArray[np.bool_]:
    """Which pairs of channels are one signal up to a factor, of which no noise can be told."""
    total = matrix.real.sum(axis=0)
    root = np.sqrt(np.diag(total))
    same = np.abs(total / (root[:, None] * root)) > SAME
    return np.asarray(same[np.triu_indices(len(root), 1)])


class MinorsOfRecord:
    """The minors of a record: their names, and lines of those that are fitted together."""

    def __init__(self, rec: Recording, averages: Averages, order: int) -> None:
        check_channels(len(rec.dofs), order)
        n_averages = averages.spectra.n_averages
        if n_averages <= order:
            got = f"{n_averages} averages of {order} forces"
            remedy = "Record for longer, give a shorter nperseg, or hit every place several times."
            raise UnsuitableDataError("source", got, f"more than {order}", remedy)
        power = np.einsum("fii->i", averages.spectra.matrix).real
        require_live(power, rec.dofs, "no signal at all from {} in the band", "Recording")
        for pair, twice in zip(combinations(rec.dofs, 2), _copies(averages.spectra.matrix), strict=True):
            if twice:
                got, remedy = f"one signal from dofs {pair[0]!r} and {pair[1]!r}", "Leave one of them out."
                raise UnsuitableDataError("source", got, "channels with noise of their own", remedy)
        self._averages, self._subspaces = averages, subspaces(averages, order)
        some = slice(None, None, -(-len(self._subspaces.values) // CHOICE_LINES))

        def size(rows: NDArray[np.intp]) -> FloatArray:
            return np.asarray(np.median(np.abs(self._subspaces.minors(rows, some)) ** 2, axis=0))

        named = formed(size, rec.dofs, order)
        heard = np.flatnonzero(self._heard(named.rows, some))
        if heard.size < 2:
            got = f"{heard.size} of {len(named.rows)} sets of {order} responses above noise"
            remedy = "Name as many forces as act, force harder, or add channels."
            raise UnsuitableDataError("source", got, "two or more, which are compared", remedy)
        self.dofs, self._rows = tuple(named.dofs[k] for k in heard), named.rows[heard]
        self.silent = tuple(dof for k, dof in enumerate(named.dofs) if k not in heard)

    def _heard(self, rows: NDArray[np.intp], some: slice) -> NDArray[np.bool_]:
        """Which minors are more than noise at the median line that tells anything.

        Those of responses that the forces reach through fewer than r paths are zero.
        """
        known = 1.0 / self._subspaces.noise[some] >= LEAST_SNR
        if not known.any():
            return np.zeros(len(rows), dtype=bool)
        moved = np.mean(np.abs(self._subspaces.moves(rows, some)) ** 2, axis=2)
        noise = moved / self._averages.spectra.n_effective
        ratio = np.abs(self._subspaces.minors(rows, some)) ** 2 / np.maximum(noise, 1e-300)
        middle = np.median(ratio[known], axis=0)
        return np.asarray(middle > max(LEAST_RATIO, SILENT_SHARE * float(np.median(middle))))

    @cached_property
    def lines(self) -> MinorLines:
        """Lines of the minors."""
        return lines_of_minors(self._averages, self._subspaces, self._rows)

    def directions(
        self, matrix: ComplexArray, scale: FloatArray
    ) -> tuple[FloatArray, FloatArray, ComplexArray]:
        """The same minors in other spectra, as ``dominant`` gives the direction of all responses."""
        values, vectors = subspace(matrix, scale)
        floor = floor_of(values, self._subspaces.order)
        made = Subspaces(np.empty(0), values, vectors, None, self._subspaces.order, floor)
        signal = 1.0 / replace(made, values=values / floor[:, None]).noise
        return signal * floor, floor, unit(made.minors(self._rows), axis=1)


# -- The minors of curves that were measured one force after the other: FRFs are columns of H, and of
# transmissibilities every column has a factor of its own, which goes into that of the minors


class MinorResponse(FrequencyResponse):
    """The minors of r responses, one a force, which it holds too; its dofs are sets of r dofs."""

    columns: tuple[FrequencyResponse, ...]

    def __init__(self, columns: Sequence[FrequencyResponse], *parts: Any, **named: Any) -> None:
        super().__init__(*parts, **named)
        object.__setattr__(self, "columns", tuple(columns))

    def rows(self, rows: NDArray[np.intp]) -> FrequencyResponse:
        """Some of the minors."""
        std = None if self.std is None else self.std[rows]
        dofs = [self.dofs[k] for k in rows]
        return FrequencyResponse(self.freq_hz, self.values[rows], dofs, self.kind, self.reference, std=std)

    @property
    def groups(self) -> list[NDArray[np.intp]]:
        """Rows that are fitted together; the reference is in all."""
        size = np.linalg.norm(self.values, axis=0)
        strength = np.median(np.abs(self.values / np.maximum(size, 1e-300)) ** 2, axis=1)
        if self.reference is not None:
            strength[self.dofs.index(self.reference)] = np.inf
        return groups(strength)


def _loud(values: ComplexArray) -> NDArray[np.bool_]:
    """Which minors are more than what damping and errors make of one that is zero."""
    power = np.abs(values) ** 2
    share = np.median(power / np.maximum(power.sum(axis=0), 1e-300), axis=1)
    return np.asarray(share > SILENT_SHARE * float(np.median(share)))


def _rough(curve: ComplexArray) -> float:
    """Noise over power at the median line, whatever the size of the curve beside it."""
    power = np.maximum(np.abs(curve[1:-1]) ** 2, 1e-300)
    return float(np.median(second_differences(curve) / power)) / GAIN


def minors_of_curves(source: Any, order: int) -> MinorResponse:
    """The minors of a list of r responses."""
    if isinstance(source, MinorResponse):
        return source
    if not isinstance(source, list | tuple) or len(source) != order:
        count = len(source) if isinstance(source, list | tuple) else 1
        wanted = f"{order} of them, one for each force"
        remedy = "Measure one force after the other; of repeats with one force give one average."
        reject("source", f"{count} FrequencyResponse{'s' * (count != 1)} for {order} forces", wanted, remedy)
    first = source[0]
    columns = [as_first(first, one, Argument("source").item(i)) for i, one in enumerate(source)]
    basis = np.stack(columns, axis=-1).transpose(1, 0, 2)
    some = basis[:: -(-len(basis) // CHOICE_LINES)]
    strength = np.linalg.norm(some, axis=1, keepdims=True)

    def size(rows: NDArray[np.intp]) -> FloatArray:
        unit_columns = some / np.maximum(strength, 1e-300)
        return np.asarray(np.median(np.abs(minors_of(unit_columns, rows)) ** 2, axis=0))

    named = formed(size, first.dofs, order)
    values = minors_of(basis, named.rows).T
    heard = np.flatnonzero(_loud(values) & [bool(one.any()) and _rough(one) < ROUGH for one in values])
    if heard.size < 2:
        got = f"{heard.size} of {len(values)} sets of {order} responses that change smoothly"
        wanted = "two or more, which are compared"
        raise UnsuitableDataError("source", got, wanted, "Measure with forces at different places.")
    named = Named(named.rows[heard], tuple(named.dofs[k] for k in heard))
    values = values[heard]
    std = None
    if all(one.std is not None for one in source):
        of_each = np.stack([one.std[[one.dofs.index(dof) for dof in first.dofs]] for one in source], axis=-1)
        variance = of_each.transpose(1, 0, 2) ** 2
        n = len(first.dofs)
        std = np.empty(values.shape)
        for lines in pieces(len(basis), values.shape[0] * n * order):
            others = np.broadcast_to(np.eye(n, dtype=np.complex128), (len(basis[lines]), n, n))
            by_value = np.abs(tangents(basis[lines], others, named.rows)) ** 2
            std[:, lines] = np.sqrt(np.einsum("fmpj,fpj->mf", by_value, variance[lines]))
    if first.kind == "frf":
        return MinorResponse(source, first.freq_hz, values, named.dofs, std=std)
    strongest = int(np.argmax(size(named.rows)))
    below = np.where(np.abs(values[strongest]) < 1e-300, 1e-300, values[strongest])
    reference = named.dofs[strongest]
    std = None if std is None else std / np.abs(below)
    return MinorResponse(
        source, first.freq_hz, values / below, named.dofs, "transmissibility", reference, std=std
    )

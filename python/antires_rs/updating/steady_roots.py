"""Roots of the intact model that a test shows, and how far they can be counted on.

The smallest damage that can be seen is told from the antiresonances that the intact structure has and a
damaged one still has, elsewhere. Not counted are those that a test of that kind does not show: the ones of
all responses for transmissibilities, those on a resonance for FRFs, with a margin within which no test tells
two of them apart; nor new ones, made of zeros that were complex.

Others count less or not at all, since small differences between the members move them far, damage or not:
where a symmetric response is weak and hangs on these differences, or where two roots are all but one. The
sensitivities of an ordinary root to all stiffnesses add up to about one, for it goes with the common scale of
K: a hundredth everywhere moves omega squared by a hundredth. Without this any asymmetry, of a thousandth,
would pass for damage.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..measured.antiresonance_set import AntiresonanceSet
from ..support.checks import FloatArray

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel


# -- Measured values that are no antiresonances: halves of complex zeros
#
# Between two antiresonances of the undamped structure that have met, H_ik no longer vanishes at any
# frequency: its zeros are complex, x = a + jb and a - jb, or f (1 + j d) and f (1 - j d) in frequency. With
# damping zeta they lie at damping ratios near zeta + d and zeta - d. Identification keeps the first, if it
# looks like a strongly damped antiresonance. A model has no real root there, and the nearest is another
# one; so such a value is left out, and named.
#
# Of sets with damping ratios a value is one of these if
#
# - the nominal model has a complex zero nearer to it than any real root, and its damping is nearer to a half
#   of that than to the median of the set;
# - or that zero is so much nearer than any real root that damping need not tell, as where two antiresonances
#   have just met;
# - or, whatever the model has, its damping differs from the median by more than 2 % and by more than twice
#   the median.


#: Damping ratios whose median says what is usual.
_LEAST_KNOWN = 4
#: Zeros less complex than this lie beside a double antiresonance; more complex ones are no dips.
_LEAST, _MOST = 0.005, 0.15
#: Imaginary parts up to this share are rounding.
_REAL = 1e-6
#: A model is right to this share in frequency.
_REACH = 0.10
#: A complex zero within the first share of the value, with no real root within the second, tells by itself.
_CLEAR, _FAR = 0.01, 0.05
#: Differences from the median that no antiresonance has: absolute, and as a multiple of it.
_ODD, _ODD_TIMES = 0.02, 2.0
#: Modes up to this multiple of the band make the series.
_MODES = 6.0


def complex_zeros(
    model: StructuralModel,
    response: int,
    excitation: int,
    f_max_hz: float,
    parts: tuple[float, float] = (_LEAST, _MOST),
) -> tuple[FloatArray, FloatArray]:
    """Complex zeros f (1 + j d) of an undamped response up to a frequency: f in Hz, and d within ``parts``.

    Zeros of the modal series, eigenvalues x of the pencil ``[[L - x, phi_k], [phi_i', 0]]`` with L the
    diagonal of the eigenvalues.
    """
    from scipy.linalg import eigvals

    modes = model.modes(f_max_hz=_MODES * f_max_hz)
    n = modes.freq_hz.size
    # In units of the band, so that the lowest are not lost in rounding.
    pencil, mass = np.zeros((n + 1, n + 1)), np.eye(n + 1)
    pencil[np.arange(n), np.arange(n)] = (modes.freq_hz / f_max_hz) ** 2
    shapes = modes.shapes.real / np.abs(modes.shapes).max(initial=1e-300)
    pencil[:n, n], pencil[n, :n] = shapes[:, excitation], shapes[:, response]
    mass[n, n] = 0.0
    upper, lower = eigvals(pencil, mass, homogeneous_eigvals=True)
    finite = np.abs(lower) > 1e-12 * np.abs(upper)
    root = np.sqrt((upper[finite] / lower[finite]).astype(complex))
    freq = np.abs(root) * f_max_hz
    part = np.abs(root.imag) / np.abs(root)
    kept = (root.imag > 0.0) & (part > parts[0]) & (part <= parts[1]) & (freq <= f_max_hz)
    order = np.argsort(freq[kept])
    return freq[kept][order], part[kept][order]


def of_one_kind(
    model: StructuralModel,
    sets: Sequence[AntiresonanceSet],
    dofs: Sequence[Sequence[int]],
    forces: Sequence[int],
) -> tuple[list[list[NDArray[np.bool_]]], tuple[str, ...]]:
    """For each set and response which values are antiresonances, and a sentence on each that is not."""
    masks, notes = [], []
    for found, numbers, force in zip(sets, dofs, forces, strict=True):
        tables = list(found.tables.values())
        of_set = [np.ones(len(table), dtype=bool) for table in tables]
        masks.append(of_set)
        usual = usual_damping(found)
        if usual is None:
            continue
        limit_hz = looked_up_to(max(found[dof].max(initial=0.0) for dof in found))
        real = real_zeros(model, numbers, force, limit_hz)
        for label, table, dof, roots, keep in zip(found, tables, numbers, real, of_set, strict=True):
            series = partial(zero_series, model, dof, force, limit_hz)
            notes += sorted_out(label, table, usual, roots, series, keep)
    return masks, tuple(notes)


def looked_up_to(highest_hz: float) -> float:
    """The frequency up to which zeros of the model count, beside values up to ``highest_hz``."""
    return (1.0 + 2.0 * _REACH) * highest_hz


def real_zeros(
    model: StructuralModel, responses: Sequence[int], force: int, limit_hz: float
) -> list[FloatArray]:
    """All real zeros (Hz) of each response, those on a pole too."""
    core, rows = model._core_for([*responses, force])
    return [f for f, *_ in core.antiresonances(rows[:-1], rows[-1], limit_hz, "modal", True)]


def zero_series(
    model: StructuralModel, response: int, force: int, limit_hz: float
) -> tuple[FloatArray, FloatArray]:
    """All complex zeros that may pass for an antiresonance, as :func:`complex_zeros` gives them."""
    return complex_zeros(model, response, force, limit_hz, (_REAL, _MOST))


def usual_damping(found: AntiresonanceSet) -> float | None:
    """The median damping ratio of a set; None where too few are known."""
    known = np.concatenate([np.empty(0), *(table.damping_ratio for table in found.tables.values())])
    known = known[np.isfinite(known)]
    return float(np.median(known)) if known.size >= _LEAST_KNOWN else None


def sorted_out(
    label: object,
    table: Any,
    usual: float,
    roots: FloatArray,
    series: Callable[[], tuple[FloatArray, FloatArray]],
    keep: NDArray[np.bool_],
) -> list[str]:
    """Sentences on the values of a response that are no antiresonances, which ``keep`` then tells; ``roots``
    (Hz) are the model's real ones, ``series`` computes the complex ones."""
    excess = np.abs(table.damping_ratio - usual)
    to_real = np.abs(table.freq_hz[:, None] - roots).min(axis=1, initial=np.inf)
    odd = ((excess > _LEAST / 2.0) | (to_real > _FAR * table.freq_hz)) & ~table.by_hand
    if not odd.any():
        return []
    zeros, notes = series(), []
    for at in np.flatnonzero(odd & np.isfinite(excess)):
        freq = float(table.freq_hz[at])
        why = _complex(freq, float(excess[at]), usual, float(to_real[at]), *zeros)
        if why:
            keep[at] = False
            notes.append(
                f"Left out: {freq:.2f} Hz at dof {label}, damped by "
                f"{100 * table.damping_ratio[at]:.1f} % (usual: {100 * usual:.1f} %): {why}."
            )
    return notes


def _complex(
    freq: float, excess: float, usual: float, to_real: float, hz: FloatArray, part: FloatArray
) -> str:
    """Why a value is not an antiresonance; nothing if it is one."""
    apart = np.abs(hz - freq)
    told = (apart <= min(to_real, _REACH * freq)) & (part >= _LEAST) & (excess > part / 2.0)
    told |= (apart <= _CLEAR * freq) & (to_real > _FAR * freq)
    near = np.flatnonzero(told)
    if near.size:
        at = near[np.argmin(apart[near])]
        return f"half of a complex zero, in the model {hz[at]:.2f} Hz (1 \u00b1 {part[at]:.3f}j)"
    if excess > max(_ODD, _ODD_TIMES * usual):
        return "half of a complex zero, or spurious; the model has real antiresonances only"
    return ""


#: Roots of all responses within this share are taken for one: a hidden mode, with double roots beside it that
#: hardly any difference between the members splits by so much.
_SHARED = 0.02
#: A root this near to a resonance, in Hz, is not told from it in an FRF.
_ON_POLE = 0.005
#: Loss of stiffness by which a root is tried.
STEP = 0.005
#: Sum of the sensitivities of omega squared up to which a root counts in full, and from which on it does not
#: count. By far most roots of symmetric chains, rings, frames and grillages have 1 to 3, those that a broken
#: symmetry makes, or one that is all but double, 10 to 10000.
_ORDINARY, _UNSTEADY = 3.0, 6.0
#: Intact roots are as good as one if they lie within this share.
_TWIN = 0.01
#: Complex zeros with such shares of imaginary part may become antiresonances by a small change.
_COMPLEX = (1e-6, 0.3)


def roots_of(
    model: StructuralModel, dofs: list[int], force: int, limit_hz: float, cancelled: bool
) -> list[FloatArray | None]:
    """Roots of each response; None of one that does not respond at all."""
    core, rows = model._core_for([*dofs, force])
    found = core.antiresonances(rows[:-1], rows[-1], limit_hz, "modal", cancelled)
    return [None if silent else freq for freq, silent, _ in found]


def steady(
    model: StructuralModel,
    moved: Sequence[StructuralModel],
    dofs: list[int],
    force: int,
    limit_hz: float,
    sees: Any,
    channels: list[int],
) -> list[tuple[FloatArray, FloatArray]]:
    """Roots of each response and their weights, 0 for those that do not count, complex ones among them.

    ``moved`` are the models with one stiffness less by ``STEP``.
    """
    every = {
        dof: None if freq is None else (freq, complex_zeros(model, dof, force, limit_hz, _COMPLEX)[0])
        for dof, freq in _by_dof(model, {*dofs, *channels}, force, limit_hz).items()
    }
    none = (np.empty(0), np.empty(0))
    own = [(every[dof] or none)[0] for dof in dofs]
    hidden = (
        _hidden(dofs, every, channels)
        if sees == "transmissibility"
        else _on_poles(own, model, limit_hz, sees)
    )
    change = [np.zeros(freq.size) for freq in own]
    for other in moved:
        for nth, freq in enumerate(roots_of(other, dofs, force, 1.1 * limit_hz, True)):
            if own[nth].size:
                now = np.full(1, np.inf) if freq is None or not freq.size else freq
                nearest = now[np.abs(own[nth][:, None] - now).argmin(axis=1)]
                change[nth] += np.abs((nearest / own[nth]) ** 2 - 1.0) / STEP
    found = []
    for dof, freq, unseen, total in zip(dofs, own, hidden, change, strict=True):
        weight = np.clip((_UNSTEADY - total) / (_UNSTEADY - _ORDINARY), 0.0, 1.0) * ~unseen
        others = (every[dof] or none)[1]
        found.append((np.append(freq, others), np.append(weight, np.zeros(others.size))))
    return found


def followed(own: tuple[FloatArray, FloatArray], now: FloatArray | None) -> tuple[FloatArray, FloatArray]:
    """Of the roots that are there now, those that an intact one has become, with its weight.

    The nearest pairs go first, one to one. One that is left to an intact root farther away than others is of
    unknown descent, and does not count.
    """
    roots, weights = own
    if now is None or not now.size or not roots.size:
        return np.empty(0), np.empty(0)
    apart = np.abs(roots[:, None] - now)
    nearest = apart.min(axis=0) + _TWIN * now
    kept = np.zeros(now.size)
    for _ in range(min(apart.shape)):
        row, column = np.unravel_index(np.argmin(apart), apart.shape)
        kept[column] = weights[row] * (apart[row, column] <= nearest[column])
        apart[row], apart[:, column] = np.inf, np.inf
    return now[kept > 0.0], kept[kept > 0.0]


def _by_dof(
    model: StructuralModel, dofs: set[int], force: int, limit_hz: float
) -> dict[int, FloatArray | None]:
    """All roots by response."""
    ordered = sorted(dofs)
    return dict(zip(ordered, roots_of(model, ordered, force, limit_hz, True), strict=True))


def _hidden(
    dofs: list[int], every: dict[int, tuple[FloatArray, FloatArray] | None], channels: list[int]
) -> list[NDArray[np.bool_]]:
    """Which roots of each response all others share, also where theirs have just become complex."""
    found = []
    for dof in dofs:
        freq = (every[dof] or (np.empty(0),))[0]
        others = [every[other] for other in channels if other != dof]
        shared = [_near(freq, np.concatenate(both), _SHARED) for both in others if both is not None]
        found.append(np.logical_and.reduce(shared or [np.zeros(freq.size, dtype=bool)]))
    return found


def _on_poles(
    own: list[FloatArray], model: StructuralModel, limit_hz: float, sees: Any
) -> list[NDArray[np.bool_]]:
    """Which roots an FRF does not show, for they lie on a resonance; where that is not known, none."""
    poles = model.modes(f_max_hz=1.1 * limit_hz).freq_hz if sees == "frf" else np.empty(0)
    return [_near(freq, poles, _ON_POLE) for freq in own]


def _near(freq: FloatArray, others: FloatArray, within: float) -> NDArray[np.bool_]:
    """Whether one of the others is this near."""
    apart = np.abs(freq[:, None] - others)
    return np.asarray(apart.min(axis=1, initial=np.inf) <= within * freq)

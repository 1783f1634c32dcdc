"""Two states of the structures of reference/outside_structures.py, and what answers to them are right."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import antires_rs as ar
from reference.outside_records import damping_drawn, recorded
from reference.outside_structures import STRUCTURES, Crack, State, Structure, measured

#: Relative scatter of the values, stated as it is; one for each case, log-uniform between these.
STD = (1e-4, 1e-3)
#: Losses of elements and cracks, log-uniform; of springs that soften and joints that loosen; masses added,
#: log-uniform over the whole mass; largest change of E, and the gradient over it.
LOSS, CONNECTION, ADDED, WARMER, GRADIENT = (0.05, 0.60), (0.15, 0.60), (5e-3, 5e-2), 0.03, 1 / 3
#: A hinge in a cantilever's damaged element is so far from its ends, and as far from its middle.
_OFF_END, _OFF_MIDDLE = 0.1, 0.1
#: Relative change beyond which a value is a new one.
_NEW = 0.2


@dataclass(frozen=True)
class Case:
    """Measured states and the truth behind them.

    ``allowed`` holds for every damage the elements one of which a right answer names, and no others;
    ``touching`` the elements that the place of another change belongs to; ``may_shift`` tells that a change
    of all values alike is right too.
    """

    structure: Structure
    kind: str
    number: int
    state: State
    allowed: tuple[frozenset[int], ...]
    touching: frozenset[int]
    before: ar.AntiresonanceSet
    now: ar.AntiresonanceSet
    std: float
    change_in_std: float  # rms of exact values to the nearest of their response

    @property
    def may_shift(self) -> bool:
        """Whether a change of all values alike is right too."""
        return self.state.warmer != (0.0, 0.0)

    @property
    def losses(self) -> dict[int, float]:
        """What a right answer tells of severity; of a crack the loss that is as flexible."""
        return {**self.state.losses, **{crack.element: crack.loss for crack in self.state.cracks}}


def _between(rng, limits) -> float:
    return float(np.exp(rng.uniform(*np.log(limits))))


def _damage(structure, rng, count) -> State:
    """So many elements: of the cantilever hinges off their middles, elsewhere losses."""
    hit = rng.choice(structure.n_elements, size=count, replace=False)
    losses = {int(e): _between(rng, LOSS) for e in sorted(hit)}
    if structure.name != "cantilever":
        return State(losses=losses)
    half = 0.5 - _OFF_END - _OFF_MIDDLE
    shares = (
        _OFF_END
        + half * rng.random(count)
        + np.where(rng.random(count) < 0.5, 0.0, 0.5 + _OFF_MIDDLE - _OFF_END)
    )
    return State(
        cracks=tuple(Crack(e, float(s), loss) for (e, loss), s in zip(losses.items(), shares, strict=True))
    )


def _mass(structure, rng, number) -> State:
    node = int(rng.choice(structure.nodes))
    return State(added_kg={node: _between(rng, ADDED) * structure.total_kg})


def _support(structure, rng, number) -> State:
    return State(supports={int(rng.integers(structure.n_supports)): _between(rng, CONNECTION)})


def _joint(structure, rng, number) -> State:
    return State(joints={int(rng.integers(len(structure.joints))): _between(rng, CONNECTION)})


def _sensor(structure, rng, number) -> State:
    return State(moved=int(rng.choice(structure.telling)))


def _temperature(structure, rng, number) -> State:
    """Every second one is damaged as well."""
    uniform = rng.uniform(-WARMER, WARMER)
    gradient = GRADIENT * abs(uniform) * rng.choice((-1.0, 1.0))
    losses = _damage(structure, rng, number % 2)
    return State(losses.losses, losses.cracks, warmer=(float(uniform), float(gradient)))


def _crack(structure, rng, number) -> State:
    crack = Crack(int(rng.integers(structure.n_elements)), float(rng.random()), _between(rng, LOSS))
    return State(cracks=(crack,))


#: By kind: draws a state of a structure.
KINDS: dict[str, Callable[[Structure, np.random.Generator, int], State]] = {
    "intact": lambda structure, rng, number: State(),
    "single": lambda structure, rng, number: _damage(structure, rng, 1),
    "double": lambda structure, rng, number: _damage(structure, rng, 2),
    "mass": _mass,
    "support": _support,
    "joint": _joint,
    "sensor": _sensor,
    "temperature": _temperature,
    "crack": _crack,
}
#: What no loss of an element is.
OUTSIDE = ("mass", "support", "joint", "sensor")


def kinds_of(structure: Structure) -> list[str]:
    """Kinds that a structure has: chains and trusses have no cracks."""
    if structure.cracks_alone:
        return ["crack"]
    return [kind for kind in KINDS if structure.beams or kind != "crack"]


def case(name: str, kind: str, number: int, seed: int = 0, *, records: bool = False) -> Case:
    """The same for the same arguments. Of ``records`` under the noise of a shaker, as somebody measures
    them, the values are those identified."""
    structure = STRUCTURES[name]
    rng = np.random.default_rng([seed, list(STRUCTURES).index(name), list(KINDS).index(kind), number])
    own, std = structure.drawn(rng), _between(rng, STD)
    state = KINDS[kind](structure, rng, number)
    intact, present = structure.truth(own), structure.truth(own, state)
    if records:
        damping = damping_drawn(rng)
        before, now = (
            ar.identify_antiresonances(
                recorded(structure, own, each, damping, rng),
                excitation=structure.force,
                band_hz=structure.band_hz,
                progress=False,
            )
            for each in (State(), state)
        )
        std = float(np.median(np.concatenate([now.std_hz[dof] / now[dof] for dof in now])))
    else:
        before, now = (measured(structure, exact, std, rng) for exact in (intact, present))
    allowed, touching = _right(structure, state)
    return Case(
        structure, kind, number, state, allowed, touching, before, now, std, _changed(intact, present, std)
    )


def _right(structure: Structure, state: State) -> tuple[tuple[frozenset[int], ...], frozenset[int]]:
    """Elements for every damage; elements at the place of another change."""
    allowed = [frozenset((e,)) for e in state.losses]
    for crack in state.cracks:
        nearer = structure.beside(crack.element, int(crack.share > 0.5))
        allowed.append(frozenset((crack.element,) if nearer is None else (crack.element, nearer)))
    touching = [structure.joints[joint] for joint in state.joints]
    touching += [
        frozenset((structure.support_elements[i],)) for i in state.supports if structure.support_elements
    ]
    return tuple(allowed), frozenset().union(*touching)


def _changed(intact, present, std) -> float:
    """Against the scatter of a difference; a value that is new or lost counts as much as one far off."""
    found = [
        np.abs(f / there[dof] - 1.0).min(initial=_NEW)
        for here, there in ((present, intact), (intact, present))
        for dof, freq in here.items()
        for f in freq
    ]
    return float(np.sqrt(np.mean(np.square(found)) / 2.0) / std)

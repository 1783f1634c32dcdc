"""What a damage assessment may be told: what is believed before the test, and the options of the search."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import comb
from typing import Any

import numpy as np

from ..exceptions import reject
from ..support.checks import finite_scalar
from ..support.options import Options, documented, option

#: Scopes of options: two states that are compared, or one state and the model.
TWO_STATES, ONE_STATE = "with a baseline", "without a baseline"
SURROUNDINGS = ("temperature", "supports", "mass")  # what may differ between two tests beside damage
_PRICE: dict[str, Any] = {"kind": "number", "low": 0.0, "scope": ONE_STATE}


@documented
@dataclass(frozen=True, kw_only=True)
class SearchOptions(Options):
    """How damage is sought and declared: options that few calls need.

    Those of the search with a baseline are refused without one, and the other way round. 0.0005 of
    ``std_common`` is three kelvin of steel. On reduced models hypotheses that have a share in the answer are
    judged where reduced and full model agree to 1e-6, as ``reduction`` of the result tells. ``gamma1`` and
    ``gamma2`` are as :meth:`DamagePenalty.scaled` gives them, the paper's are 0.1 and 0.1; ``weights`` as for
    :class:`UpdatingProblem`, ``x0`` (n,) or (m, n).

    Attributes
    ----------
    {options}

    Raises
    ------
    InvalidInputError
        A value out of its range, when the options are used.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.SearchOptions(false_alarm_rate=0.05).false_alarm_rate, ar.SearchOptions().std_common
    (0.05, 0.0005)
    """

    false_alarm_rate: float | None = option(
        None,
        "Share of intact tests in which damage may be declared, up to 0.5; by default damage is declared "
        "where it is more probable than none.",
        kind="number",
        low=0.0,
        high=0.5,
        low_open=True,
        scope=TWO_STATES,
    )
    std_common: float = option(
        5e-4,
        "Relative standard deviation of what moves all values alike between two tests, such as temperature; "
        "up to 0.1.",
        low=0.0,
        high=0.1,
        scope=TWO_STATES,
    )
    environment: tuple[str, ...] | None = option(
        None,
        'What else may differ between the two tests, with standard deviations: "temperature" (modulus of '
        'all elements, not of springs, 2 %, and along the longer side 1 %), "supports" (all springs, 10 %), '
        '"mass" (all masses, 2 %).',
        kind="names",
        scope=TWO_STATES,
    )
    reduction: str | bool = option(
        "auto",
        "Whether antiresonances are sought on reduced models; by default for more than 600 dofs.",
        kind="value",
        choices=("auto", True, False),
        scope=TWO_STATES,
    )
    gamma1: float | None = option(
        None, "Price of a unit of stiffness loss; by default 0.1 for 28 values.", **_PRICE
    )
    gamma2: float | None = option(
        None, "Price of each damaged element; by default 0.1 for 28 values.", **_PRICE
    )
    snap: float = option(1e-3, "Losses below it are exactly 0.", low=0.0, high=1e-3, scope=ONE_STATE)
    weights: Any = option(
        None, '"std", so that what is known badly counts less.', kind="text", scope=ONE_STATE
    )
    x0: Any = option(None, "Guesses that join the initial populations.", kind="value", scope=ONE_STATE)

    @property
    def prices(self) -> tuple[float | None, float | None, float]:
        """Those of damage without a baseline, and what counts as none."""
        return self.gamma1, self.gamma2, self.snap

    def of(self, scope: str, **others: Any) -> SearchOptions:
        """The same, checked; options that have no effect in this kind of assessment are refused, and
        ``others``, arguments of the call that count in the other kind alone."""
        declared = {name: said for name, said in self.declared().items() if said.scope != scope}
        when = ONE_STATE if scope == TWO_STATES else "together with a baseline"
        for name, value in (others | {name: getattr(self, name) for name in declared}).items():
            usual = declared[name].default if name in declared else None
            if not (value is None or value is False or (np.ndim(value) == 0 and value == usual)):
                reject(name, value, f"None: it counts only {when}", f"Leave {name} out.")
        if self.environment is not None:
            known = ", ".join(map(repr, SURROUNDINGS))
            given = (self.environment,) if isinstance(self.environment, str) else self.environment
            if not isinstance(given, (tuple, list)) or any(each not in SURROUNDINGS for each in given):
                remedy = "As in environment = ['temperature']."
                reject("environment", self.environment, f"a list of some of {known}", remedy)
            return replace(self, environment=tuple(given)).checked()
        return self.checked()

    def held(self, scope: str) -> dict[str, Any]:
        """Every option that counts by name, in plain data."""
        own = {name: getattr(self, name) for name in options_with(scope)}
        return {name: np.asarray(v).tolist() if np.ndim(v) else v for name, v in own.items()}


def options_with(scope: str) -> list[str]:
    """Names of the options that count in one kind of assessment."""
    return [name for name, said in SearchOptions.declared().items() if said.scope == scope]


def sorted_out(options: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of ``assess_damage`` with options of the search among them, as it takes them."""
    own = {name: value for name, value in options.items() if name in SearchOptions.declared()}
    rest = {name: value for name, value in options.items() if name not in own}
    if not own:
        return rest
    return {**rest, "search": (rest.get("search") or SearchOptions()).joined(own)}


# -- What is believed of the damage before the test


@dataclass(frozen=True)
class DamagePrior:
    """Probabilities, before the test, of how many elements are damaged; they add up to one.

    Within each number all sets of candidates are equally probable, and every severity from 0 to 0.99 is.

    Attributes
    ----------
    nothing : float
        No damage.
    one, two, three : float
        One, two or three of the candidates.
    elsewhere : float
        One stiffness of the model that is no candidate; counts as ``unknown`` where there is none.
    unknown : float
        A change that no stiffness of the model explains.

    Raises
    ------
    InvalidInputError
        A probability outside [0, 1], or a sum that is not one.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.DamagePrior(nothing=0.9, one=0.07, two=0.01, three=0.0, elsewhere=0.01, unknown=0.01).nothing
    0.9
    """

    nothing: float = 0.50
    one: float = 0.36
    two: float = 0.06
    three: float = 0.01
    elsewhere: float = 0.05
    unknown: float = 0.02

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            finite_scalar(name, value, low=0.0, high=1.0)
        if not np.isclose(sum(vars(self).values()), 1.0, rtol=0.0, atol=1e-9):
            got = f"probabilities with the sum {sum(vars(self).values()):g}"
            reject("prior", got, "probabilities that add up to one", "Give all six, or leave the prior out.")

    def log_of(self, n_damaged: int, n_candidates: int) -> float:
        """Log probability of each set of so many candidates."""
        share = (self.nothing, self.one, self.two, self.three)[n_damaged]
        return float(np.log(share) - np.log(comb(n_candidates, n_damaged))) if share else -np.inf

    def log_elsewhere(self, n_others: int) -> float:
        """Log probability of each element that is no candidate."""
        return float(np.log(self.elsewhere) - np.log(n_others)) if self.elsewhere else -np.inf

    def log_unknown(self, n_others: int) -> float:
        """Log probability of something else."""
        share = self.unknown + (0.0 if n_others else self.elsewhere)
        return float(np.log(share)) if share else -np.inf


def checked_prior(prior: Any, options: SearchOptions) -> DamagePrior:
    """What is believed before the test; a rate of false alarms needs some that there is none."""
    if prior is not None and not isinstance(prior, DamagePrior):
        reject("prior", prior, "a DamagePrior", "Leave it out for DamagePrior().")
    rate = options.false_alarm_rate
    if rate is not None and prior is not None and not (prior.nothing and prior.one):
        always = "always damage" if prior.nothing == 0.0 else "never damage of one element alone"
        wanted = f"None: by this prior there is {always}"
        reject("false_alarm_rate", rate, wanted, "Give prior.nothing and prior.one more than 0.")
    return prior or DamagePrior()

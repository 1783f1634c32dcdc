"""The options of an identification: one value, checked once, with the defaults in one place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ..exceptions import reject
from ..signals.averaging import Averaging
from ..support.checks import choice, integer
from .paper import OF_MAGNITUDES, check_formulation
from .rule import DEFAULTS, Rule, rule_options

# Beyond, a narrower band or windows serve better than more orders.
HIGHEST_ORDER = 200
ROUTES = ("transmissibility", "frf")
ESTIMATORS = ("rank1", "h1", "h2", "hv")
CROSS_CHECKS = (None, "aaa", "vector_fitting")
CHECKS = ("warn", "raise", "off")


@dataclass(frozen=True)
class IdentificationOptions:
    """How antiresonances are identified.

    Attributes
    ----------
    averaging : Averaging
        How a record is averaged, see :class:`~antires_rs.signals.averaging.Averaging`.
    route : {"transmissibility", "frf"}
        From the responses alone, or from FRFs.
    estimator : {"rank1", "h1", "h2", "hv"}
        Of the response vectors.
    formulation : {"auto", "windows", "numerators", "joint", "power", "eq10", "eq10_squared"}
        See :mod:`~antires_rs.identification.paper`.
    min_order, max_order : int
        Orders of the sweep.
    rule : Rule
        When a pole is stable and a value accepted, see :class:`~antires_rs.identification.rule.Rule`.
    keep_common : bool
        Keep values that all of three or more channels share.
    cross_check : {None, "aaa", "vector_fitting"}
        The method that is asked about every value.
    check : {"warn", "raise", "off"}
        What is done with the data check.
    given : frozenset of str
        Options of the choice that the caller gave, and no preset or default.
    """

    averaging: Averaging = field(default_factory=Averaging)
    route: str = "transmissibility"
    estimator: str = "rank1"
    formulation: str = "auto"
    min_order: int = 2
    max_order: int = DEFAULTS["max_order"]
    rule: Rule = field(default_factory=Rule)
    keep_common: bool = False
    cross_check: str | None = None
    check: str = "warn"
    given: frozenset[str] = frozenset()

    @property
    def use_force(self) -> bool:
        """Whether the force is a row of the response vectors."""
        return self.route == "frf"

    @property
    def orders(self) -> tuple[int, int]:
        """Lowest and highest order."""
        return self.min_order, self.max_order

    @property
    def most(self) -> int:
        """No order above it is fitted: the highest order where one was named, else what is allowed at all."""
        free = "max_order" not in self.given and self.max_order == DEFAULTS["max_order"]
        return HIGHEST_ORDER if free else self.max_order

    def checked(self) -> IdentificationOptions:
        """The same options, or an error that names the bad one."""
        choice("route", self.route, ROUTES)
        self.averaging.checked()
        choice("estimator", self.estimator, ESTIMATORS)
        choice("check", self.check, CHECKS)
        choice("keep_common", self.keep_common, (True, False))
        choice("cross_check", self.cross_check, CROSS_CHECKS)
        check_formulation(self.formulation)
        if self.formulation == "numerators" and self.estimator != "rank1":
            reject(
                "estimator",
                self.estimator,
                "'rank1' with formulation='numerators'",
                "That fit uses the whole spectral matrix; formulation='joint' takes any estimator.",
            )
        if self.use_force and self.formulation in OF_MAGNITUDES:
            reject(
                "formulation",
                self.formulation,
                "'numerators' or 'joint' with route='frf'",
                "Sums and magnitudes are those of transmissibilities.",
            )
        self.rule.checked()
        integer("max_order", self.max_order, low=2, high=HIGHEST_ORDER)
        integer("min_order", self.min_order, low=1, high=self.max_order)
        return self


#: The options of a call that gives none.
DEFAULT = IdentificationOptions()


#: Arguments of a call that are of the averages, and those of the rule: None stands for not given.
OF_AVERAGES = ("nperseg", "noverlap", "window", "method")
OF_RULE = (
    "freq_tol",
    "damping_tol",
    "min_rows",
    "max_damping",
    "min_dominance",
    "persistent",
    "min_share",
    "min_depth_db",
)


def options_of(given: Mapping[str, Any]) -> IdentificationOptions:
    """The options of a call out of its arguments by name: all but source, place, band, dofs and progress."""
    own = (*OF_AVERAGES, *OF_RULE)
    return checked_options(
        Averaging(*(given[name] for name in OF_AVERAGES)),
        rule={name: given[name] for name in OF_RULE},
        **{name: value for name, value in given.items() if name not in own},
    )


def checked_options(
    averaging: Averaging,
    preset: str | None,
    *,
    formulation: str | None,
    min_order: int,
    max_order: int | None,
    cross_check: str | None,
    second_opinion: str | None,
    rule: dict[str, Any],
    **others: Any,
) -> IdentificationOptions:
    """The options of a call: what is given beside a preset wins; None in ``rule`` stands for not given."""
    choice("persistent", rule["persistent"], (None, True, False))
    chosen = rule_options(preset, formulation=formulation, max_order=max_order, **rule)
    if formulation is None and others.get("route") == "frf" and chosen["formulation"] in OF_MAGNITUDES:
        # FRFs keep the preset's rule; sums and magnitudes are those of transmissibilities.
        chosen["formulation"] = "joint"
    if second_opinion is not None:
        choice("second_opinion", second_opinion, CROSS_CHECKS)
        if cross_check not in (None, second_opinion):
            reject(
                "second_opinion",
                second_opinion,
                f"None beside cross_check={cross_check!r}",
                "It is the older name of cross_check; give that alone.",
            )
        cross_check = second_opinion
    return IdentificationOptions(
        averaging,
        formulation=chosen.pop("formulation"),
        min_order=min_order,
        max_order=chosen.pop("max_order"),
        rule=Rule(**chosen),
        cross_check=cross_check,
        given=frozenset(
            name for name, value in {"max_order": max_order, **rule}.items() if value is not None
        ),
        **others,
    ).checked()

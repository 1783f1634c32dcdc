r"""The options of an identification: each is declared here once, with its sentence and its range.

Presets are named sets of them, :data:`PRESETS`. "paper" is the identification of V. Meruane, J. Sound Vib.
332 (2013) 807-820 (:mod:`~antires_rs.identification.paper`): stable within 1 % and 5 % in more than ten
consecutive orders, and no other test; with ``route="frf"`` by the joint fit. "strict" wants poles that own
their curve and stand still: for values that must be right. "sensitive" is for values that someone will look
at afterwards. ``min_share`` and ``min_depth_db`` are of fits over windows, ``damping_tol``, ``min_rows``,
``min_dominance`` and ``persistent`` of the sweep over orders.

On six states of a measured plate (80 clear dips; ``benchmarks/measured_identification.py --only presets``)
"strict", the default and "sensitive" find 77, 80 and 80 of them, with 2 of 114, 13 of 151 and 50 of 198
values without a dip; on simulated records see ``benchmarks/preset_tables.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exceptions import reject
from ..signals.averaging import METHODS, Averaging
from ..support.checks import FloatArray, integer
from ..support.options import Option, Options, documented, option

HIGHEST_ORDER = 200  # beyond, a narrower band or windows serve better than more orders
USUAL_ORDER = 60  # highest order of the sweep where neither the caller nor a preset names one
# Real numbers of data that an order needs: with fewer, poles follow the noise of single lines.
DATA_PER_ORDER = 3

FORMULATIONS = ("joint", "eq10", "eq10_squared")
OF_MAGNITUDES = FORMULATIONS[1:]  # real functions of f^2; one number a line
CHOICES = ("auto", "windows", "directions", "numerators", *FORMULATIONS)

PRESET_NAMES = ("paper", "strict", "sensitive")
#: By option: what each of these presets sets; None where it keeps the default.
_PRESET_TABLE: dict[str, tuple[Any, Any, Any]] = {
    "formulation": ("eq10_squared", None, None),
    "max_order": (70, None, None),
    "damping_tol": (0.05, 0.05, 0.30),
    "min_rows": (None, None, 5),
    "max_damping": (None, 0.05, 0.20),
    "min_dominance": (0.0, 0.90, 0.02),
    "persistent": (False, False, None),
    "min_share": (None, 0.8, 0.3),
    "min_depth_db": (None, 6.0, 2.0),
}
#: Options by name of the preset; what a preset does not mention is the default.
PRESETS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        preset: MappingProxyType({k: row[i] for k, row in _PRESET_TABLE.items() if row[i] is not None})
        for i, preset in enumerate(PRESET_NAMES)
    }
)


@dataclass(frozen=True, kw_only=True)
class CallOptions(Options):
    """The options that most calls need, arguments of their own of ``identify_antiresonances``."""

    preset: str | None = option(
        None,
        '"paper", "strict" or "sensitive": a named set of the options below.',
        kind="text",
        choices=(None, *PRESETS),
        flag="--preset WORD",
    )
    route: str = option(
        "transmissibility",
        '"transmissibility" reads responses only, "frf" uses a measured force.',
        choices=("transmissibility", "frf"),
        flag="--route WORD",
    )
    estimator: str = option("rank1", '"rank1", "h1", "h2" or "hv".', choices=("rank1", "h1", "h2", "hv"))
    nperseg: int | None = option(
        None, "Samples in a segment; by default chosen from the data.", kind="segment"
    )
    max_order: int | None = option(
        None,
        "Highest order of the stabilization diagram; by default as the data want. Of fits over windows "
        "16 at most.",
        kind="whole",
        low=2,
        high=HIGHEST_ORDER,
        flag="--max-order N>=2",
    )
    check: str = option(
        "warn",
        'What to do about data that are not fit: "warn", "raise" or "off".',
        choices=("warn", "raise", "off"),
    )


@documented
@dataclass(frozen=True, kw_only=True)
class FitOptions(Options):
    """How curves are fitted and which values are accepted: options that few calls need.

    What is given wins over a preset; see :mod:`antires_rs.identification.options` for those.

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
    >>> ar.FitOptions(min_rows=5).min_rows, ar.FitOptions().min_rows
    (5, 10)
    """

    left = dict.fromkeys(("cross_check", "second_opinion"), "it changed no value. Leave it out.")

    formulation: str = option(
        "auto",
        ", ".join(f'"{one}"' for one in CHOICES[:-1]) + f' or "{CHOICES[-1]}": what is fitted. "auto" takes '
        '"windows" for given curves and impacts with as little noise; for other records "numerators" if that '
        'fit predicts held-back segments to the noise, else "directions"; without estimator "rank1" "joint".',
        choices=CHOICES,
        flag="--formulation WORD",
    )
    method: str = option(
        "auto",
        '"auto", "welch" for random records, "transient" for impacts; "auto" looks at the energy profile.',
        choices=METHODS,
        flag="--method WORD",
    )
    noverlap: int | None = option(
        None, "Samples shared by neighbouring segments; by default half.", kind="segment"
    )
    window: Any = option(
        "hann",
        'Window of the segments, as for scipy.signal.get_window; for impacts "rectangular" or "exponential" '
        '("hann" there means: rectangular if the response dies, else exponential).',
    )
    min_order: int = option(2, "Lowest order of the stabilization diagram.", low=1)
    freq_tol: float = option(
        0.01,
        "Relative change of frequency from order to order that counts as stable.",
        low=0.0,
        high=0.5,
        low_open=True,
    )
    damping_tol: float = option(
        0.1, "The same for damping; of the sweep over orders, as min_rows.", low=0.0, high=1.0, low_open=True
    )
    min_rows: int = option(10, "An antiresonance must be stable in more consecutive orders than this.", low=1)
    max_damping: float = option(
        0.1, "Largest damping ratio of an antiresonance.", low=0.0, high=1.0, low_open=True
    )
    min_dominance: float = option(
        0.05, "How much of the curve a value must own, in the sweep over orders.", low=0.0
    )
    min_share: float = option(
        0.5,
        "Share of the fits over windows (curves, single impacts) that must see a value.",
        low=0.0,
        high=1.0,
        low_open=True,
        flag="--min-share FRACTION",
    )
    min_depth_db: float = option(
        3.0,
        "Depth in dB of the dip that a value must make, in fits over windows: in the direction of the "
        "responses and, where its size is known, in the response itself. Curves that are better than "
        "measured ones need less.",
        low=0.0,
        low_open=True,
    )
    persistent: bool = option(
        True, "Whether the sweep accepts values that are there at most orders without being stable."
    )
    keep_common: bool = option(False, "Whether to keep values that all of three or more channels share.")
    new_values: bool = option(
        False, "Whether a test whose values are followed (near) is searched for values that are new, too."
    )
    # Zeros, unlike poles, may lie right of the axis: measured ones of light damping often do, a little.
    both_sides: bool = field(default=False, repr=False)

    def under(self, preset: str | None) -> FitOptions:
        """These options, with those of the preset for what was not given."""
        chosen = {} if preset is None else {k: v for k, v in PRESETS[preset].items() if k != "max_order"}
        made = replace(self, **{name: v for name, v in chosen.items() if name not in self.given})
        object.__setattr__(made, "given", self.given)
        return made

    def agree(self, ratio: FloatArray, damping: FloatArray, own: float, least: float) -> NDArray[np.bool_]:
        """Whether roots are one with a root of damping ``own``, by ratio of moduli and by damping."""
        return (np.abs(ratio - 1.0) <= self.freq_tol) & (
            np.abs(damping - own) <= self.damping_tol * abs(own) + least
        )

    @classmethod
    def of_sweep(cls, min_order: Any, max_order: Any, **given: Any) -> tuple[FitOptions, tuple[int, int]]:
        """Options of a sweep over orders, and the lowest and highest of these, checked."""
        rule = cls(**given).checked()
        most = integer("max_order", max_order, low=2)
        least = integer("min_order", min_order, low=1, high=most)
        rule.check_span(least, most)
        return rule, (least, most)

    def check_span(self, min_order: int, max_order: int) -> None:
        """Refuse orders among which no chain could be long enough."""
        if max_order - min_order < self.min_rows:
            remedy = "A value is accepted only when more than min_rows consecutive orders agree."
            reject(
                "max_order", max_order, f"at least min_order + min_rows = {min_order + self.min_rows}", remedy
            )

    def orders(self, wanted: tuple[int, int], n_lines: int, *, per_line: int = 2) -> range:
        """Of the orders wanted, (lowest, highest), those that lines of ``per_line`` real numbers can bear."""
        low, high = wanted[0], min(wanted[1], per_line * n_lines // DATA_PER_ORDER)
        if high - low < self.min_rows:
            got = f"a band with {n_lines} lines for orders {low} to {high}"
            needed = f"orders that span more than min_rows = {self.min_rows}"
            reject("band_hz", got, needed, "Widen the band, or use longer segments.")
        return range(low, high + 1)


#: Options that only one kind of fit knows: the sweep over orders, and fits over windows.
OF_SWEEP = ("damping_tol", "min_rows", "min_dominance", "persistent")
OF_WINDOWS = ("min_share", "min_depth_db")
OF_BOTH = ("freq_tol", "max_damping")
#: Those of perturbed local fits, and of how their records are averaged; damping counts up to 0.06.
OF_DIRECTIONS = ("min_share", "min_depth_db", "max_damping", "method", "window", "nperseg")
OF_FOLLOWING = ("min_share", "new_values", "method", "window", "nperseg")  # those of values that are followed


def declared() -> dict[str, Option]:
    """Every option of an identification by its name, those of the call first."""
    return CallOptions.declared() | FitOptions.declared()


@dataclass(frozen=True)
class IdentificationOptions:
    """The options of one call as they hold, presets and defaults included."""

    call: CallOptions
    rule: FitOptions
    averaging: Averaging
    formulation: str
    max_order: int

    @property
    def given(self) -> frozenset[str]:
        """Names of the options that the caller gave, and no preset or default."""
        return self.rule.given | ({"max_order"} if self.call.max_order is not None else set())

    def values(self) -> dict[str, Any]:
        """Every option by name as it held, in plain data; ``fitted`` is the formulation that "auto" chose."""
        held = self.call.values() | self.rule.values()
        if not isinstance(held["window"], str):
            held["window"] = np.asarray(held["window"], dtype=object).tolist()
        return held | {"max_order": self.max_order, "fitted": self.formulation}

    @property
    def use_force(self) -> bool:
        """Whether the force is a row of the response vectors."""
        return self.call.route == "frf"

    @property
    def most(self) -> int:
        """No order above it is fitted: the highest order where one was named, else what is allowed at all."""
        free = self.call.max_order is None and self.max_order == USUAL_ORDER
        return HIGHEST_ORDER if free else self.max_order


def options_of(call: CallOptions, fit: FitOptions) -> IdentificationOptions:
    """What the options of a call mean together, checked: what is given beside a preset wins."""
    call.checked()
    rule = fit.under(call.preset)
    frf = call.route == "frf"
    if "formulation" not in fit.given and frf and rule.formulation in OF_MAGNITUDES:
        # FRFs keep the preset's rule; sums and magnitudes are those of transmissibilities.
        rule = replace(rule, formulation="joint")
        object.__setattr__(rule, "given", fit.given)
    rule.checked()
    usual = PRESETS[call.preset].get("max_order", USUAL_ORDER) if call.preset is not None else USUAL_ORDER
    max_order = usual if call.max_order is None else call.max_order
    if rule.formulation == "numerators" and call.estimator != "rank1":
        remedy = "That fit uses the whole spectral matrix; formulation='joint' takes any estimator."
        reject("estimator", call.estimator, "'rank1' with formulation='numerators'", remedy)
    if frf and rule.formulation in OF_MAGNITUDES:
        remedy = "Sums and magnitudes are those of transmissibilities."
        reject("formulation", rule.formulation, "'numerators' or 'joint' with route='frf'", remedy)
    integer("min_order", rule.min_order, low=1, high=max_order)
    averaging = Averaging(call.nperseg, rule.noverlap, rule.window, rule.method)
    return IdentificationOptions(call, rule, averaging, rule.formulation, max_order)


def flat(options: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of ``identify_antiresonances`` as a job has them, without those that are the default.

    Raises
    ------
    TypeError
        A name that is no option.
    InvalidInputError
        A value out of its range.
    """
    options = dict(options)
    fit = options.pop("fit", None)
    if fit is not None:
        options |= {name: getattr(fit, name) for name in fit.given}
    known = declared()
    for name in options:
        if name not in known and name != "dofs":
            raise TypeError(f"identify_antiresonances() got an unexpected keyword argument {name!r}")
    by_call = {name: value for name, value in options.items() if name in CallOptions.declared()}
    by_fit = {name: value for name, value in options.items() if name in FitOptions.declared()}
    options_of(CallOptions(**by_call), FitOptions(**by_fit))

    def differs(value: Any, usual: Any) -> bool:
        return np.ndim(value) > 0 or type(value) is not type(usual) or value != usual

    return {k: value for k, value in options.items() if k == "dofs" or differs(value, known[k].default)}


def sorted_out(options: Mapping[str, Any]) -> dict[str, Any]:
    """Options by name, as a job has them, as arguments of ``identify_antiresonances``."""
    of_fit = {name: value for name, value in options.items() if name in FitOptions.declared()}
    rest = {name: value for name, value in options.items() if name not in of_fit}
    return {**rest, "fit": FitOptions(**of_fit)} if of_fit else rest

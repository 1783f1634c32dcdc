"""When a pole counts: the limits of the stabilization, and the orders it needs to be applied at all."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any

from ..exceptions import reject
from ..support.checks import choice, finite_scalar, integer

# Real numbers of data that an order needs: with fewer, poles follow the noise of single lines.
DATA_PER_ORDER = 3


@dataclass(frozen=True)
class Rule:
    """When a pole is stable, and when a chain of them is accepted."""

    freq_tol: float = 0.01
    damping_tol: float = 0.10
    min_rows: int = 10
    max_damping: float = 0.10
    min_dominance: float = 0.05
    # Zeros, unlike poles, may lie right of the axis: measured ones of light damping often do, a little.
    both_sides: bool = False
    # Accept what is there in most orders without standing still.
    persistent: bool = True
    # Of the fits over windows: this share of them must have it, as a dip of so many dB.
    min_share: float = 0.5
    min_depth_db: float = 3.0

    def checked(self) -> Rule:
        """Same rule, or an error that names the bad option."""
        finite_scalar("freq_tol", self.freq_tol, low=0.0, high=0.5, low_open=True)
        finite_scalar("damping_tol", self.damping_tol, low=0.0, high=1.0, low_open=True)
        integer("min_rows", self.min_rows, low=1)
        finite_scalar("max_damping", self.max_damping, low=0.0, high=1.0, low_open=True)
        finite_scalar("min_dominance", self.min_dominance, low=0.0)
        finite_scalar("min_share", self.min_share, low=0.0, high=1.0, low_open=True)
        finite_scalar("min_depth_db", self.min_depth_db, low=0.0, low_open=True)
        return self

    def check_span(self, min_order: int, max_order: int) -> None:
        """Refuse orders among which no chain could be long enough."""
        if max_order - min_order < self.min_rows:
            reject(
                "max_order",
                max_order,
                f"at least min_order + min_rows = {min_order + self.min_rows}",
                "A value is accepted only when more than min_rows consecutive orders agree.",
            )

    def orders(self, wanted: tuple[int, int], n_lines: int, *, per_line: int = 2) -> range:
        """Of the orders wanted, (lowest, highest), those that lines of ``per_line`` real numbers can bear."""
        low, high = wanted[0], min(wanted[1], per_line * n_lines // DATA_PER_ORDER)
        if high - low < self.min_rows:
            reject(
                "band_hz",
                f"a band with {n_lines} lines for orders {low} to {high}",
                f"orders that span more than min_rows = {self.min_rows}",
                "Widen the band, or use longer segments.",
            )
        return range(low, high + 1)


# -- The limits of the selection, all in one place, each with its reason
#
# Those of averaged records were set on simulated structures (chains, random stiffness, a plane frame; seeds
# 100-119), never on the records that the published tables are made from; those of dips and of fits over
# windows on six states of a measured plate, and judged on measured frames and a beam. What a caller may
# change is in
# :class:`~antires_rs.identification.rule.Rule`.


# --- the diagram
#: Damping ratio up to which changes of damping are taken relative to this where both signs are allowed.
SMALL_DAMPING = 0.01

# --- what all channels share
#: Roots of all responses this close, relative to abs(s), are one common factor of the numerators.
SHARED = 0.003
#: Largest spread over the channels of a value that they share: a mode that the force hardly excites. On
#: measured frames and beams at most 0.41 %; antiresonances of neighbouring parts of a chain came within
#: 0.6 %.
COMMON = 0.005
#: Depth of a dip from which it is the response's own, though all others have one beside it.
COMMON_DEPTH_DB = 10.0
#: A zero this near to a root that all responses share is doubtful.
NEARLY_SHARED = 0.05

# --- the flanks of a value
#: They lie this far on either side of it, as shares of its frequency.
FLANK = (0.02, 0.20)
#: Signal-to-noise power there that a persistent value needs (6 dB), and a candidate of the cross-check
#: (3 dB).
PERSISTENT_SNR, CANDIDATE_SNR = 4.0, 2.0

# --- values that are in most orders without standing still
#: Poles within this share of a frequency are taken for the same value.
WIDTH = 0.02
#: In this share of the orders from the first appearance on there must be one.
PRESENCE = 0.75
#: Spurious poles of a noisy fit are not all weak: here a pole must own the curve at its frequency.
PERSISTENT_DOMINANCE = 0.7
PERSISTENT_DAMPING = 0.05

# --- zeros of the likeliest numerators
#: A chain and a zero of the likeliest fit this close belong together: the chain may be biased by so much.
SAME = 0.05
#: Largest standard deviation in frequency tolerances.
KNOWN = 0.5
#: Damped less than this, or right of the axis, are few physical zeros (two that nearly coincide part so), and
#: many roots glued to the noise of single lines: such a zero must own this much of its curve.
LEAST_DAMPING, MOST_NEGATIVE = 5e-4, 0.01
RIGHT_DOMINANCE = 0.9
#: Two zeros of one modulus, whose frequencies differ by less than this share of the difference of their
#: damping ratios, are the halves of one that is complex without damping; at least so far apart in damping.
PAIR, PAIR_DAMPING = 0.5, 0.004
#: Roots up to this damping, and with this share of the curve, may be the other half of such a pair.
WIDEST, OTHER_HALF = 0.15, 0.02
#: A zero that owns less than this share of its curve is doubtful. What is doubtful needs a root of the same
#: frequency and damping in PRESENCE of the higher orders.
WEAK = 0.5
SAME_DAMPING = 0.002

# --- the cross-check
#: Poles: this many more than the dof with most values has, and never fewer than the second number.
MORE_POLES, LEAST_POLES = 8, 12
#: A pole that owns less of the curve confirms nothing, one that owns less than the second is no candidate.
CONFIRMING_DOMINANCE, CANDIDATE_DOMINANCE = 0.3, 0.7
CROSS_CHECK_DAMPING = 0.10

# --- dips and peaks of a curve
#: On either side a dip is followed this far, as a share of its frequency; never less than the second number
#: of lines. A zero of 4 % damping makes a dip of 3 dB.
DIP_REACH, DIP_LINES = 0.04, 4
#: How far the root that a dip belongs to may lie from it, as a share of its frequency.
OWNER_WITHIN = 0.01
#: A dip of the response's own curve that belongs to one of its direction lies this near.
OWN_DIP_WITHIN = 0.02
#: A dip must be so many standard deviations of the noise beside it deep, where that is less than the rule
#: asks for: what is shallow is believed only of curves that are as good as exact. Shallower ones never count.
DIP_OVER_NOISE, LEAST_DIP_DB = 35.0, 0.5

# --- fits over windows
#: Zeros of several fits are one antiresonance within this share of the frequency tolerance; two that are
#: accepted lie at least ONE_DIP apart.
CLUSTER, ONE_DIP = 0.7, 0.01

# --- peaks that nothing explains
#: A peak of the curve behind a diagram this high, after averaging the power over so many lines, is named
#: where no accepted antiresonance lies within this share of its frequency.
PEAK_DB, PEAK_LINES, EXPLAINED_WITHIN = 10.0, 5, 0.02


# -- Named sets of options for the choice of what is physical
#
# ==============  =============  ==============  ===========  ===========
# option          None           "paper"         "strict"     "sensitive"
# ==============  =============  ==============  ===========  ===========
# formulation     "auto"         "eq10_squared"  "auto"       "auto"
# max_order       60             70              60           60
# freq_tol        0.01           0.01            0.01         0.01
# damping_tol     0.10           0.05            0.05         0.30
# min_rows        10             10              10           5
# max_damping     0.10           0.10            0.05         0.20
# min_dominance   0.05           0               0.90         0.02
# persistent      True           False           False        True
# min_share       0.5            0.5             0.8          0.3
# min_depth_db    3.0            3.0             6.0          2.0
# ==============  =============  ==============  ===========  ===========
#
# The highest order of the fit of all numerators ("auto" of averaged records) is no number unless one is
# given: 36 above the likeliest, which the data tell, up to 200.
#
# "paper" is the identification of V. Meruane, J. Sound Vib. 332 (2013) 807-820: the absolute value of Eq.
# 10, here its square, fitted by rational functions of f^2 (:mod:`~antires_rs.identification.paper`), and
# values that are stable within 1 % and 5 % in more than 10 consecutive orders, with no other test; the
# kinks of that curve take more orders. With ``route="frf"`` its rule is applied to the joint fit. "strict"
# wants poles that own their curve and stand still: for values that must be right. "sensitive" is for values
# that someone will look at afterwards. The last two options are of the fits over windows (single curves),
# those before of the sweep over orders.
#
# On six states of a measured plate (80 clear dips; ``benchmarks/measured_identification.py --only presets``)
# "strict", the default and "sensitive" find 77, 80 and 80 of them, with 2 of 114, 13 of 151 and 50 of 198
# values without a dip. What the presets mean on simulated records is the output of
# ``benchmarks/preset_tables.py``: the default is careful; "strict" buys fewer false ones where modes are
# many, and pays with what lies near the noise; "sensitive" has something to add there only.


#: What holds without a preset: the defaults of the rule.
DEFAULTS: Mapping[str, Any] = MappingProxyType(
    {"formulation": "auto", "max_order": 60}
    | {one.name: one.default for one in fields(Rule) if one.name != "both_sides"}
)

#: Options by name of the preset; what a preset does not mention is the default.
PRESETS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "paper": MappingProxyType(
            {
                "formulation": "eq10_squared",
                "max_order": 70,
                "damping_tol": 0.05,
                "min_dominance": 0.0,
                "persistent": False,
            }
        ),
        "strict": MappingProxyType(
            {
                "damping_tol": 0.05,
                "max_damping": 0.05,
                "min_dominance": 0.90,
                "persistent": False,
                "min_share": 0.8,
                "min_depth_db": 6.0,
            }
        ),
        "sensitive": MappingProxyType(
            {
                "damping_tol": 0.30,
                "min_rows": 5,
                "max_damping": 0.20,
                "min_dominance": 0.02,
                "min_share": 0.3,
                "min_depth_db": 2.0,
            }
        ),
    }
)


def rule_options(preset: str | None = None, **given: Any) -> dict[str, Any]:
    """All options of the choice: those given, else those of the preset, else the defaults."""
    choice("preset", preset, (None, *PRESETS))
    strange = sorted(set(given) - set(DEFAULTS))
    if strange:
        reject(
            "options",
            ", ".join(strange),
            "names out of " + ", ".join(DEFAULTS),
            "Correct the name, or leave it out.",
        )
    chosen = PRESETS[preset] if preset is not None else {}
    return {**DEFAULTS, **chosen, **{name: value for name, value in given.items() if value is not None}}

"""Named sets of options for the choice of what is physical.

==============  =============  ==============  ===========  ===========
option          None           "paper"         "strict"     "sensitive"
==============  =============  ==============  ===========  ===========
formulation     "auto"         "eq10_squared"  "auto"       "auto"
max_order       60             70              60           60
freq_tol        0.01           0.01            0.01         0.01
damping_tol     0.10           0.05            0.05         0.30
min_rows        10             10              10           5
max_damping     0.10           0.10            0.05         0.20
min_dominance   0.05           0               0.90         0.02
persistent      True           False           False        True
min_share       0.5            0.5             0.8          0.3
min_depth_db    3.0            3.0             6.0          2.0
==============  =============  ==============  ===========  ===========

The highest order of the fit of all numerators ("auto" of averaged records) is no number unless one is given:
36 above the likeliest, which the data tell, up to 200.

"paper" is the identification of V. Meruane, J. Sound Vib. 332 (2013) 807-820: the absolute value of Eq. 10,
here its square, fitted by rational functions of f^2 (:mod:`~antires_rs.identification.formulations`), and
values that are stable within 1 % and 5 % in more than 10 consecutive orders, with no other test; the kinks of
that curve take more orders. With ``route="frf"`` its rule is applied to the joint fit. "strict" wants poles
that own their curve and stand still: for values that must be right. "sensitive" is for values that someone
will look at afterwards. The last two options are of the fits over windows (single curves), those before of
the sweep over orders.

On six states of a measured plate (80 clear dips; ``benchmarks/measured_identification.py --only presets``)
"strict", the default and "sensitive" find 77, 80 and 80 of them, with 2 of 114, 13 of 151 and 50 of 198
values without a dip. What the presets mean on simulated records is the output of
``benchmarks/preset_tables.py``: the default is careful; "strict" buys fewer false ones where modes are
many, and pays with what lies near the noise; "sensitive" has something to add there only.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from types import MappingProxyType
from typing import Any

from ..support.validation import choice, reject
from .rule import Rule

__all__ = ["DEFAULTS", "PRESETS", "rule_options"]

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
    """All options of the choice: those given, else those of the preset, else the defaults.

    Parameters
    ----------
    preset : {None, "paper", "strict", "sensitive"}
        See the module.
    **given
        Options by name; None stands for not given.

    Returns
    -------
    dict
        Every option, whose names are those of :data:`DEFAULTS`.

    Raises
    ------
    InvalidInputError
        An unknown preset or option.

    Examples
    --------
    >>> from antires_rs.order_sweep.presets import rule_options
    >>> options = rule_options("paper", min_rows=8)
    >>> options["damping_tol"], options["min_rows"], options["freq_tol"]
    (0.05, 8, 0.01)
    """
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

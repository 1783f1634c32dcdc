"""Named sets of options for the choice of what is physical.

==============  =============  ===========  ===========  ===========
option          None           "paper"      "strict"     "sensitive"
==============  =============  ===========  ===========  ===========
formulation     "auto"         "joint"      "auto"       "auto"
freq_tol        0.01           0.01         0.01         0.01
damping_tol     0.10           0.05         0.05         0.30
min_rows        10             10           10           5
max_damping     0.10           0.10         0.05         0.20
min_dominance   0.05           0            0.90         0.02
persistent      True           False        False        True
==============  =============  ===========  ===========  ===========

"paper" is the rule of V. Meruane, J. Sound Vib. 332 (2013) 807-820: stable within 1 % and 5 % in more than 10
consecutive orders, and nothing else (on the joint fit of all transmissibilities: the paper's own sum cannot
be fitted, see :mod:`~antires_rs.identification.formulations`). "strict" wants poles that own their curve and
stand still: for values that must be right. "sensitive" is for values that someone will look at afterwards.

Found of all, and false values a record, on simulated records with the options as above (chain8 from
noise-free to 10 %: 1 % damping, 200 s, seeds 100 to 104; the others at 5 % noise, mean of seeds 110 to 112):

=========================================  ===========  ===========  ===========  ===========
structure                                  None         "paper"      "strict"     "sensitive"
=========================================  ===========  ===========  ===========  ===========
chain8 (28), no noise                      28.0 / 0     28.0 / 0.2   27.4 / 0     28.0 / 0
chain8, 1 % noise                          28.0 / 0     28.0 / 0     28.0 / 0     28.0 / 0
chain8, 5 % noise                          28.0 / 0     25.8 / 0     27.6 / 0     28.0 / 0
chain8, 10 % noise                         28.0 / 0     24.8 / 0     25.8 / 0     28.0 / 0
chain8, 5 % noise, 0.5 % damping, 60 s     27.4 / 0     20.4 / 0     24.8 / 0     27.4 / 0
random chain, force at mass 1 (28)         26.3 / 0     22.0 / 0     22.0 / 0     26.3 / 0
random chain, force at mass 4 (40)         37.7 / 0     24.0 / 0     26.0 / 0     38.7 / 0.3
full random stiffness (36)                 33.0 / 0.7   22.3 / 1.3   29.7 / 0     33.0 / 1.7
plane frame, 16 sensors (103)              78.0 / 3.0   47.3 / 2.0   46.0 / 1.0   85.0 / 3.7
=========================================  ===========  ===========  ===========  ===========

So the default is already careful: "strict" buys fewer false values where modes are many, and pays with what
lies near the noise; "sensitive" has something to add there only.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from ..support.validation import choice, reject

__all__ = ["DEFAULTS", "PRESETS", "rule_options"]

#: What holds without a preset.
DEFAULTS: Mapping[str, Any] = MappingProxyType(
    {
        "formulation": "auto",
        "freq_tol": 0.01,
        "damping_tol": 0.10,
        "min_rows": 10,
        "max_damping": 0.10,
        "min_dominance": 0.05,
        "persistent": True,
    }
)

#: Options by name of the preset; what a preset does not mention is the default.
PRESETS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "paper": MappingProxyType(
            {"formulation": "joint", "damping_tol": 0.05, "min_dominance": 0.0, "persistent": False}
        ),
        "strict": MappingProxyType(
            {"damping_tol": 0.05, "max_damping": 0.05, "min_dominance": 0.90, "persistent": False}
        ),
        "sensitive": MappingProxyType(
            {"damping_tol": 0.30, "min_rows": 5, "max_damping": 0.20, "min_dominance": 0.02}
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

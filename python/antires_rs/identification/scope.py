"""Which fit suits the lines, and which options count for it.

Curves and records may be identified by one call with the same options, and by one job: what has no effect is
said, not refused.
"""

from __future__ import annotations

from dataclasses import replace

from ..support.warned import warn
from .lines import Lines
from .local.fit import HIGHEST_ORDER, LINES_PER_ORDER
from .local.grid import SCALES
from .options import IdentificationOptions

__all__ = ["OF_SWEEP", "OF_WINDOWS", "settled"]

#: Options of the sweep over orders alone, and of the fits over windows alone.
OF_SWEEP = ("damping_tol", "min_rows", "min_dominance", "persistent")
OF_WINDOWS = ("min_share", "min_depth_db")
#: What either listens to.
OF_BOTH = ("freq_tol", "max_damping")
#: With fewer lines there is no window of the narrow scale, and no fit that others could confirm.
FEW_LINES = SCALES[-1][1]


def settled(options: IdentificationOptions, lines: Lines) -> IdentificationOptions:
    """The options with the formulation that "auto" means for these lines.

    Raises
    ------
    InvalidInputError
        Orders among which no chain could be long enough, where orders are swept.

    Warns
    -----
    AntiresWarning
        Options that were given and have no effect on this fit; few lines for fits over windows.
    """
    formulation = options.formulation
    if formulation == "auto":
        averaged = lines.segments is not None
        formulation = "windows" if not averaged else "numerators" if options.estimator == "rank1" else "joint"
    if formulation == "windows":
        idle = [name for name in OF_SWEEP if name in options.given]
        if "max_order" in options.given and options.max_order > HIGHEST_ORDER:
            idle.append(f"max_order above {HIGHEST_ORDER}")
        if options.min_order > HIGHEST_ORDER:
            idle.append(f"min_order above {HIGHEST_ORDER}")
        fit = "fits over windows (formulation 'windows': given curves and single impacts)"
        counts = [*OF_BOTH, *OF_WINDOWS, f"orders up to {HIGHEST_ORDER}"]
    else:
        options.rule.check_span(*options.orders)
        idle = [name for name in OF_WINDOWS if name in options.given]
        fit = f"the sweep over orders (formulation {formulation!r})"
        counts = [*OF_BOTH, *OF_SWEEP, "min_order", "max_order"]
    if idle:
        verb = "has" if len(idle) == 1 else "have"
        warn(
            "no_effect",
            f"identify_antiresonances: {' and '.join(idle)} {verb} no effect on {fit}; what counts there is "
            f"{', '.join(counts)}.",
        )
    if formulation == "windows" and lines.freq_hz.size < FEW_LINES:
        warn("few_lines", f"identify_antiresonances: {_of_few_lines(lines)}")
    return replace(options, formulation=formulation)


def _of_few_lines(lines: Lines) -> str:
    count, width = lines.freq_hz.size, float(lines.freq_hz[-1] - lines.freq_hz[0])
    return (
        f"the band holds {count} lines, which carry {count // LINES_PER_ORDER} orders; fits over windows "
        f"want {FEW_LINES} lines or more, else antiresonances are missed or misplaced. Measure with lines "
        f"{width / FEW_LINES:.2g} Hz apart or finer; if the band holds one mode alone, widen it."
    )

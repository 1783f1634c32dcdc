r"""Which function of the transmissibilities is fitted.

For the antiresonances of dof j all T_pj = X_p / X_j have the poles sought. They can be fitted as

==============  ==========================================================================================
"joint"         all T_pj, one denominator (complex, in s)
"power"         all abs(T_pj)^2, one denominator (real, in f^2; no phase),
                :mod:`~antires_rs.identification.power`
"eq10"          abs(Y) of Eq. 10, Y = sum_p abs(Re T_pj) + i sum_p abs(Im T_pj) (real, in f^2)
"eq10_squared"  abs(Y)^2 (real, in f^2); what ``preset="paper"`` takes
==============  ==========================================================================================

Measured on chain8 (28 antiresonances; 1 % damping, 200 s at 512 Hz, five seeds; found within 1 %, mean of the
runs / false values a run / largest relative error / median error), the last two by the paper's rule with
orders to 70:

==============  ==========================  ==========================  ==========================
formulation     no noise                    1 % noise                   5 % noise
==============  ==========================  ==========================  ==========================
"joint"         28.0 / 0.0 / 4e-05 / 5e-06  28.0 / 0.0 / 1e-03 / 1e-05  27.6 / 0.0 / 5e-03 / 5e-05
"power"         28.0 / 0.2 / 6e-05 / 7e-06  28.0 / 0.0 / 2e-03 / 2e-05  26.0 / 0.0 / 7e-03 / 9e-05
"eq10"          17.8 / 0.2 / 3e-03 / 1e-03  27.0 / 0.2 / 4e-03 / 7e-04  22.6 / 0.8 / 1e-02 / 1e-03
"eq10_squared"  27.0 / 0.2 / 1e-03 / 2e-04  27.4 / 0.6 / 4e-03 / 3e-04  24.6 / 1.0 / 6e-03 / 6e-04
==============  ==========================  ==========================  ==========================

So "joint" is the default of the four. "power" needs no phase; what it gives up is the test that spurious
poles fail in s, where they go to the right half plane.

The last two are what the paper fits: the absolute value of one curve. Near an antiresonance all T_pj are one
resonance with real factors, so that abs(Y)^2 is there that resonance's power, a rational function of f^2;
abs(Y) is its root, with branch points where the square has poles. Away from it both have a kink wherever a
part changes sign, sharp ones on curves without noise, which take orders: these two find less there than the
joint fit, and their errors are larger.

Lines of "joint" and "power" are weighted by SNR / (1 + SNR / 1e4) / (1 + sum_p abs(T_pj)^2), over abs(D)^2 of
a denominator guessed at order 4 (module ``first_guess``): without the guess "joint" finds 26.0 at 5 % noise,
"power" 24.6. Only averaged records get it; the errors of given curves and single impacts are not white, and
where the response is weak they would be followed. Those of Eq. 10 are weighted by (1 + abs(Y)^2)^-1/2 for the
square, and alike for the root; this and their orders were chosen on random chains and one with a spring
to ground (reference/structures.py, seeds 100 to 104).

Source: V. Meruane, J. Sound Vib. 332 (2013) 807-820 (Eq. 10 and the sum).
"""

from __future__ import annotations

import numpy as np

from ..order_sweep.diagram import PoleSweep
from ..order_sweep.rule import Rule
from ..rational.first_guess import guessed_weights
from ..rational.fit import NestedFit
from ..support.validation import FloatArray, choice, reject
from .lines import Lines
from .power import PowerFit, PowerSweep

__all__ = ["CHOICES", "FORMULATIONS", "OF_MAGNITUDES", "check_formulation", "sweep_of"]

FORMULATIONS = ("joint", "power", "eq10", "eq10_squared")
#: Real functions of f^2; one number a line.
OF_MAGNITUDES = FORMULATIONS[1:]
CHOICES = ("auto", "windows", "numerators", *FORMULATIONS)
# Order of the denominator guessed for the weights: the trend over the band, from which every order gains.
# Higher ones find more near the noise, and false ones with them.
GUESS_ORDER = 4
#: Exponents of the absolute value of Eq. 10, and of 1 + its square in the weights: residuals of
#: either are then weighed alike, since d(y^2) = 2 y dy.
_EQ10 = {"eq10": (1, 0.5), "eq10_squared": (2, -0.5)}


def sweep_of(
    lines: Lines, row: int, min_order: int, max_order: int, rule: Rule, formulation: str = "joint"
) -> tuple[PoleSweep, range, FloatArray]:
    """Sweep whose poles are the antiresonances of one row.

    Parameters
    ----------
    lines : Lines
        Response vectors of the band.
    row : int
        Of the dof whose antiresonances are wanted.
    min_order, max_order : int
        In s. With few lines the highest is lowered to a third of the real numbers in the data: two a line
        for "joint", else one.
    rule : Rule
        Only ``min_rows`` is looked at.
    formulation : {"joint", "power", "eq10", "eq10_squared"}
        See the module.

    Returns
    -------
    sweep : PoleSweep
    orders : range
        The orders that the lines can bear.
    background : (n_freq,)
        What was fitted, as a magnitude, for drawing behind the poles.

    Raises
    ------
    InvalidInputError
        An unknown formulation, or too few lines for the orders.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.identification.formulations import sweep_of
    >>> from antires_rs.identification.response_lines import Lines
    >>> from antires_rs.order_sweep.rule import Rule
    >>> f = np.linspace(2.0, 30.0, 600)
    >>> x = np.array([1.0 - f**2 / (10.0**2 + 0.2j * f), 1.0 + 0j * f])  # the first vanishes at 10 Hz
    >>> lines = Lines(f, x / np.linalg.norm(x, axis=0), np.full(600, 1e6))
    >>> for name in ("joint", "power"):
    ...     sweep, orders, _ = sweep_of(lines, 0, 2, 20, Rule(), name)
    ...     print(name, orders, np.sort(np.abs(sweep.roots(2)) / (2 * np.pi)).round(3).tolist())
    joint range(2, 21) [10.0, 10.0]
    power range(2, 21) [10.0, 10.0]
    """
    choice("formulation", formulation, FORMULATIONS)
    per_line = 1 if formulation in OF_MAGNITUDES else 2
    orders = rule.orders((min_order, max_order), lines.freq_hz.size, per_line=per_line)
    quotients, power = lines.quotients(row)
    if formulation in _EQ10:
        size = np.hypot(np.abs(quotients.real).sum(axis=0), np.abs(quotients.imag).sum(axis=0))
        exponent, weighted = _EQ10[formulation]
        fit = PowerFit(lines.freq_hz, size[None, :] ** exponent, (1.0 + size**2) ** weighted, orders[-1])
        return PowerSweep(fit), orders, size
    weights = lines.capped_snr
    guess = guessed_weights(lines.freq_hz, power, GUESS_ORDER if lines.segments is not None else 0)
    if formulation == "power":
        # The denominator in f^2 is the square of that in s.
        squares = quotients.real**2 + quotients.imag**2
        fit = PowerFit(lines.freq_hz, squares, weights * guess**2 / (1.0 + power), orders[-1])
        return PowerSweep(fit), orders, power
    nested = NestedFit(lines.freq_hz, quotients, weights * guess / (1.0 + power), orders[-1])
    return PoleSweep(nested), orders, np.abs(quotients.sum(axis=0))


def check_formulation(formulation: str) -> str:
    """One of the formulations; "sum", which there was, is refused with what to take instead."""
    if formulation == "sum":
        reject(
            "formulation",
            "'sum'",
            "one of " + ", ".join(repr(name) for name in CHOICES),
            "The fit of the sum of all transmissibilities was left out, being behind 'joint' at every noise; "
            "use formulation='joint'.",
        )
    return choice("formulation", formulation, CHOICES)

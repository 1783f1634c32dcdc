r"""A circumferential through-crack in a thin tube as a rotational spring.

The energy that a crack of half-angle :math:`\theta` adds under a moment M is the integral of
:math:`K_I^2 / E` over its area (two fronts, plane stress), and twice that over M squared its compliance:

.. math:: C = \frac{4}{\pi E R^2 t} \int_0^\theta \vartheta F_b(\vartheta)^2 \, d\vartheta, \qquad
          K_I = \frac{M}{\pi R^2 t} \sqrt{\pi R \vartheta} \, F_b(\vartheta)

with R the mean radius and t the wall thickness. The factor is Zahoor's, a fit to finite elements for R/t of 5
to 20 and cracks up to some 55 % of the perimeter: A. Zahoor, J. Pressure Vessel Technol. 107 (1985) 203-205,
and Ductile Fracture Handbook, EPRI NP-6301-D (1989); printed in T. L. Anderson, Fracture Mechanics, Table
12.29. Longer cracks are extrapolated: a spring wants a magnitude, not a margin of safety. (The net section of
the ligament says that a real crack of 85 % would be softer still.) The crack is always open, on the side that
the frame's bending opens; that it also lets the pipe stretch is left out.
"""

from __future__ import annotations

import numpy as np

from ...support.validation import finite_scalar

__all__ = ["bending_factor", "crack_compliance"]


def bending_factor(share: float, radius_over_wall: float) -> float:
    """Geometry factor ``F_b`` of a crack over ``share`` of the perimeter (0 to 1), for R/t of 5 to 20.

    Examples
    --------
    >>> from antires_rs.cases.exhaust.crack import bending_factor
    >>> round(bending_factor(0.5, 10.0), 3)
    2.765
    """
    ratio = finite_scalar("radius_over_wall", radius_over_wall, low=5.0, high=20.0)
    scale = (0.125 * ratio - 0.25 if ratio <= 10.0 else 0.4 * ratio - 3.0) ** 0.25
    return float(1.0 + scale * (4.5967 * share**1.5 + 2.6422 * share**4.24))


def crack_compliance(
    share: float, *, outer_diameter_m: float, thickness_m: float, youngs_modulus_pa: float
) -> float:
    """Rotation per moment, rad/(N m), that a crack over ``share`` of the perimeter adds to the tube.

    Parameters
    ----------
    share : float
        Length of the crack over the perimeter, 0 to 1 (exclusive).
    outer_diameter_m, thickness_m, youngs_modulus_pa : float
        The tube.

    Returns
    -------
    float

    Raises
    ------
    InvalidInputError
        A share outside [0, 1), a wall thickness outside the range of the formula.

    Examples
    --------
    >>> from antires_rs.cases.exhaust.crack import crack_compliance
    >>> f"{crack_compliance(0.6, outer_diameter_m=0.038, thickness_m=0.0015, youngs_modulus_pa=2.1e11):.3g}"
    '0.000152'
    """
    length = finite_scalar("share", share, low=0.0, high=1.0, high_open=True)
    radius = 0.5 * (outer_diameter_m - thickness_m)
    # The integrand is smooth in the root of the share, where Gauss points reach rounding.
    points, weights = np.polynomial.legendre.leggauss(24)
    root = 0.5 * np.sqrt(length) * (points + 1.0)
    factor = np.array([bending_factor(float(share_), radius / thickness_m) for share_ in root**2])
    integral = np.sum(0.5 * np.sqrt(length) * weights * 2.0 * root**3 * np.pi**2 * factor**2)
    return float(4.0 * integral / (np.pi * youngs_modulus_pa * radius**2 * thickness_m))

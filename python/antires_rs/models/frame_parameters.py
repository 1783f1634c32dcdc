"""Updating parameters of a :class:`~antires_rs.FrameModel`: sections, masses and supports.

Values have units, and replace those of the model; with ``relative=True`` they are factors on them, which also
lets one parameter act on carriers of different values. Sections are named, or counted from zero.
"""

from __future__ import annotations

from typing import Any

from .parameter import build

__all__ = ["density", "diameter", "inertia", "point_mass", "support_stiffness", "thickness", "youngs_modulus"]


def youngs_modulus(
    sections: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Young's modulus of sections, in Pa.

    Parameters
    ----------
    sections : int or str, or a sequence of them
        Sections by index or name.
    bounds : (float, float)
        Positive; in Pa, or factors.
    relative : bool
        The value is a factor on the nominal one.
    together : bool
        One parameter for the whole sequence.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or not positive, a section listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.youngs_modulus("pipe", bounds=(1.9e11, 2.2e11))
    Parameter(quantity='youngs_modulus', terms=('pipe',), bounds=(190000000000.0, 220000000000.0))
    """
    return build("youngs_modulus", sections, bounds, together, name="sections", relative=relative)


def density(
    sections: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Density of sections, in kg/m3.

    Parameters
    ----------
    sections, relative, together
        As in :func:`youngs_modulus`.
    bounds : (float, float)
        Positive; in kg/m3, or factors.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or not positive, a section listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.density(["pipe", "flange"], bounds=(0.95, 1.05), relative=True, together=True).terms
    ('pipe', 'flange')
    """
    return build("density", sections, bounds, together, name="sections", relative=relative)


def thickness(
    sections: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Wall thickness of tubes, in m; area and second moments follow.

    Parameters
    ----------
    sections, relative, together
        As in :func:`youngs_modulus`; the sections must be tubes.
    bounds : (float, float)
        Positive; in m, or factors. At most half the outer diameter.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or not positive, a section listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.thickness(0, bounds=(0.0012, 0.002))
    Parameter(quantity='thickness', terms=(0,), bounds=(0.0012, 0.002))
    """
    return build("thickness", sections, bounds, together, name="sections", relative=relative)


def diameter(
    sections: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Outer diameter of tubes, in m; the wall keeps its thickness.

    Parameters
    ----------
    sections, relative, together
        As in :func:`youngs_modulus`; the sections must be tubes.
    bounds : (float, float)
        Positive; in m, or factors.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or not positive, a section listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> len(ar.diameter([0, 1], bounds=(0.036, 0.040)))
    2
    """
    return build("diameter", sections, bounds, together, name="sections", relative=relative)


def point_mass(
    masses: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Lumped mass at a node, in kg; its inertia stays.

    Parameters
    ----------
    masses : int or sequence of int
        Zero-based positions in the model's ``point_masses``.
    bounds : (float, float)
        In kg, at least 0; or positive factors.
    relative, together : bool
        As in :func:`youngs_modulus`.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or negative, a mass listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.point_mass(2, bounds=(0.8, 1.2), relative=True).relative
    True
    """
    return build("point_mass", masses, bounds, together, name="masses", relative=relative)


def inertia(
    masses: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Rotational inertia of a lumped mass, in kg m2; in space about all three axes.

    Parameters
    ----------
    masses : int or sequence of int
        Zero-based positions in the model's ``point_masses``.
    bounds : (float, float)
        In kg m2, at least 0; or positive factors.
    relative, together : bool
        As in :func:`youngs_modulus`.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or negative, a mass listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.inertia(0, bounds=(0.001, 0.004)).bounds
    (0.001, 0.004)
    """
    return build("inertia", masses, bounds, together, name="masses", relative=relative)


def support_stiffness(
    springs: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Stiffness of springs to ground, in N/m (N m/rad for rotations).

    Parameters
    ----------
    springs : int or sequence of int
        Zero-based positions in the model's ``ground_springs``.
    bounds : (float, float)
        In N/m, at least 0; or positive factors.
    relative, together : bool
        As in :func:`youngs_modulus`.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or negative, a spring listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.support_stiffness([0, 1], bounds=(500.0, 4000.0), together=True).terms
    (0, 1)
    """
    return build("support_stiffness", springs, bounds, together, name="springs", relative=relative)

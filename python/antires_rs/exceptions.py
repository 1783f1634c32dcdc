"""The one exception family of antires_rs.

Every error that a caller can mend also derives from the fitting builtin, so that
``except ValueError`` keeps working in code that does not know this package. The Rust
core raises these same classes.
"""

__all__ = [
    "AntiresError",
    "AntiresWarning",
    "InternalError",
    "InvalidInputError",
    "MissingDependencyError",
    "NumericalError",
    "ObjectiveError",
    "UnsuitableDataError",
    "catalogue",
]


class AntiresError(Exception):
    """Root of every exception that antires_rs raises on purpose.

    Examples
    --------
    >>> import antires_rs as ar
    >>> try:
    ...     ar.cases.chain8(perturbation=2.0)
    ... except ar.AntiresError as error:
    ...     print(error)
    perturbation: got 2.0; wanted a finite number in [0, 0.5].
    """


class InvalidInputError(AntiresError, ValueError):
    """An argument is malformed. The message names it, what was got, and what is wanted.

    Examples
    --------
    >>> import antires_rs as ar
    >>> try:
    ...     ar.MassSpringChain([1.0, -1.0], [500.0])
    ... except ValueError as error:                  # ar.InvalidInputError is one
    ...     print(error)
    masses_kg: got -1 kg at index 1; wanted positive, finite values.
    """


class UnsuitableDataError(InvalidInputError):
    """The arguments are well formed, but the data cannot answer the question asked of them.

    Examples
    --------
    >>> import antires_rs as ar
    >>> alone = ar.Recording([[0.1, -0.2, 0.3, 0.1]], 512.0)
    >>> try:
    ...     ar.identify_antiresonances(alone, excitation=0, band_hz=(5, 100))
    ... except ar.UnsuitableDataError as error:
    ...     print(str(error).split(";")[0])
    source: got a single channel
    """


class NumericalError(AntiresError, ArithmeticError):
    """A solver did not converge or a matrix is numerically unusable.

    Examples
    --------
    >>> import antires_rs as ar
    >>> try:
    ...     ar.MatrixModel([[-1.0]], [[1.0]]).modes()
    ... except ar.NumericalError as error:
    ...     print(str(error).split(",")[1])
     M) failed: the stiffness is indefinite
    """


class ObjectiveError(AntiresError, ValueError):
    """A user's objective function returned something that is not one finite cost per candidate.

    Examples
    --------
    >>> import antires_rs as ar
    >>> try:
    ...     ar.IslandGA().minimize(lambda x: float("nan"), [(0, 1)], rng=0)
    ... except ar.ObjectiveError as error:
    ...     print(str(error).split(";")[0])
    fun: got no finite cost for any of 160 candidates
    """


class InternalError(AntiresError, RuntimeError):
    """The Rust core failed where it never should. This is a bug of antires_rs.

    Examples
    --------
    >>> import antires_rs as ar
    >>> issubclass(ar.InternalError, RuntimeError)   # please report it, with the message
    True
    """


class MissingDependencyError(AntiresError, ImportError):
    """An optional package is needed for this call. The message names the extra to install.

    Examples
    --------
    >>> import antires_rs as ar
    >>> issubclass(ar.MissingDependencyError, ImportError)
    True
    """


class AntiresWarning(UserWarning):
    """The result stands, but the reader should know something about it.

    Examples
    --------
    >>> import warnings, antires_rs as ar
    >>> two_parts = ar.MatrixModel([[1.0, 0.0], [0.0, 2.0]], [[1.0, 0.0], [0.0, 1.0]])
    >>> with warnings.catch_warnings(record=True, action="always") as seen:
    ...     zeros = two_parts.antiresonances(0, 1)
    >>> print(seen[0].category.__name__, str(seen[0].message).split(":")[0])
    AntiresWarning response dof 0 is not connected to excitation dof 1
    """


def catalogue() -> dict[str, type[Exception]]:
    """Return every exception class of the family by name.

    Returns
    -------
    dict
        ``{class name: class}``, the root included, warnings excluded.

    Examples
    --------
    >>> from antires_rs import exceptions
    >>> issubclass(exceptions.catalogue()["InvalidInputError"], ValueError)
    True
    """
    found: dict[str, type[Exception]] = {}
    pending: list[type[Exception]] = [AntiresError]
    while pending:
        cls = pending.pop()
        found[cls.__name__] = cls
        pending.extend(cls.__subclasses__())
    return dict(sorted(found.items()))

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
    """Root of every exception that antires_rs raises on purpose."""


class InvalidInputError(AntiresError, ValueError):
    """An argument is malformed. The message names it, what was got, and what is wanted."""


class UnsuitableDataError(InvalidInputError):
    """The arguments are well formed, but the data cannot answer the question asked of them."""


class NumericalError(AntiresError, ArithmeticError):
    """A solver did not converge or a matrix is numerically unusable."""


class ObjectiveError(AntiresError, ValueError):
    """A user's objective function returned something that is not one finite cost per candidate."""


class InternalError(AntiresError, RuntimeError):
    """The Rust core failed where it never should. This is a bug of antires_rs."""


class MissingDependencyError(AntiresError, ImportError):
    """An optional package is needed for this call. The message names the extra to install."""


class AntiresWarning(UserWarning):
    """The result stands, but the reader should know something about it."""


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

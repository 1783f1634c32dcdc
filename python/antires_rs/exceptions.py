"""The one exception family of antires_rs.

Every error that a caller can mend also derives from the fitting builtin. The Rust core raises these same
classes. What they say stands in fields; the sentence is made from them.
"""

from __future__ import annotations

from typing import Any, NoReturn


class AntiresError(Exception):
    """Root of every exception that antires_rs raises on purpose.

    Examples
    --------
    >>> import antires_rs as ar
    >>> issubclass(ar.InvalidInputError, ar.AntiresError)
    True
    """


class Argument(str):
    """The name of an argument or of a part of it, which also knows where that part is."""

    path: tuple[Any, ...]  # name, indices, keys and attributes: ("point_masses", 2, "inertia_kg_m2")

    def __new__(cls, label: str, path: tuple[Any, ...] | None = None) -> Argument:
        """An argument by its name; an argument stays what it is."""
        made = super().__new__(cls, label)
        made.path = getattr(label, "path", (str(label),)) if path is None else path
        return made

    def item(self, key: Any) -> Argument:
        """An item of this argument, by index or key."""
        return Argument(f"{self}[{key!r}]", (*self.path, key))

    def attribute(self, name: str) -> Argument:
        """An attribute of this argument."""
        return Argument(f"{self}.{name}", (*self.path, name))


class _Refusal(Exception):
    """What an error about an argument says, in four fields."""

    def __init__(self, argument: str, got: str, wanted: str, remedy: str) -> None:
        super().__init__(argument, got, wanted, remedy)
        self.argument = argument if isinstance(argument, Argument) else Argument(argument)
        self.got, self.wanted, self.remedy = got, wanted, remedy

    @property
    def path(self) -> tuple[Any, ...]:
        """Where in the argument: ``("bounds", 3)`` for ``bounds[3]``."""
        return self.argument.path

    def __str__(self) -> str:
        return f"{self.argument}: got {self.got}; wanted {self.wanted}. {self.remedy}"


class InvalidInputError(_Refusal, AntiresError, ValueError):
    """An argument is malformed; a ValueError, too.

    Attributes
    ----------
    argument, path : str and tuple
        Its name, ``bounds[3]``, and the same as data, ``("bounds", 3)``.
    got, wanted, remedy : str
        What was given, what would have been accepted, and what to do.

    Examples
    --------
    >>> import antires_rs as ar
    >>> print(ar.InvalidInputError("bounds[3]", "(2, 1)", "low < high", "Exchange them."))
    bounds[3]: got (2, 1); wanted low < high. Exchange them.
    """


class UnsuitableDataError(InvalidInputError):
    """The arguments are well formed, but the data cannot answer the question asked of them.

    Examples
    --------
    >>> import antires_rs as ar
    >>> print(ar.UnsuitableDataError("source", "a single channel", "two or more", "Record another."))
    source: got a single channel; wanted two or more. Record another.
    """


class NumericalError(AntiresError, ArithmeticError):
    """A solver did not converge or a matrix is numerically unusable.

    It knows ``what``, the computation, and, in ``detail``, how it failed.

    Examples
    --------
    >>> import antires_rs as ar
    >>> print(ar.NumericalError("eigh(K, M)", "the stiffness is indefinite"))
    eigh(K, M) failed: the stiffness is indefinite
    """

    def __init__(self, what: str, detail: str) -> None:
        super().__init__(what, detail)
        self.what, self.detail = what, detail

    def __str__(self) -> str:
        return f"{self.what} failed: {self.detail}"


class OutOfMemoryError(NumericalError, MemoryError):
    """There is not enough memory for a computation; it is asked for before the computation begins.

    It knows ``what``, ``bytes_wanted`` and, in ``detail``, what would do with less.

    Examples
    --------
    >>> import antires_rs as ar
    >>> print(ar.OutOfMemoryError("all modes", 4_320_000_000_000, "Ask for fewer."))
    all modes failed: 4.32e+03 GB of memory are not there. Ask for fewer.
    """

    def __init__(self, what: str, bytes_wanted: int, detail: str = "") -> None:
        less = detail or "Ask for less at a time: a lower f_max_hz, fewer dofs."
        super().__init__(what, f"{1e-9 * bytes_wanted:.3g} GB of memory are not there. {less}")
        self.args = (what, bytes_wanted, detail)
        self.bytes_wanted = bytes_wanted


class ObjectiveError(_Refusal, AntiresError, ValueError):
    """A user's objective did not return one finite cost; with the fields of an :class:`InvalidInputError`.

    Examples
    --------
    >>> import antires_rs as ar
    >>> print(ar.ObjectiveError("fun", "nan", "a finite cost", "Return one."))
    fun: got nan; wanted a finite cost. Return one.
    """


class InternalError(AntiresError, RuntimeError):
    """The Rust core failed where it never should. This is a bug of antires_rs.

    Examples
    --------
    >>> import antires_rs as ar
    >>> issubclass(ar.InternalError, RuntimeError)   # please report it, with the message
    True
    """


class LostWorkerError(AntiresError, RuntimeError):
    """A task was given up: every worker that began it was lost, killed by the system or by the task itself.

    It knows which ``task``, counted from 0, the ``losses`` of workers, and the ``reason`` of the last one.

    Examples
    --------
    >>> import antires_rs as ar
    >>> print(ar.LostWorkerError(7, 11, "exit code -9").reason)
    exit code -9
    """

    def __init__(self, task: int, losses: int, reason: str) -> None:
        super().__init__(task, losses, reason)
        self.task, self.losses, self.reason = task, losses, reason

    def __str__(self) -> str:
        return (
            f"task {self.task} was given up: {self.losses} workers that had begun it were lost, the last "
            f"with {self.reason}. Do this one task alone to see why; code -9 is often memory that ran out."
        )


class MissingDependencyError(AntiresError, ImportError):
    """An optional package is needed; the message names the extra to install.

    Examples
    --------
    >>> import antires_rs as ar
    >>> issubclass(ar.MissingDependencyError, ImportError)
    True
    """


class AntiresWarning(UserWarning):
    """The result stands, but the reader should know something about it.

    It knows its ``text``, and in ``about`` the names under which :func:`~antires_rs.explain` tells more.

    Examples
    --------
    >>> import antires_rs as ar
    >>> print(ar.AntiresWarning("response dof 0 is not connected to excitation dof 1", ("not_connected",)))
    response dof 0 is not connected to excitation dof 1 [antires explain not_connected]
    """

    def __init__(self, text: str, about: tuple[str, ...] = ()) -> None:
        super().__init__(text, about)
        self.text, self.about = text, about

    def __str__(self) -> str:
        return f"{self.text} [antires explain {' '.join(self.about)}]" if self.about else self.text


#: What a check calls the value it is given: an argument, or an argument and the key of one of its items. Only
#: an error spells such a pair out.
Name = str | tuple[str, Any]


def reject(name: Name, got: object, wanted: str, remedy: str) -> NoReturn:
    """Raise the package's input error; ``name`` may be an :class:`~antires_rs.exceptions.Argument`."""
    text = got if isinstance(got, str) and got else repr(got)
    raise InvalidInputError(part(*name) if isinstance(name, tuple) else name, text, wanted, remedy)


def part(name: str, key: Any) -> Argument:
    """An item of an argument, for the checks to name."""
    return Argument(name).item(key)

"""Tables as text, in columns that stand under each other."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["aligned", "number"]


def number(value: float, digits: int, *, sign: bool = False) -> str:
    """A number with so many decimals; a dash where it is not known.

    Examples
    --------
    >>> from antires_rs.measured.layout import number
    >>> number(0.12345, 3), number(float("nan"), 3), number(2.0, 1, sign=True)
    ('0.123', '-', '+2.0')
    """
    return "-" if value != value else f"{value:{'+' if sign else ''}.{digits}f}"


def aligned(head: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[str] = ("",)) -> list[str]:
    """Lines of a table: columns right-aligned, those named in ``left`` left-aligned."""
    table = [head, *rows]
    widths = [max(len(row[i]) for row in table) for i in range(len(head))]
    return [
        "  ".join(
            cell.ljust(width) if name in left else cell.rjust(width)
            for cell, width, name in zip(row, widths, head, strict=True)
        ).rstrip()
        for row in table
    ]

"""Where the force acted, as a universal file states it."""

from __future__ import annotations

import os

from ._common import existing_file
from .uff_names import label_of
from .uff_sets import functions_of

__all__ = ["force_of"]


def force_of(path: str | os.PathLike[str]) -> str | None:
    """Point of the force, ``'12+Z'``: the one reference of the FRFs, or the channel of a force.

    None where the file does not tell, or states several.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> from antires_rs.io.uff_force import force_of
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     record = ar.Recording([[1.0, 2.0, 4.0]], 512.0, dofs=["12+Z"])
    ...     print(force_of(ar.write_uff(folder + "/a.uff", record)))
    None
    """
    functions = functions_of(existing_file(path), True, "force_of")
    points = {f.reference for f in functions if f.what == "frf"}
    points |= {f.response for f in functions if f.what == "time" and f.role == "force"}
    known = {point for point in points if point[0] > 0 and point[1] != 0}
    return label_of(known.pop()) if len(points) == 1 and known else None

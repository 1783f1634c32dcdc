"""Results of updating and damage assessment as one file: what was asked, how it went, what came out.

A NumPy archive with a JSON text, version 3: model, parameters, measured sets, penalty, weights, the
optimizer's options, seed, x, history, final populations, the assessment against a baseline with what was
asked (some files of version 3 lack the question), and the versions it was made with. No pickle; every part
has a checksum. Older ones are read as well: version 1 kept an updated model as the problem it came from,
version 2 had no assessment.
"""

from __future__ import annotations

import os
import platform
from pathlib import Path
from typing import Any

import numpy as np

from .._core import __version__
from ..damage.result import DamageResult
from ..optimize.outcome import History, OptimizeResult
from ..support.validation import reject
from ..support.warned import warn
from ..updating.results import UpdateResult
from ._common import unsuitable
from ._store import Store, read_store, write_store
from .assessments import describe_assessment, made_assessment
from .problems import describe_problem, made_problem
from .questions import describe_question, made_question

__all__ = ["load_result", "save_result"]

FORMAT, VERSION = "antires_rs.result", 3
_ARRAYS = ("x", "populations", "population_costs")
_PLAIN = ("fun", "success", "status", "message", "nfev", "njev", "nit")
_CLASSES = {"UpdateResult": UpdateResult, "DamageResult": DamageResult}


def save_result(result: UpdateResult, path: str | os.PathLike[str]) -> Path:
    """Write a result, whole or not at all; see :meth:`UpdateResult.save`."""
    if isinstance(path, str | os.PathLike) and Path(path).suffix != ".npz":
        reject("path", str(path), "a file that ends in .npz", "Append .npz to the name.")
    store, search = Store(), result.search
    assessment = result._assessment if isinstance(result, DamageResult) else None
    question = result._question if isinstance(result, DamageResult) else None
    data = {
        "format": FORMAT,
        "version": VERSION,
        "class": type(result).__name__,
        "seed": result.seed,
        "problem": describe_problem(result.problem, store),
        "search": {
            **{name: getattr(search, name) for name in _PLAIN},
            **{name: store.put(getattr(search, name)) for name in _ARRAYS},
            "history": {
                name: store.put(getattr(search.history, name)) for name in ("nfev", "cost", "migrations")
            },
            "options": search.options,
        },
        "assessment": None if assessment is None else describe_assessment(assessment, store),
        "question": None if question is None else describe_question(question, store),
        "made_with": {
            "antires_rs": __version__,
            "numpy": np.__version__,
            "python": platform.python_version(),
            "system": platform.platform(),
        },
    }
    return write_store(path, data, store)


def load_result(path: str | os.PathLike[str], kind: type[UpdateResult] = UpdateResult) -> Any:
    """Read what :func:`save_result` wrote; see :meth:`UpdateResult.load`."""
    wanted = f"a file written by {kind.__name__}.save, version {VERSION} or older"
    file, data = read_store(
        path, FORMAT, VERSION, wanted, "It was cut, or is another file: name the result.npz of a run."
    )
    try:
        made = _CLASSES[data["class"]]
        if not issubclass(made, kind):
            unsuitable(file, f"which holds an {made.__name__}", wanted, f"Use {made.__name__}.load.")
        problem = made_problem(data["problem"], str(file))
        raw = {"njev": None, **data["search"]}  # version 1 did not count linearizations
        search = OptimizeResult(history=History(**raw.pop("history")), **raw)
        kept = data.get("assessment")
        asked = data.get("question")
        question = None if asked is None else made_question(asked, str(file))
        more = () if kept is None else (made_assessment(kept), question)
    except (KeyError, TypeError, IndexError) as exc:
        unsuitable(
            file,
            f"which is damaged ({type(exc).__name__}: {exc})",
            wanted,
            "Copy it again, or save the result anew.",
        )
    cost = problem.cost(search.x)
    if not np.isclose(cost, search.fun, rtol=1e-9, atol=1e-12):
        maker = data["made_with"]["antires_rs"]
        warn(
            "other_version",
            f"path: {str(file)!r} was made by antires_rs {maker}; its objective was {search.fun:.9g} where "
            f"this version computes {cost:.9g}.",
        )
    return made(problem, search, data["seed"], *more)

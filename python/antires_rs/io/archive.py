"""Arrays and a JSON text in one archive, every part with its SHA-256.

In the text an array stands as ``{"array": "a3"}``.
"""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Iterable
from dataclasses import MISSING, asdict, fields
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import __version__
from ..damage.assessor import Assessor
from ..damage.assessor_plan import LEVELS, Plan, Tables
from ..damage.hypotheses import Assessment, Hypotheses, Hypothesis
from ..damage.inference import Learned
from ..damage.options import DamagePrior, SearchOptions
from ..damage.question import Question
from ..damage.result import DamageResult
from ..exceptions import reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..models.chain import MassSpringChain
from ..models.frame import FrameModel
from ..models.frame_parts import PARTS, Rectangle, Section, Tube
from ..models.matrices import Entries
from ..models.matrix_model import MatrixModel
from ..models.parameters import Parameter
from ..models.recipes import ChainRecipe, FrameRecipe, MatrixRecipe
from ..models.structural_model import AppliedParameters, ModelDescription, Recipe, StructuralModel
from ..optimize.island_ga import History, OptimizeResult
from ..support.checks import FloatArray
from ..support.messages import warn
from ..updating.problem import DamagePenalty, UpdatingProblem
from ..updating.result import UpdateResult
from .common import existing_file, unsuitable
from .npz import TEXT, read_archive, write_archive


class Store:
    """The arrays of a file being written."""

    def __init__(self) -> None:
        self.arrays: dict[str, NDArray[Any]] = {}

    def put(self, array: Any) -> dict[str, str]:
        """Keep an array; returns what stands for it in the text."""
        name = f"a{len(self.arrays)}"
        self.arrays[name] = np.ascontiguousarray(array)
        return {"array": name}


def write_store(path: str | os.PathLike[str], data: dict[str, Any], store: Store) -> Path:
    """Write text, arrays and their hashes, whole or not at all."""
    hashes = {name: _digest(array) for name, array in store.arrays.items()}
    text = json.dumps({**data, "sha256": hashes}, allow_nan=False, indent=1)
    own = np.frombuffer(bytes.fromhex(_sha256(text.encode())), dtype=np.uint8)
    return write_archive(path, text, {**store.arrays, "text_sha256": own})


def read_store(
    path: str | os.PathLike[str],
    form: str,
    version: int,
    wanted: str,
    remedy: str = "It was cut, or is another file: copy it again, or name the right one.",
) -> tuple[Path, dict[str, Any]]:
    """The text with its arrays in place, after all hashes were compared.

    ``wanted`` and ``remedy`` are said of a file that is no archive.
    """
    file = existing_file(path)
    arrays = read_archive(file, wanted, remedy)
    if TEXT not in arrays or "text_sha256" not in arrays:
        unsuitable(
            file, "an archive of another kind", wanted, "It was cut, or is another file: name the right one."
        )
    text = bytes(arrays[TEXT])
    if _sha256(text) != bytes(arrays["text_sha256"]).hex():
        unsuitable(file, "whose text does not have its checksum", wanted, "It was damaged or edited.")
    data = json.loads(text)
    if data.get("format") != form:
        unsuitable(
            file,
            f"which holds {data.get('format')!r}",
            wanted,
            "It is another file of antires_rs: name the right one.",
        )
    if not isinstance(data.get("version"), int) or data["version"] > version:
        unsuitable(
            file, f"of version {data.get('version')!r}", f"version {version} or older", "Update antires_rs."
        )
    for name, digest in data["sha256"].items():
        if name not in arrays or _digest(arrays[name]) != digest:
            unsuitable(
                file,
                f"whose array {name} is missing or does not have its checksum",
                wanted,
                "It was damaged or edited.",
            )
    return file, _filled(data, arrays)


def _filled(value: Any, arrays: dict[str, NDArray[Any]]) -> Any:
    if isinstance(value, dict):
        if value.keys() == {"array"}:
            return arrays[value["array"]]
        return {key: _filled(item, arrays) for key, item in value.items()}
    return [_filled(item, arrays) for item in value] if isinstance(value, list) else value


def _digest(array: NDArray[Any]) -> str:
    head = f"{array.dtype.str}{array.shape}".encode()
    return _sha256(head + np.ascontiguousarray(array).tobytes())


def _sha256(data: bytes) -> str:
    import hashlib  # slow to load

    return hashlib.sha256(data).hexdigest()


# -- Descriptions of models as plain data, and models made again from it, bit-identical


_SECTIONS = {"Tube": Tube, "Rectangle": Rectangle, "Section": Section}
_MODELS: dict[type[Recipe], type[StructuralModel]] = {
    ChainRecipe: MassSpringChain,
    MatrixRecipe: MatrixModel,
    FrameRecipe: FrameModel,
}


def describe_model(model: StructuralModel, store: Store) -> dict[str, Any]:
    """Recipe and applied parameters of a model."""
    description = model.description
    if type(model) is not _MODELS[type(description.recipe)]:
        reject(
            "model",
            type(model).__name__,
            "a MassSpringChain, FrameModel or MatrixModel",
            "Build the model as one of these first.",
        )
    return {
        **_describe_recipe(description.recipe, store),
        "applied": [
            {"parameters": describe_parameters(one.parameters), "values": store.put(one.values)}
            for one in description.applied
        ],
    }


def made_model(data: dict[str, Any], name: str) -> StructuralModel:
    """The model of a description; ``name`` is the file's, for messages."""
    if data["kind"] == "updated":
        return _made_by_version_1(data, name)
    recipe = _made_recipe(data, name)
    applied = tuple(
        AppliedParameters(made_parameters(one["parameters"]), one["values"])
        for one in data.get("applied", ())  # version 1 has none
    )
    return _MODELS[type(recipe)].from_description(ModelDescription(recipe, applied))


def describe_parameters(parameters: Iterable[Parameter]) -> list[dict[str, Any]]:
    """Parameters as plain data."""
    return [asdict(p) for p in parameters]


def made_parameters(rows: list[dict[str, Any]]) -> tuple[Parameter, ...]:
    """Parameters of plain data."""
    made: list[dict[str, Any]] = [
        {key: tuple(v) if isinstance(v, list) else v for key, v in row.items()} for row in rows
    ]
    return tuple(Parameter(**row) for row in made)


def _made_by_version_1(data: dict[str, Any], name: str) -> StructuralModel:
    """A model that came out of an updating was kept as that problem and its x."""
    problem, values = data["problem"], data["x"]
    parameters = made_parameters(problem["parameters"])
    if problem["penalty"] is not None:
        values = _snapped(parameters, values, problem["penalty"]["snap"])
    return made_model(problem["model"], name).with_parameters(parameters, values)


def _snapped(parameters: tuple[Parameter, ...], values: FloatArray, snap: float) -> FloatArray:
    """The problem set severities below ``snap`` to zero before it made its model."""
    reductions = np.array([p.quantity == "stiffness_reduction" for p in parameters])
    return np.where(reductions & (np.abs(values) < snap), 0.0, values)


def _describe_recipe(recipe: Recipe, store: Store) -> dict[str, Any]:
    if isinstance(recipe, ChainRecipe):
        return {
            "kind": "chain",
            "masses_kg": store.put(recipe.masses_kg),
            "springs_n_per_m": store.put(recipe.springs_n_per_m),
            "ground_first_n_per_m": recipe.ground_first_n_per_m,
            "ground_last_n_per_m": recipe.ground_last_n_per_m,
        }
    if isinstance(recipe, MatrixRecipe):
        return {
            "kind": "matrices",
            "n_dof": recipe.n_dof,
            "stiffness": [store.put(part) for part in recipe.stiffness],
            "mass": [store.put(part) for part in recipe.mass],
            "terms": [
                [[store.put(part) for part in term] for term in terms]
                for terms in (recipe.stiffness_terms, recipe.mass_terms)
            ],
            "names": list(recipe.names),
            "constraints": None
            if recipe.constraints is None
            else [store.put(part) for part in recipe.constraints],
            "keep": list(recipe.keep),
        }
    return {
        "kind": "frame",
        "nodes_m": store.put(recipe.nodes_m),
        "elements": [list(beam) for beam in recipe.beams],
        "section_names": list(recipe.section_names),
        "sections": [{"type": type(s).__name__, **asdict(s)} for s in recipe.sections],
        "orientation": None if recipe.orientation is None else store.put(recipe.orientation),
        **{kind: [part._saved() for part in recipe.parts.get(kind, ())] for kind in PARTS},
        "fixed": recipe.fixed,
    }


def _made_recipe(data: dict[str, Any], name: str) -> Recipe:
    if data["kind"] == "chain":
        return ChainRecipe(
            data["masses_kg"],
            data["springs_n_per_m"],
            data["ground_first_n_per_m"],
            data["ground_last_n_per_m"],
        )
    if data["kind"] == "matrices":
        stiffness_terms, mass_terms = (tuple(map(_entries, terms)) for terms in data["terms"])
        constraints = data.get("constraints")  # not in files of versions before
        return MatrixRecipe(
            data["n_dof"],
            _entries(data["stiffness"]),
            _entries(data["mass"]),
            stiffness_terms,
            mass_terms,
            tuple(data.get("names", ())),
            None if constraints is None else _entries(constraints),
            tuple(data.get("keep", ())),
        )
    if data["kind"] == "frame":
        return _made_frame(data)
    reject(
        "path",
        f"{name!r} with a model of kind {data['kind']!r}",
        "a kind that this version knows",
        "Update antires_rs.",
    )


def _entries(parts: list[Any]) -> Entries:
    rows, columns, values = parts
    return Entries(np.asarray(rows, dtype=np.uint32), np.asarray(columns, dtype=np.uint32), values)


def _made_frame(data: dict[str, Any]) -> FrameRecipe:
    return FrameRecipe(
        nodes_m=data["nodes_m"],
        beams=tuple((a, b, section) for a, b, section in data["elements"]),
        section_names=tuple(data["section_names"]),
        sections=tuple(
            _SECTIONS[s["type"]](**{key: value for key, value in s.items() if key != "type"})
            for s in data["sections"]
        ),
        orientation=data["orientation"],
        parts={
            name: tuple(kind._of_saved(row) for row in data.get(name, ())) for name, kind in PARTS.items()
        },
        fixed=tuple((node, direction) for node, direction in data["fixed"]),
    )


# -- Updating problems as plain data, and made again from it


#: What a set of modes may tell of each.
_BY_MODE = ("damping_ratio", "std_hz", "std_shapes")


def describe_problem(problem: UpdatingProblem, store: Store) -> dict[str, Any]:
    """All that the constructor takes."""
    return {
        "model": describe_model(problem.model, store),
        "parameters": describe_parameters(problem.parameters),
        "measured": [describe_measured(each, store) for each in problem.measured],
        "misfit": problem.misfit,
        "penalty": None if problem.penalty is None else asdict(problem.penalty),
        "weights": None if problem.weights is None else store.put(problem.weights),
    }


def made_problem(data: dict[str, Any], name: str) -> UpdatingProblem:
    """The problem of a description; ``name`` is the file's, for messages."""
    measured: list[Any] = [made_measured(each, name) for each in data["measured"]]
    penalty = None if data["penalty"] is None else DamagePenalty(**data["penalty"])
    sets = measured[0] if len(measured) == 1 else measured
    return UpdatingProblem(
        made_model(data["model"], name),
        made_parameters(data["parameters"]),
        sets,
        misfit=data["misfit"],
        penalty=penalty,
        weights=data["weights"],
    )


def describe_measured(measured: AntiresonanceSet | ModalSet, store: Store) -> dict[str, Any]:
    """A set of either kind."""
    if isinstance(measured, AntiresonanceSet):
        return {"kind": "antiresonances", "set": json.loads(measured.to_json())}
    return {
        "kind": "modes",
        "freq_hz": store.put(measured.freq_hz),
        "shapes": store.put(measured.shapes),
        "dofs": list(measured.dofs),
        **{name: None if (own := getattr(measured, name)) is None else store.put(own) for name in _BY_MODE},
    }


def made_measured(data: dict[str, Any], name: str) -> AntiresonanceSet | ModalSet:
    """The set of a description."""
    if data["kind"] == "antiresonances":
        return AntiresonanceSet.from_json(json.dumps(data["set"]), name)
    by_mode = {name: data.get(name) for name in _BY_MODE}  # older files have no standard deviations
    return ModalSet(data["freq_hz"], data["shapes"], data["dofs"], **by_mode)


# -- What an assessment against a baseline was asked, as plain data, and made again from it


def describe_question(asked: Question, store: Store) -> dict[str, Any]:
    """The model before it was corrected, both states, and what was assumed."""
    return {
        "model": describe_model(asked.model, store),
        "baseline": [describe_measured(each, store) for each in asked.baseline],
        "measured": [describe_measured(each, store) for each in asked.measured],
        "elements": list(asked.elements),
        "prior": asdict(asked.prior),
        "options": asked.options.values() | {"weights": None, "x0": None},
    }


def made_question(data: dict[str, Any], name: str, *, reduced: bool = False) -> Question:
    """The question of a description; ``name`` is the file's, for messages."""
    states: list[Any] = [
        tuple(made_measured(each, name) for each in data[state]) for state in ("baseline", "measured")
    ]
    return Question(
        made_model(data["model"], name),
        states[0],
        states[1],
        tuple(data["elements"]),
        DamagePrior(**data["prior"]),
        SearchOptions(**(data.get("options") or {"std_common": data["std_common"]})),
        reduced=reduced,
    )


# -- Assessments of damage as plain data and arrays, and made again from it


#: Columns of the hypotheses with a value for each of their elements.
_RAGGED = ("severities", "low", "high")


def describe_assessment(found: Assessment, store: Store) -> dict[str, Any]:
    """Every field; no bit of a float is lost."""
    rows = list(found.hypotheses)
    described: dict[str, Any] = {
        "hypotheses": {
            "names": [[e, name] for e, name in found.hypotheses.names.items()],
            "elements": [list(one.elements) for one in rows],
            "candidate": [one.candidate for one in rows],
            "probability": store.put(found.hypotheses.probability),
            **{
                name: store.put(np.array([*chain(*(getattr(one, name) for one in rows))])) for name in _RAGGED
            },
        },
        "group": [rows.index(one) for one in found.group],
    }
    for field in fields(found):
        if field.name not in described:
            described[field.name] = _described(getattr(found, field.name), store)
    return described


def made_assessment(data: dict[str, Any]) -> Assessment:
    """The assessment of a description."""
    table = data["hypotheses"]
    counts = [0 if elements == [-1] else len(elements) for elements in table["elements"]]
    ends = np.cumsum(counts)[:-1]
    ragged = [[tuple(part.tolist()) for part in np.split(table[name], ends)] for name in _RAGGED]
    rows = [
        Hypothesis(tuple(elements), probability, severities, low, high, candidate)
        for elements, probability, candidate, severities, low, high in zip(
            table["elements"], table["probability"].tolist(), table["candidate"], *ragged, strict=True
        )
    ]
    values: dict[str, Any] = {
        "hypotheses": Hypotheses(rows, {e: name for e, name in table["names"]}),
        "group": tuple(rows[nth] for nth in data["group"]),
    }
    for field in fields(Assessment):
        if field.name not in values and (field.name in data or field.default is MISSING):
            values[field.name] = _made(data[field.name])
    return Assessment(**values)


def _described(value: Any, store: Store) -> Any:
    if isinstance(value, float):
        return {"float": repr(value)}  # JSON has no infinity
    if isinstance(value, tuple):
        floats = any(isinstance(each, float) for each in value)
        return store.put(np.array(value, dtype=np.float64)) if floats else list(value)
    return value


def _made(value: Any) -> Any:
    if isinstance(value, dict):
        return float(value["float"])
    plain = value.tolist() if isinstance(value, np.ndarray) else value
    return tuple(plain) if isinstance(plain, list) else plain


# -- Assessors as files: model, baseline, tables, and what was learned
#
# A NumPy archive with a JSON text, version 1. No pickle; every part has a checksum.


FORMAT, VERSION = "antires_rs.assessor", 1


def save_assessor(assessor: Assessor, path: str | os.PathLike[str]) -> Path:
    """Write an assessor, whole or not at all; see :meth:`Assessor.save`."""
    if isinstance(path, str | os.PathLike) and Path(path).suffix != ".npz":
        reject("path", str(path), "a file that ends in .npz", "Append .npz to the name.")
    store, plan = Store(), assessor._plan
    data = {
        "format": FORMAT,
        "version": VERSION,
        "question": describe_question(plan.question, store),
        "reduced": plan.question.reduced,
        "levels": store.put(LEVELS),
        "tables": {field.name: store.put(getattr(plan.tables, field.name)) for field in fields(Tables)},
        "learned": {
            field.name: _described_assessors(getattr(plan.learned, field.name), store)
            for field in fields(Learned)
        },
    }
    return write_store(path, data, store)


def load_assessor(path: str | os.PathLike[str]) -> Assessor:
    """Read what :func:`save_assessor` wrote; see :meth:`Assessor.load`."""
    wanted = f"a file written by Assessor.save, version {VERSION} or older"
    file, data = read_store(path, FORMAT, VERSION, wanted)
    try:
        question = made_question(data["question"], str(file), reduced=data["reduced"])
        tables = Tables(**{field.name: data["tables"][field.name] for field in fields(Tables)})
        learned = Learned(
            **{field.name: _made_assessors(data["learned"][field.name]) for field in fields(Learned)}
        )
        same = np.array_equal(data["levels"], LEVELS)
    except (KeyError, TypeError, IndexError) as exc:
        unsuitable(
            file,
            f"which is damaged ({type(exc).__name__}: {exc})",
            wanted,
            "Make and save the assessor anew.",
        )
    if not same:
        unsuitable(file, "with tables of another version", wanted, "Make and save the assessor anew.")
    return Assessor._of(Plan(question, tables, learned))


def _described_assessors(value: Any, store: Store) -> Any:
    """Floats as arrays: no bit is lost, and infinity is allowed."""
    if isinstance(value, np.ndarray):
        return store.put(value)
    if isinstance(value, tuple):
        kind = "floats" if any(isinstance(each, float) for each in value) else "plain"
        return {kind: store.put(np.array(value)) if kind == "floats" else list(value)}
    return {"float": repr(value)} if isinstance(value, float) else value


def _made_assessors(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    ((kind, kept),) = value.items()
    if kind == "float":
        return float(kept)
    return tuple(kept.tolist()) if kind == "floats" else tuple(kept)


# -- Results of updating and damage assessment as one file: what was asked, how it went, what came out
#
# A NumPy archive with a JSON text, version 3: model, parameters, measured sets, penalty, weights, the
# optimizer's options, seed, x, history, final populations, the assessment against a baseline with what was
# asked (some files of version 3 lack the question), and the versions it was made with. No pickle; every part
# has a checksum. Older ones are read as well: version 1 kept an updated model as the problem it came from,
# version 2 had no assessment.


FORMAT_RESULTS, VERSION_RESULTS = "antires_rs.result", 3
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
        "format": FORMAT_RESULTS,
        "version": VERSION_RESULTS,
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
        "options": dict(result.options),
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
    wanted = f"a file written by {kind.__name__}.save, version {VERSION_RESULTS} or older"
    file, data = read_store(
        path,
        FORMAT_RESULTS,
        VERSION_RESULTS,
        wanted,
        "It was cut, or is another file: name the result.npz of a run.",
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
    return made(problem, search, data["seed"], *more, options=data.get("options"))

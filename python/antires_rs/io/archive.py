"""One codec for what is saved: a value as JSON and arrays in one archive, every part with its SHA-256.

A value of one of our classes stands as ``{"class": name, field: ...}``, an array as ``{"array": "a3"}``, a
tuple as ``{"tuple": [...]}``, a dict as ``{"dict": [[key, value], ...]}``, infinity as ``{"float": "inf"}``.
A field that a file lacks has its default. Nothing is pickled. At the end: what files of before held.
"""

from __future__ import annotations

import json
import math
import os
import platform
from collections.abc import Callable
from dataclasses import MISSING, fields, is_dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import __version__
from ..damage import assessor_plan, hypotheses, inference, likelihood, options
from ..damage.assess import Assessor, DamageResult
from ..damage.assessor_plan import LEVELS, Plan, Tables
from ..damage.hypotheses import Assessment, Hypotheses, Hypothesis
from ..damage.inference import Learned
from ..damage.likelihood import Question
from ..damage.options import DamagePrior, SearchOptions
from ..exceptions import reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..models import frame_parts, recipes, structural_model
from ..models.chain import MassSpringChain
from ..models.frame import FrameModel
from ..models.frame_parts import PARTS
from ..models.matrices import Entries
from ..models.matrix_model import MatrixModel
from ..models.parameters import AppliedParameters, Parameter
from ..models.recipes import ChainRecipe, FrameRecipe, MatrixRecipe
from ..models.structural_model import ModelDescription, Recipe, StructuralModel
from ..optimize import island_ga
from ..optimize.island_ga import History, OptimizeResult
from ..support.messages import warn
from ..updating.problem import DamagePenalty, UpdatingProblem
from ..updating.result import UpdateResult
from .common import BYTES_OF_DOF, bounded, existing_file, parts_of, unsuitable
from .options import PathLike
from .own_format import TEXT, read_archive, write_archive


class Store:
    """The arrays of a file being written."""

    def __init__(self) -> None:
        self.arrays: dict[str, NDArray[Any]] = {}

    def put(self, array: Any) -> dict[str, str]:
        """Keep an array; returns what stands for it in the text."""
        name = f"a{len(self.arrays)}"
        self.arrays[name] = np.ascontiguousarray(array)
        return {"array": name}


def write_store(path: PathLike, data: dict[str, Any], store: Store) -> Path:
    """Write text, arrays and their hashes, whole or not at all."""
    hashes = {name: _digest(array) for name, array in store.arrays.items()}
    text = json.dumps({**data, "sha256": hashes}, allow_nan=False, indent=1)
    own = np.frombuffer(sha256(text.encode()).digest(), dtype=np.uint8)
    return write_archive(path, text, {**store.arrays, "text_sha256": own})


def read_store(path: PathLike, form: str, version: int, wanted: str) -> tuple[Path, dict[str, Any]]:
    """The text with its arrays in place, all hashes compared."""
    file = existing_file(path)
    arrays = read_archive(file, wanted)
    with parts_of(file, wanted):
        if TEXT not in arrays or "text_sha256" not in arrays:
            unsuitable(file, "an archive of another kind", wanted)
        text = bytes(arrays[TEXT])
        if sha256(text).digest() != bytes(arrays["text_sha256"]):
            unsuitable(file, "whose text does not have its checksum", wanted)
        data = json.loads(text)
        if data.get("format") != form:
            unsuitable(file, f"which holds {data.get('format')!r}", wanted, "Name the right file.")
        if not isinstance(data.get("version"), int) or data["version"] > version:
            older = f"version {version} or older"
            unsuitable(file, f"of version {data.get('version')!r}", older, "Update antires_rs.")
        for name, digest in data["sha256"].items():
            if name not in arrays or _digest(arrays[name]) != digest:
                unsuitable(file, f"whose array {name} is missing or does not have its checksum", wanted)
        return file, _filled(data, arrays)


def _filled(value: Any, arrays: dict[str, NDArray[Any]]) -> Any:
    if isinstance(value, dict):
        if value.keys() == {"array"}:
            return arrays[value["array"]]
        return {key: _filled(item, arrays) for key, item in value.items()}
    return [_filled(item, arrays) for item in value] if isinstance(value, list) else value


def _digest(array: NDArray[Any]) -> str:
    head = f"{array.dtype.str}{array.shape}".encode()
    return sha256(head + np.ascontiguousarray(array).tobytes()).hexdigest()


# -- Values of our classes as plain data and arrays, and made again from them, bit-identical

_MODELS: dict[type[Recipe], type[StructuralModel]] = {ChainRecipe: MassSpringChain, FrameRecipe: FrameModel}
_MODELS |= {MatrixRecipe: MatrixModel}
#: What the constructors of classes take that are no dataclasses, or have fields that are not kept.
_FIELDS: dict[type, tuple[str, ...]] = {
    ModalSet: ("freq_hz", "shapes", "dofs", "damping_ratio", "std_hz", "std_shapes"),
    UpdatingProblem: ("model", "parameters", "measured", "misfit", "penalty", "weights"),
    Hypotheses: ("rows", "names"),
    Entries: Entries._fields,
}
_HOMES = [assessor_plan, inference, hypotheses, likelihood, options, frame_parts, recipes, structural_model]
_HOMES.append(island_ga)
#: Classes by the names that stand in files: our dataclasses, as these modules know them, and those above.
_CLASSES: dict[str, Any] = {}
for _home in _HOMES:
    _CLASSES |= {name: each for name, each in vars(_home).items() if is_dataclass(each)}
_OTHERS = (*_FIELDS, *_MODELS.values(), AntiresonanceSet, Parameter, DamagePenalty)
_CLASSES |= {each.__name__: each for each in _OTHERS}


def encoded(value: Any, store: Store) -> Any:
    """A value as plain data; its arrays go into the store."""
    kind = type(value)
    if isinstance(value, float) and not math.isfinite(value):
        return {"float": repr(float(value))}
    if isinstance(value, np.generic):
        return encoded(value.item(), store)
    if isinstance(value, np.ndarray):
        return store.put(value)
    if isinstance(value, AntiresonanceSet):
        return {"class": kind.__name__, "json": value.to_json()}
    if isinstance(value, StructuralModel):
        if kind is not _MODELS[type(value.description.recipe)]:
            wanted = "a MassSpringChain, FrameModel or MatrixModel"
            reject("model", kind.__name__, wanted, "Build the model as one of these first.")
        return {"class": kind.__name__, "description": encoded(value.description, store)}
    if kind in _FIELDS or is_dataclass(value):
        names = _FIELDS.get(kind) or tuple(each.name for each in fields(value) if each.init)
        rows = {"rows": tuple(value)} if isinstance(value, Hypotheses) else {}
        held = {name: rows[name] if name in rows else getattr(value, name) for name in names}
        return {"class": kind.__name__, **{name: encoded(each, store) for name, each in held.items()}}
    if isinstance(value, dict):
        return {"dict": [[encoded(key, store), encoded(each, store)] for key, each in value.items()]}
    if isinstance(value, tuple | list):
        made = [encoded(each, store) for each in value]
        return {"tuple": made} if isinstance(value, tuple) else made
    return value


def decoded(data: Any, name: str) -> Any:
    """The value that :func:`encoded` took; ``name`` is the file's, for messages."""
    if isinstance(data, list):
        return [decoded(each, name) for each in data]
    if not isinstance(data, dict):
        return data
    if "class" not in data:
        ((kind, kept),) = data.items()
        if kind == "float":
            return float(kept)
        if kind == "tuple":
            return tuple(decoded(each, name) for each in kept)
        return {decoded(key, name): decoded(each, name) for key, each in kept}
    if data["class"] not in _CLASSES:
        reject("path", f"{name!r} with a {data['class']!r}", "what this version knows", "Update antires_rs.")
    made = _CLASSES[data["class"]]
    parts = {key: decoded(each, name) for key, each in data.items() if key != "class"}
    if made is AntiresonanceSet:
        return AntiresonanceSet.from_json(parts["json"], name)
    if issubclass(made, StructuralModel):
        return made.from_description(parts["description"])
    return within(made(**parts), Path(name))


def within(recipe: Any, file: Path) -> Any:
    """What it is given; of matrices the size is bounded and the entries are inside, which others trust."""
    if not isinstance(recipe, MatrixRecipe):
        return recipe
    n, tied = recipe.n_dof, recipe.constraints
    size = n if tied is None else max(n, int(tied.rows.max()) + 1)
    bounded(file, BYTES_OF_DOF * size, f"with {size} dofs")
    held = (recipe.stiffness, recipe.mass, *recipe.stiffness_terms, *recipe.mass_terms)
    if any(np.max([each.rows, each.columns], initial=0) >= n for each in held):
        raise ValueError(f"entries outside its {n} dofs")
    return recipe


def versions() -> dict[str, str]:
    """What made a file: this package, what it computes with, and the system."""
    import scipy  # slow to load

    made = {"antires_rs": __version__, "numpy": np.__version__, "scipy": scipy.__version__}
    return made | {"python": platform.python_version(), "system": platform.platform()}


def _in_npz(path: PathLike) -> None:
    if isinstance(path, str | os.PathLike) and Path(path).suffix != ".npz":
        reject("path", str(path), "a file that ends in .npz", "Append .npz to the name.")


# -- Assessors as files: question, tables, and what was learned

FORMAT, VERSION = "antires_rs.assessor", 2


def save_assessor(assessor: Assessor, path: PathLike) -> Path:
    """Write an assessor, whole or not at all; see :meth:`Assessor.save`."""
    _in_npz(path)
    store, plan = Store(), assessor._plan
    parts = {"question": plan.question, "levels": LEVELS, "tables": plan.tables, "learned": plan.learned}
    data = {name: encoded(each, store) for name, each in parts.items()}
    return write_store(path, {"format": FORMAT, "version": VERSION, **data}, store)


def load_assessor(path: PathLike) -> Assessor:
    """Read what :func:`save_assessor` wrote; see :meth:`Assessor.load`."""
    wanted = f"a file written by Assessor.save, version {VERSION} or older"
    file, data = read_store(path, FORMAT, VERSION, wanted)
    with parts_of(file, wanted):
        if not np.array_equal(data["levels"], LEVELS):
            unsuitable(file, "with tables of another version", wanted, "Make and save the assessor anew.")
        if data["version"] == 1:
            learned = Learned(**{key: _plain_3(value) for key, value in data["learned"].items()})
            asked = _question_3(data["question"], str(file), reduced=data["reduced"])
            tables = {each.name: data["tables"][each.name] for each in fields(Tables)}
            plan = Plan(asked, Tables(**tables), learned)
        else:
            plan = Plan(*(decoded(data[name], str(file)) for name in ("question", "tables", "learned")))
    return Assessor._of(plan)


# -- Results of updating and damage assessment: what was asked, how it went, what came out, by which versions

FORMAT_RESULTS, VERSION_RESULTS = "antires_rs.result", 4
_PARTS = ("problem", "search", "assessment", "question", "options")
_RESULTS = {"UpdateResult": UpdateResult, "DamageResult": DamageResult}


def save_result(result: UpdateResult, path: PathLike) -> Path:
    """Write a result, whole or not at all; see :meth:`UpdateResult.save`."""
    _in_npz(path)
    store = Store()
    assessed = [getattr(result, name, None) for name in ("_assessment", "_question")]
    parts = dict(zip(_PARTS, (result.problem, result.search, *assessed, dict(result.options)), strict=True))
    data = {"format": FORMAT_RESULTS, "version": VERSION_RESULTS, "class": type(result).__name__}
    data |= {"seed": result.seed, **{name: encoded(each, store) for name, each in parts.items()}}
    return write_store(path, data | {"made_with": versions()}, store)


def load_result(path: PathLike, kind: type[UpdateResult] = UpdateResult) -> Any:
    """Read what :func:`save_result` wrote; see :meth:`UpdateResult.load`."""
    wanted = f"a file of {kind.__name__}.save, as the result.npz of a run, version {VERSION_RESULTS} or older"
    file, data = read_store(path, FORMAT_RESULTS, VERSION_RESULTS, wanted)
    with parts_of(file, wanted):
        made = _RESULTS[data["class"]]
        if not issubclass(made, kind):
            unsuitable(file, f"which holds an {made.__name__}", wanted, f"Use {made.__name__}.load.")
        if data["version"] < 4:
            parts = _result_3(data, str(file))
        else:
            parts = [decoded(data[name], str(file)) for name in _PARTS]
        problem, search, *assessed, held = parts
        cost = problem.cost(search.x)
        if not np.isclose(cost, search.fun, rtol=1e-9, atol=1e-12):
            made_by = f"was made by antires_rs {data['made_with']['antires_rs']}"
            said = f"its objective was {search.fun:.9g} where this version computes {cost:.9g}."
            warn("other_version", f"path: {str(file)!r} {made_by}; {said}")
        asked = assessed if assessed[0] is not None else ()
        return made(problem, search, data["seed"], *asked, options=held)


# -- Files of the versions before: results 1 to 3, assessors 1, matrices 1
#
# Version 1 of results kept an updated model as the problem it came from, 2 had no assessment, some of 3 lack
# its question.


def _result_3(data: dict[str, Any], name: str) -> list[Any]:
    raw = {"njev": None, **data["search"]}  # version 1 did not count linearizations
    search = OptimizeResult(history=History(**raw.pop("history")), **raw)
    found, asked = data.get("assessment"), data.get("question")
    posed = data["problem"]
    more = {each: posed[each] for each in ("misfit", "weights")}
    more["penalty"] = None if posed["penalty"] is None else DamagePenalty(**posed["penalty"])
    sets = [_set_3(each, name) for each in posed["measured"]]
    parameters = _parameters_3(posed["parameters"])
    problem = UpdatingProblem(_model_3(posed["model"], name), parameters, sets, **more)
    assessment = None if found is None else _assessment_3(found)
    question = None if asked is None else _question_3(asked, name)
    return [problem, search, assessment, question, data.get("options")]


def _parameters_3(rows: list[dict[str, Any]]) -> tuple[Parameter, ...]:
    return tuple(Parameter(**{key: _plain_3(value) for key, value in row.items()}) for row in rows)


def _set_3(data: dict[str, Any], name: str) -> Any:
    if data["kind"] == "antiresonances":
        return AntiresonanceSet.from_json(json.dumps(data["set"]), name)
    return ModalSet(**{key: data.get(key) for key in _FIELDS[ModalSet]})


def _question_3(data: dict[str, Any], name: str, *, reduced: bool = False) -> Question:
    before, now = (tuple(_set_3(each, name) for each in data[state]) for state in ("baseline", "measured"))
    prior, elements = DamagePrior(**data["prior"]), tuple(data["elements"])
    search = SearchOptions(**(data.get("options") or {"std_common": data["std_common"]}))
    return Question(_model_3(data["model"], name), before, now, elements, prior, search, reduced=reduced)


def _plain_3(value: Any) -> Any:
    """A field of an assessment, or of what an assessor learned."""
    if isinstance(value, dict):
        ((kind, kept),) = value.items()
        return float(kept) if kind == "float" else tuple(kept.tolist() if kind == "floats" else kept)
    return tuple(value) if isinstance(value, list) else value


def _assessment_3(data: dict[str, Any]) -> Assessment:
    table = data["hypotheses"]
    ends = np.cumsum([0 if elements == [-1] else len(elements) for elements in table["elements"]])[:-1]
    names = ("severities", "low", "high")
    ragged = ([tuple(part.tolist()) for part in np.split(table[key], ends)] for key in names)
    columns = (map(tuple, table["elements"]), table["probability"].tolist(), *ragged, table["candidate"])
    rows = [Hypothesis(*row) for row in zip(*columns, strict=True)]
    values: dict[str, Any] = {"hypotheses": Hypotheses(rows, dict(table["names"]))}
    values["group"] = tuple(rows[nth] for nth in data["group"])
    for each in fields(Assessment):
        if each.name not in values and (each.name in data or each.default is MISSING):
            value = data[each.name]
            values[each.name] = _plain_3(value.tolist() if isinstance(value, np.ndarray) else value)
    return Assessment(**values)


def _model_3(data: dict[str, Any], name: str) -> StructuralModel:
    if data["kind"] == "updated":
        problem, values = data["problem"], data["x"]
        parameters = _parameters_3(problem["parameters"])
        if problem["penalty"] is not None:  # the problem set severities below ``snap`` to zero first
            reductions = np.array([p.quantity == "stiffness_reduction" for p in parameters])
            values = np.where(reductions & (np.abs(values) < problem["penalty"]["snap"]), 0.0, values)
        return _model_3(problem["model"], name).with_parameters(parameters, values)
    recipe: Recipe = within(_RECIPES_3[data["kind"]](data), Path(name))
    rows = data.get("applied", ())  # version 1 has none
    applied = tuple(AppliedParameters(_parameters_3(one["parameters"]), one["values"]) for one in rows)
    return _MODELS[type(recipe)].from_description(ModelDescription(recipe, applied))


def recipe_1(data: dict[str, Any]) -> MatrixRecipe:
    """Matrices as results 3 and matrices 1 have them."""

    def entries(parts: list[Any]) -> Entries:
        rows, columns, values = parts
        return Entries(np.asarray(rows, dtype=np.uint32), np.asarray(columns, dtype=np.uint32), values)

    both = (entries(data["stiffness"]), entries(data["mass"]))
    stiffness_terms, mass_terms = (tuple(map(entries, each)) for each in data["terms"])
    held = data.get("constraints")  # not in older files
    names, keep = (tuple(data.get(name, ())) for name in ("names", "keep"))
    constraints = None if held is None else entries(held)
    return MatrixRecipe(data["n_dof"], *both, stiffness_terms, mass_terms, names, constraints, keep)


def _frame_3(data: dict[str, Any]) -> FrameRecipe:
    sections = (dict(each) for each in data["sections"])
    held: dict[str, Any] = {name: data[name] for name in ("nodes_m", "orientation")}
    held |= {"beams": tuple(map(tuple, data["elements"])), "fixed": tuple(map(tuple, data["fixed"]))}
    held["section_names"] = tuple(data["section_names"])
    held["sections"] = tuple(_CLASSES[each.pop("type")](**each) for each in sections)
    parts = {name: tuple(map(kind._of_saved, data.get(name, ()))) for name, kind in PARTS.items()}
    return FrameRecipe(**held, parts=parts)


_RECIPES_3: dict[str, Callable[[dict[str, Any]], Recipe]] = {
    "chain": lambda data: ChainRecipe(**{each.name: data[each.name] for each in fields(ChainRecipe)}),
    "matrices": recipe_1,
    "frame": _frame_3,
}

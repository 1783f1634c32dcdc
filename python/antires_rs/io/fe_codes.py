r"""Models from runs of the user's finite-element code: matrices, and the terms of groups of elements.

.. math:: K(s) = K(1) + \sum_p (s^p - 1) K_p, \qquad p \in \{-1, 1, 2, 3, 4\}

s is a factor on the value of one group (a modulus, a thickness): the code runs with a few of them, the
differences give :math:`K_p`. A modulus needs one run, as p is 1. Last, one run with other values of all
groups must come out as the terms say: neither a code nor a reader is believed.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from hashlib import sha256
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal, NoReturn

import numpy as np

from ..exceptions import AntiresError, InvalidInputError, reject
from ..models.matrices import Entries
from ..models.matrix_model import MatrixModel
from ..models.term_groups import Mesh, Powers, TermGroup
from ..support.checks import integer
from ..support.directions import point_of
from ..support.files import alive, write_atomically
from ..support.messages import some
from ..support.progress import waiting
from ..support.workers import Failed, Workers, processors
from .archive import Store, decoded, encoded, read_store, write_store
from .fe_programs import Asked, Code, Factors, Run, opened
from .matrix_files import write_matrices
from .mesh_files import read_mesh
from .options import PathLike

__all__ = ["read_model", "write_model"]

# -- Runs in folders of their own, kept by a hash of all they depend on

FORMAT, VERSION = "antires_rs.run", 1


def _temporary(prefix: str, parent: Path | None = None) -> TemporaryDirectory[str]:
    return TemporaryDirectory(prefix=prefix, dir=parent, ignore_cleanup_errors=True)


class Runs:
    """Runs of a code, each once; ``folder`` keeps them for the next time."""

    def __init__(self, code: Code, folder: Path, workers: int) -> None:
        self._code, self._folder, self._workers = code, folder, workers
        (self.base,) = self._each([{}], lambda run, _: run)
        self._both = self.base.both(self.base.n_dof)

    def changes(self, several: Sequence[Factors]) -> list[tuple[Any, Any]]:
        """How stiffness and mass change with each, as sparse arrays."""
        return [each.both(self.base.n_dof) for each in self._each(several, self._difference)]

    def _each(self, several: Sequence[Factors], made: Callable[[Run, Factors], Run]) -> list[Run]:
        def kept(factors: Factors) -> Run:
            return self._kept(factors, made)

        with ThreadPoolExecutor(self._workers) as threads:
            try:
                with Workers(kept, threads, seconds_a_chunk=0.0, losses=0) as workers:
                    runs: list[Run] = []
                    for one in workers.in_order(list(several), what="run", errors="return"):
                        if isinstance(one, Failed):
                            if changed := several[len(runs)]:
                                one.error.add_note(f"This was the run with {dict(changed)}, as factors.")
                            raise one.error
                        runs.append(one)
                    return runs
            except BaseException:  # Ctrl-C among them: what runs would be waited for
                self._code.stop()
                raise

    def _difference(self, run: Run, factors: Factors) -> Run:
        if run.names != self.base.names or run.n_dof != self.base.n_dof:
            got = f"{run.n_dof} rows with {dict(factors)}, {self.base.n_dof} before"
            wanted = "a model whose dofs stay the same when the value of a group changes"
            remedy = "CalculiX makes other rows where thicknesses of shells begin to differ: take all as one."
            reject(("groups", next(iter(factors))), got, wanted, remedy)
        made = []
        for now, before in zip(run.both(run.n_dof), self._both, strict=True):
            change = (now - before).tocsr()
            size = abs(now).maximum(abs(before))
            made.append(Entries.of_sparse(change.multiply(abs(change) > self._code.rounding * size).tocsr()))
        return Run(made[0], made[1])

    def _kept(self, factors: Factors, made: Callable[[Run, Factors], Run]) -> Run:
        """What a run gave, if it was made before, or now."""
        parts = [f"{FORMAT} {VERSION}", self._code.text({}), self._code.text(factors)]
        key = sha256("\0".join(parts).encode()).hexdigest()[:32]
        file, wanted = self._folder / f"{key}.npz", "a run that was kept"
        if file.is_file():
            try:
                return Run(**decoded(read_store(file, FORMAT, VERSION, wanted)[1]["run"], str(file)))
            except AntiresError:
                pass  # damaged: it is run again
        with _temporary(f"{os.getpid()}-", self._folder) as folder:
            run = made(self._code.run(Path(folder), factors), factors)
        store = Store()
        write_store(file, {"format": FORMAT, "version": VERSION, "run": encoded(vars(run), store)}, store)
        return run


# -- Terms from differences

_POWERS = (1, 2, 3, -1, 4)
POLYNOMIAL = 1e-6  # of the entries, what a polynomial may miss
_STRAIGHT = 1e-10  # below, more powers are not tried


class Fitted:
    """Entries of a matrix by power of a value, from changes at some factors."""

    def __init__(self, factors: Sequence[float], changes: Sequence[Any], sizes: Any) -> None:
        n = changes[0].shape[0]
        entries = [each.tocoo() for each in changes]
        flat = [each.row.astype(np.int64) * n + each.col for each in entries]
        self._at = np.unique(np.concatenate(flat))
        self._n = n
        values = np.zeros((len(factors), self._at.size))
        for row, at, each in zip(values, flat, entries, strict=True):
            row[np.searchsorted(self._at, at)] = each.data
        scale = sizes[self._at // n] * sizes[self._at % n]
        self.remainder = np.inf
        for powers in self._sets(len(factors)):
            by = np.array([[s**p - 1.0 for p in powers] for s in factors])
            found = np.linalg.pinv(by) @ values
            left = float((np.abs(by @ found - values) / scale).max(initial=0.0))
            if left < 0.1 * self.remainder:  # further powers must earn their place
                self.remainder, self._found, self._chosen = left, found, powers
            if self.remainder <= _STRAIGHT:
                break

    @staticmethod
    def _sets(runs: int) -> Iterator[tuple[int, ...]]:
        """Powers, one fewer than runs, so that the last run is a check; of one run the line."""
        for count in range(1, max(2, runs)):
            yield from combinations(_POWERS[: 1 if count == 1 and runs < 3 else None], count)

    def terms(self) -> dict[int, Any]:
        """A sparse array for each power, without entries that are rounding."""
        from scipy.sparse import csr_array

        most = np.abs(self._found).max(axis=0, initial=0.0)
        made = {}
        for power, values in zip(self._chosen, self._found, strict=True):
            kept = np.abs(values) > 1e-11 * most
            at = self._at[kept]
            if at.size:
                places = at // self._n, at % self._n
                made[power] = csr_array((values[kept], places), shape=(self._n, self._n))
        return made


Terms = dict[str, tuple[dict[int, Any], dict[int, Any]]]  # of stiffness and mass by power, by group


class Finder:
    """Runs what each group needs, and checks all of it by one more run."""

    def __init__(self, code: Code, runs: Runs) -> None:
        self._code, self._runs = code, runs
        self._sizes = []
        for matrix in runs.base.both(runs.base.n_dof):
            own = np.sqrt(np.abs(matrix.diagonal()))
            self._sizes.append(np.maximum(own, 1e-6 * own.max(initial=1e-300)))

    def terms(self) -> Terms:
        """Those of all groups."""
        found: Terms = {}
        tried: dict[str, list[tuple[float, Any]]] = {each.name: [] for each in self._code.asked}
        for nth in range(2):
            open_ = [(each, each.rounds()) for each in self._code.asked if each.name not in found]
            tasks = [(each.name, s) for each, rounds in open_ if nth < len(rounds) for s in rounds[nth]]
            changes = self._runs.changes([{name: s} for name, s in tasks])
            for (name, s), change in zip(tasks, changes, strict=True):
                tried[name].append((self._code.written(name, s), change))
            for each, rounds in open_:
                fits = self._fit(each.name, tried[each.name])
                left = max(fit.remainder for fit in fits)
                if left <= self._code.tolerance or (nth and left <= POLYNOMIAL):
                    found[each.name] = fits[0].terms(), fits[1].terms()
                elif nth or len(rounds) == 1:
                    self._refuse(each.name, left)
                if each.name in found and not any(found[each.name]):
                    wanted = "a group that changes stiffness or mass"
                    reject(("groups", each.name), "a value that changes neither", wanted, "Correct the name.")
        self._check(found)
        return found

    def _fit(self, name: str, tried: Sequence[tuple[float, Any]]) -> list[Fitted]:
        factors = [factor for factor, _ in tried]
        changes = zip(*(change for _, change in tried), strict=True)
        return [Fitted(factors, each, sizes) for each, sizes in zip(changes, self._sizes, strict=True)]

    def _refuse(self, name: str, left: float) -> NoReturn:
        got = f"matrices that are no polynomial in its value: {left:.1g} of the entries is left"
        remedy = "Take another quantity, or the part of the group for which it is one."
        reject(("groups", name), got, f"powers from -1 to 4 that leave at most {POLYNOMIAL:g}", remedy)

    def _check(self, found: Terms) -> None:
        """All groups at other values in one run; where it differs, find which is the reason."""
        spread = [0.7 + round((0.191 + 0.309 * nth) % 0.5, 3) for nth in range(len(self._code.asked))]
        asked = zip(self._code.asked, spread, strict=True)
        factors = {each.name: 0.0 if each.quantity == "stiffness" else s for each, s in asked}
        if self._left(found, factors) <= self._allowed(found):
            return
        for name, factor in factors.items():
            left = self._left(found, {name: factor})
            if left > self._allowed(found):
                self._refuse(name, left)
        got = "groups whose changes do not add up: they act on the same elements"
        reject("groups", got, "groups of different elements", "Leave out some, or take them apart.")

    def _allowed(self, found: Terms) -> float:
        straight = all([*side] in ([], [1]) for sides in found.values() for side in sides)
        return self._code.tolerance if straight else POLYNOMIAL

    def _left(self, found: Terms, factors: Factors) -> float:
        """What a run differs by from the terms, as a share of the entries."""
        left = 0.0
        for side, change in enumerate(self._runs.changes([factors])[0]):
            for name, factor in factors.items():
                s = self._code.written(name, factor)
                for power, term in found[name][side].items():
                    change = change - (s**power - 1.0) * term
            entries, sizes = change.tocoo(), self._sizes[side]
            shares = np.abs(entries.data) / (sizes[entries.row] * sizes[entries.col])
            left = max(left, float(shares.max(initial=0.0)))
        return left


# -- The model


def read_model(
    source: Any,
    *,
    groups: Any,
    code: Literal["calculix", "opensees", "command", "python"] | None = None,
    command: str | None = None,
    out: PathLike | None = None,
    mesh: Mesh | PathLike | None = None,
    workers: int | None = None,
    progress: bool | None = None,
) -> MatrixModel:
    """A model from the input of a finite-element code, which is run for the terms of groups of elements.

    Parameters
    ----------
    source : path-like or callable
        Of CalculiX an input file (``.inp``). Of OpenSeesPy a script (``frame.py``), or one with the function
        that builds the model (``"frame.py:build"``). Of any other code an input file in which ``{name}``
        stands in place of the value of a group (``{name:.6e}`` for a field of few columns, ``{folder}`` for
        the folder of the file). A function of Python that returns stiffness, mass and, if it has them,
        names of the dofs.
    groups : str, sequence of str, or mapping
        What may be scaled, in a mapping by names of your own. CalculiX: ``"elset"`` or ``"material"``, a
        group for each that a section names; ``"WEB"``, the modulus of a set or material; ``"WEB:density"``,
        ``"SKIN:thickness"`` (of beams, both sides of the section); numbers of elements. OpenSeesPy: numbers
        of elements, whose whole stiffness and mass are the term, or arguments of the function, whose
        defaults are the values. Other codes: the number that stands for each name, ``{"web": 2.1e11}``.
    code : {'calculix', 'opensees', 'command', 'python'}, optional
        By default as ``source`` and ``command`` tell.
    command : str, optional
        How the code is run in a folder of its own, ``"nastran {input} batch=no"``; ``{stem}`` is the file
        without its ending. For CalculiX, ``ccx`` by default; for OpenSeesPy the Python that has it.
    out : path-like, optional
        File ``.npz`` for the model, for :func:`read_matrices`. Beside it ``.runs`` keeps what each run gave:
        called again after a stop, only what is not there is run.
    mesh : Mesh or path-like, optional
        Nodes and elements where the code gives none, or a file of them for :func:`antires_rs.io.read_mesh`.
        Nodes of the dofs must be among them.
    workers : int, optional
        Runs at a time. Default: one for each processor. No number depends on it.
    progress : bool, optional
        Show it on standard error. Default: on a terminal.

    Returns
    -------
    MatrixModel
        With ``groups``, ``mesh`` and names of the dofs (``"12:Z"``). A group that is linear in its value is a
        term with the name of the group, for :func:`stiffness_factor`, :func:`stiffness_reduction` and
        :func:`mass_factor`; of others each power is a term, ``"SKIN:thickness^3"``, and
        :meth:`MatrixModel.with_group_factors` has them together. Lengths, forces and masses are in the units
        of the code.

    Raises
    ------
    InvalidInputError
        Groups that are not there, overlap, change nothing, or change other than by powers of the value.
    UnsuitableDataError
        A run that fails.
    MissingDependencyError
        The code is not installed.

    Notes
    -----
    A value is scaled, the code writes its matrices, the difference is the term: one run for a modulus or a
    density, two for a number of the input in which they are straight lines, five for a polynomial with powers
    from -1 to 4 (CalculiX makes shells of solids: K has powers -1 and 1 of a thickness), of which one is a
    check. Last, all values at once are other ones, and K and M must be as the terms say, to 1e-9 of the
    entries; to 1e-6 where there are polynomials or the code writes few digits. Constraints stay as they are:
    CalculiX takes them out, those of OpenSees (``equalDOF``, ``rigidLink``, ``rigidDiaphragm``) become
    ``constraints=`` of the model. A row of a shell or beam of CalculiX is the node itself, or with
    ``, layer 2`` a layer of the solid it is expanded to; a thin one loses digits, as CalculiX writes 14
    (7e-6 of the first frequency where the thickness is a hundredth). See docs/fe_codes.md.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> def build(e_web=100.0, e_foot=300.0):
    ...     return np.array([[e_web + e_foot, -e_web], [-e_web, e_web]]), np.eye(2), ["foot", "tip"]
    >>> model = ar.read_model(build, groups=["e_web"])
    >>> model, model.groups["e_web"].value
    (MatrixModel(2 dofs, 1 stiffness terms, 0 mass terms), 100.0)
    >>> model.antiresonances("tip", "tip").round(3)
    array([3.183])
    """
    at_once = processors() if workers is None else integer("workers", workers, low=1, high=64)
    target = None if out is None else Path(out)
    if target is not None and (target.suffix != ".npz" or not target.parent.is_dir()):
        reject("out", str(out), "a file that ends in .npz, in a folder that exists", "Choose another name.")
    chosen = opened(source, code, command, groups)
    if mesh is not None and not isinstance(mesh, Mesh):
        try:
            mesh = read_mesh(mesh)
        except InvalidInputError as exc:
            raise type(exc)("mesh", exc.got, exc.wanted, exc.remedy) from exc
    with waiting(f"running {chosen.name}", progress), _folder(target if chosen.keeps else None) as folder:
        runs = Runs(chosen, folder, at_once if chosen.keeps else 1)
        base = runs.base if mesh is None else replace(runs.base, mesh=_fitting(mesh, runs.base.names))
        model = _model(chosen, base, Finder(chosen, runs).terms())
    if target is not None:
        write_matrices(target, model)
    return model


def _fitting(mesh: Mesh, names: Sequence[str]) -> Mesh:
    """The mesh, where nodes of the dofs are nodes of it."""
    points = (point_of(name) for name in names)
    there = {*mesh.nodes.tolist()}
    if unknown := sorted({point[0] for point in points if point is not None} - there):
        got = f"{len(there)} nodes without {some(unknown)}, which dofs have"
        remedy = "Give numbers of nodes: ar.io.read_mesh(file, nodes=...)."
        reject("mesh", got, "the mesh of the model", remedy)
    return mesh


@contextmanager
def _folder(target: Path | None) -> Iterator[Path]:
    """Where runs are kept: beside the model, or nowhere."""
    if target is None:
        with _temporary("antires_") as folder:
            yield Path(folder)
        return
    kept = target.with_suffix(".runs")
    kept.mkdir(exist_ok=True)
    for left in kept.glob("[0-9]*-*") if os.name == "posix" else ():  # by processes that were killed
        process = left.name.partition("-")[0]
        if process.isdigit() and not alive(int(process)):
            shutil.rmtree(left, ignore_errors=True)
    yield kept


def _model(code: Code, base: Run, found: Terms) -> MatrixModel:
    named: tuple[dict[str, Any], dict[str, Any]] = ({}, {})
    groups = []
    for each in code.asked:
        sides, powers = found[each.name], list[Powers]()
        linear = all({*side} <= {1} for side in sides)
        for terms, side in zip(named, sides, strict=True):
            powers.append(tuple((len(terms) + nth, power) for nth, power in enumerate(side)))
            terms |= {each.name if linear else f"{each.name}^{power}": term for power, term in side.items()}
        value, elements = base.values.get(each.place, each.value), np.array(each.elements, dtype=np.intp)
        groups.append(TermGroup(each.name, each.quantity, value, powers[0], powers[1], elements, each.place))
    k, m = base.both(base.n_dof)
    more: dict[str, Any] = {"dofs": base.names or None, "groups": groups, "mesh": base.mesh}
    if base.constraints:
        more["constraints"] = list(map(dict, base.constraints))
    return MatrixModel(k, m, stiffness_terms=named[0], mass_terms=named[1], **more)


def write_model(
    file: PathLike,
    source: PathLike,
    model: MatrixModel,
    *,
    code: Literal["calculix", "opensees", "command"] | None = None,
    command: str | None = None,
) -> Path:
    """The input of a finite-element code with the values that a model has now, as after an updating.

    Parameters
    ----------
    file : path-like
        The new input.
    source : path-like
        The input that :func:`read_model` had; it stays as it is.
    model : MatrixModel
        Of :func:`read_model`, scaled by parameters or :meth:`MatrixModel.with_group_factors`: often
        ``result.model``. What is written are its :attr:`MatrixModel.group_factors`.
    code, command
        As for :func:`read_model`.

    Returns
    -------
    pathlib.Path

    Raises
    ------
    InvalidInputError
        A model without groups, or whose groups are elements of a script; a source that has other values than
        the model was read with; the source as the new file.

    Notes
    -----
    Of CalculiX the whole input, with what it includes: elements of changed groups have a section and a
    material of their own. Of OpenSeesPy a script in which the function has other defaults. Of other codes the
    input with numbers in place of names. A run of the code gives the frequencies of the model.

    Examples
    --------
    >>> import sys, tempfile, pathlib, numpy as np, antires_rs as ar
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> _ = (folder / "bar.dat").write_text("modulus {web:.4e}")
    >>> web = ar.TermGroup("web", "value", 2.1e11, ((0, 1),))
    >>> model = ar.MatrixModel(np.eye(1), np.eye(1), stiffness_terms={"web": np.eye(1)}, groups=[web])
    >>> new = model.with_group_factors({"web": 0.9})
    >>> ar.write_model(folder / "new.dat", folder / "bar.dat", new, command="code {input}").read_text()
    'modulus 1.8900e+11'
    """
    if not isinstance(model, MatrixModel) or not model.groups:
        remedy = "Give what read_model returned, or the .model of a result for it."
        reject("model", model, "a MatrixModel with groups", remedy)
    chosen, target = opened(source, code, command), Path(file)
    named = str(source) if Path(str(source)).exists() else str(source).rpartition(":")[0]  # "frame.py:build"
    if target.exists() and Path(named).exists() and target.samefile(named):
        reject("file", str(file), "another file than the source", "Choose another name.")
    chosen.asked = [
        Asked(each.name, each.quantity, tuple(each.elements.tolist()), each.place, each.value)
        for each in model.groups.values()
    ]
    return write_atomically(target, chosen.input(model.group_factors, target).encode())

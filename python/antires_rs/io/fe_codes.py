r"""Models from runs of the user's finite-element code: matrices, and the terms of groups of elements.

.. math:: K(s) = K(1) + \sum_p (s^p - 1) K_p, \qquad p \in \{-1, 1, 2, 3, 4\}

s is a factor on the value of one group (a modulus, a thickness): the code runs with a few of them, the
differences give :math:`K_p`. A modulus needs one run, as p is 1. Last, one run with other values of all
groups must come out as the terms say: neither a code nor a reader is believed.
"""

from __future__ import annotations

import inspect
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from hashlib import sha256
from functools import partial
from itertools import combinations
from pathlib import Path
from typing import Any, Literal, NoReturn

import numpy as np

from ..exceptions import AntiresError, MissingDependencyError, UnsuitableDataError, reject
from ..models.constraints import eliminate_constraints
from ..models.matrices import Entries
from ..models.matrix_model import MatrixModel
from ..models.term_groups import Mesh, TermGroup
from ..support.checks import choice, finite_scalar, integer
from ..support.directions import names_of
from ..support.messages import some
from ..support.progress import waiting
from ..support.workers import Workers, processors
from . import _opensees, calculix
from .archive import Store, decoded, encoded, read_store, write_store
from .common import existing_file
from .matrix_files import FORMATS, OF_BOTH, choose, in_rows_of, matrices_in, write_matrices
from .options import PathLike
from .own_format import read_archive

# -- What is asked of a code, and what a run of it gives

LINEAR = ("youngs_modulus", "density")
Factors = Mapping[str, float]


@dataclass(frozen=True)
class Asked:
    """A group: what of it is scaled, in which elements or at which place of the input, from which value."""

    name: str
    quantity: str
    elements: tuple[int, ...] = ()
    place: str = ""
    value: float | None = None

    def rounds(self) -> tuple[tuple[float, ...], ...]:
        """Factors of the runs; those of the second round where the first shows no straight line."""
        if self.quantity == "stiffness":
            return ((0.0,),)  # without the elements
        return ((2.0,),) if self.quantity in LINEAR else ((1.5, 0.5), (0.75, 1.25, 0.875))


@dataclass(frozen=True, eq=False)
class Run:
    """Stiffness and mass as a run wrote them, or how they differ from those of the first run."""

    stiffness: Entries
    mass: Entries
    names: tuple[str, ...] = ()
    n_dof: int = 0
    constraints: tuple[tuple[tuple[int, float], ...], ...] = ()
    mesh: Mesh | None = None
    values: dict[str, float] = field(default_factory=dict)

    @property
    def both(self) -> tuple[Any, Any]:
        """Stiffness and mass as sparse arrays."""
        return self.stiffness.sparse(self.n_dof), self.mass.sparse(self.n_dof)


def _run_of(stiffness: Any, mass: Any, names: Sequence[Any] = (), **more: Any) -> Run:
    from scipy.sparse import coo_array

    k, m = (Entries.of_sparse(coo_array(each)) for each in (stiffness, mass))
    n = int(stiffness.shape[0])
    return Run(k, m, names_of("dofs", names or None, n), n, **more)


class Code:
    """A code with the model that it runs: one class each below."""

    name = ""
    rounding = 1e-15  # of the numbers that it writes
    tolerance = 1e-9  # of the last run against the terms, where all are straight lines

    def __init__(self, source: Any, command: str | None) -> None:
        self.source, self.command = source, command
        self.asked: list[Asked] = []
        self._lock, self._running, self._stopped = threading.Lock(), set[subprocess.Popen[bytes]](), False

    def ask(self, groups: Any) -> Iterator[Asked]:
        """The groups that a caller names."""
        raise NotImplementedError

    def text(self, factors: Factors) -> str:
        """All that a run depends on."""
        raise NotImplementedError

    def run(self, folder: Path, factors: Factors) -> Run:
        """Run in a folder."""
        raise NotImplementedError

    def written(self, name: str, factor: float) -> float:
        """The factor that a run has, where the input has few digits."""
        return factor

    def refuse(self, folder: Path, problem: str) -> NoReturn:
        """Raise for a run that failed."""
        remedy = f"Run {self.name} itself on {str(self.source)!r}; if that works, report this."
        raise UnsuitableDataError("source", f"{str(self.source)!r}: {problem}", "a model that runs", remedy)

    def execute(self, folder: Path, words: list[str], install: str) -> str:
        """What a program says, run in a folder with one thread, which makes its sums always the same."""
        threads = ("OMP_NUM_THREADS", "CCX_NPROC_STIFFNESS", "CCX_NPROC_RESULTS", "OPENBLAS_NUM_THREADS")
        log = folder / "antires.log"
        try:
            with self._lock, open(log, "wb") as opened:
                if self._stopped:
                    raise KeyboardInterrupt
                how: dict[str, Any] = {"cwd": folder, "stdout": opened, "stderr": subprocess.STDOUT}
                how |= {"stdin": subprocess.DEVNULL, "env": os.environ | dict.fromkeys(threads, "1")}
                process = subprocess.Popen(words, start_new_session=True, **how)
                self._running.add(process)
        except FileNotFoundError:
            raise MissingDependencyError(
                f"{self.name} is run as {words[0]!r}, which is not there. {install}"
            ) from None
        process.wait()
        self._running.discard(process)
        return log.read_text(encoding="utf-8", errors="replace")

    def stop(self) -> None:
        """End what runs; nothing begins any more."""
        with self._lock:
            self._stopped = True
            for process in self._running:
                process.kill()


def _by_name(groups: Any) -> dict[str, Any]:
    """What each group is, by its name."""
    wanted = "the name of a group, a list of such, or a mapping of names to what they are"
    if isinstance(groups, str):
        groups = [groups]
    if not isinstance(groups, Mapping):
        if not isinstance(groups, Sequence) or not all(isinstance(each, str) for each in groups):
            reject("groups", groups, wanted, 'As in groups=["web", "skin:thickness"].')
        groups = {each: each for each in groups}
    if not groups:
        reject("groups", "none", wanted, 'As in groups="elset": a group for each set that a section has.')
    return {str(name): target for name, target in groups.items()}


def _tags(name: str, given: Any) -> tuple[int, ...]:
    if (
        isinstance(given, str | float)
        or not isinstance(given, Sequence | range | np.ndarray)
        or not len(given)
    ):
        reject(("groups", name), given, "numbers of elements", "As in groups={'columns': [1, 2, 3]}.")
    return tuple(integer(("groups", name), each, low=0) for each in given)


def _apart(asked: Sequence[Asked]) -> None:
    """Refuse groups with elements in common: their values multiply there; modulus and density do not."""
    for one, other in combinations(asked, 2):
        common = {*one.elements} & {*other.elements}
        if common and {one.quantity, other.quantity} != {*LINEAR}:
            got = f"{one.name!r} and {other.name!r}, which share {len(common)} element(s), as {min(common)}"
            reject("groups", got, "groups of different elements", "Leave one out, or take them apart.")


# -- The codes


class CalculiX(Code):
    """An input file; groups are element sets or materials, and modulus, density or thickness of them."""

    name = "CalculiX"
    rounding = 1e-13
    _QUANTITIES = ("youngs_modulus", "density", "thickness")

    def __init__(self, source: Any, command: str | None) -> None:
        super().__init__(source, command)
        self.deck = calculix.Deck(existing_file(source))
        self._mesh = self.deck.mesh()
        self._words = shlex.split(command) if command else [_ccx(), "-i", "{stem}"]

    def ask(self, groups: Any) -> Iterator[Asked]:
        """``"elset"``, ``"material"``, ``"NAME"``, ``"NAME:density"``, or numbers of elements."""
        if isinstance(groups, str) and groups in ("elset", "material"):
            groups = self.deck.names(groups)
        for name, target in _by_name(groups).items():
            quantity = "youngs_modulus"
            if isinstance(target, str):
                target, _, stated = target.partition(":")
                quantity = choice("groups", stated or quantity, self._QUANTITIES)
                elements = tuple(dict.fromkeys(self.deck.elements_of(target)))
            else:
                elements = _tags(name, target)
            unknown = [each for each in elements if each not in self.deck.section_of]
            if unknown:
                remedy = "Springs, masses and the like cannot be in a group yet."
                reject(("groups", name), f"element {unknown[0]}", "elements that have a section", remedy)
            yield Asked(name, quantity, elements, value=self.deck.value(quantity, list(elements)))

    def text(self, factors: Factors) -> str:
        """The input file of the run."""
        groups = {each.name: (each.quantity, list(each.elements)) for each in self.asked}
        return " ".join(self._words) + "\n" + self.deck.text(groups, factors)

    def run(self, folder: Path, factors: Factors) -> Run:
        """The matrices that it stores."""
        (folder / "model.inp").write_text(self.text(factors).partition("\n")[2])
        words = [word.replace("{stem}", "model").replace("{input}", "model.inp") for word in self._words]
        install = 'Install CalculiX ("apt install calculix-ccx", or calculix.de), or name it by command=.'
        said = self.execute(folder, words, install)
        try:
            nodes = frozenset(self._mesh.nodes.tolist())
            stiffness, mass, names = calculix.stored(folder, "model", nodes)
        except (OSError, ValueError):
            self.refuse(folder, f"CalculiX says {calculix.errors_in(said)!r}")
        return _run_of(stiffness, mass, names, mesh=self._mesh)


def _ccx() -> str:
    """CalculiX on PATH: ``ccx``, or with its version behind."""
    found = shutil.which("ccx")
    for folder in os.get_exec_path() if found is None else ():
        found = found or next((str(file) for file in sorted(Path(folder).glob("ccx_[0-9]*"))), None)
    return found or "ccx"


class OpenSees(Code):
    """A script of OpenSeesPy; groups are elements, or arguments of a function in it that builds the model."""

    name = "OpenSeesPy"

    def __init__(self, source: Any, command: str | None) -> None:
        super().__init__(source, command)
        script, _, function = str(source).rpartition(".py")
        self._script, self._function = existing_file(script + ".py"), function.lstrip(":") or None
        self._words = shlex.split(command) if command else [sys.executable]

    def ask(self, groups: Any) -> Iterator[Asked]:
        """Numbers of elements, or the name of an argument."""
        for name, target in _by_name(groups).items():
            if not isinstance(target, str):
                yield Asked(name, "stiffness", _tags(name, target))
                continue
            if self._function is None:
                got = f"{target!r}, an argument, of {self._script.name!r}"
                remedy = f"Name it: {self._script.name}:build, or give numbers of elements."
                reject(("groups", name), got, "a function that builds the model with it", remedy)
            yield Asked(name, "value", place=target)

    def text(self, factors: Factors) -> str:
        """The script, those beside it, which it may import, and what is asked of it."""
        beside = sorted(self._script.resolve().parent.glob("*.py"))
        return "\n".join(
            [str(self._request(factors)), *self._words, *(f.read_text(errors="replace") for f in beside)]
        )

    def _request(self, factors: Factors) -> dict[str, Any]:
        of = {each.name: each for each in self.asked}
        removed = [tag for name in factors if of[name].elements for tag in of[name].elements]
        values = {of[name].place: factor for name, factor in factors.items() if not of[name].elements}
        script = str(self._script.resolve())
        return {"script": script, "function": self._function, "factors": values, "removed": sorted(removed)}

    def run(self, folder: Path, factors: Factors) -> Run:
        """The matrices of the model that the script builds."""
        out = folder / "model.npz"
        words = [*self._words, "-P", _opensees.__file__, json.dumps(self._request(factors)), str(out)]
        install = "Name the Python that has OpenSeesPy by command=."
        said = self.execute(folder, words, install)
        if not out.is_file():
            last = next((line for line in reversed(said.splitlines()) if ": " in line), said[-300:])
            if "ModuleNotFoundError" in last and "opensees" in last:
                raise MissingDependencyError(
                    f'OpenSeesPy is not there. Install it ("pip install openseespy"). {install}'
                )
            self.refuse(folder, f"it ended with {last[:300]!r}")
        return self._read(out, folder)

    def _read(self, out: Path, folder: Path) -> Run:
        a = read_archive(out)
        about = json.loads(bytes(a["text"]))
        n = len(a["points"])
        k, m = (
            Entries.joined(*(a[f"{side}.{part}"] for part in ("rows", "columns", "values")))
            for side in ("stiffness", "mass")
        )
        ties: dict[int, list[tuple[int, float]]] = {}
        for row, dof, value in a["ties"].tolist():
            ties.setdefault(int(row), []).append((int(dof), value))
        names = [(node, code) if code else f"{node} dof {nth}" for node, code, nth in a["points"].tolist()]
        if "reduced.mass" in a:
            made = eliminate_constraints(
                k.sparse(n), m.sparse(n), [dict(each) for each in ties.values()], keep=a["retained"].tolist()
            )
            for side in ("stiffness", "mass"):
                own, theirs = np.sort(getattr(made, side).diagonal()), a[f"reduced.{side}"]
                if own.shape != theirs.shape or np.abs(own - theirs).max() > 1e-9 * np.abs(theirs).max():
                    self.refuse(
                        folder, "its constraints are not those of equalDOF, rigidLink and rigidDiaphragm"
                    )
        kinds = tuple(about["kinds"])
        mesh = Mesh(a["nodes"], a["coordinates"], a["elements"], a["connectivity"], kinds, a["kind"])
        constraints = tuple(tuple(each) for each in ties.values())
        return Run(k, m, names_of("dofs", names, n), n, constraints, mesh, about["defaults"])


class Template(Code):
    """Any code: an input with ``{name}`` where a value stands, and a command that writes matrices."""

    name = "the command"
    tolerance = 1e-6  # punch files have seven digits

    def __init__(self, source: Any, command: str | None) -> None:
        super().__init__(source, command)
        self._file = existing_file(source)
        self._text = self._file.read_text(encoding="utf-8", errors="replace")
        self._words = shlex.split(command or "")

    def ask(self, groups: Any) -> Iterator[Asked]:
        """The number that stands in place of ``{name}``."""
        for name, value in _by_name(groups).items():
            if not self._places(name).search(self._text):
                got, wanted = (
                    f"{str(self._file)!r} without {{{name}}}",
                    "an input with that in place of the number",
                )
                reject(
                    ("groups", name),
                    got,
                    wanted,
                    f"Write {{{name}}}, or {{{name}:.6e}} for a field of few columns.",
                )
            yield Asked(name, "value", value=finite_scalar(("groups", name), value))

    @staticmethod
    def _places(name: str) -> re.Pattern[str]:
        return re.compile(rf"\{{{re.escape(name)}(?::([^{{}}]*))?\}}")

    def _shown(self, name: str, factor: float, form: str | None) -> str:
        value = next(each.value for each in self.asked if each.name == name) or 0.0
        return format(value * factor, form) if form else repr(value * factor)

    def _filled(self, name: str, factor: float, place: re.Match[str]) -> str:
        return self._shown(name, factor, place[1])

    def written(self, name: str, factor: float) -> float:
        """Of the first place where it stands."""
        found = self._places(name).search(self._text)
        form = found[1] if found else None
        return float(self._shown(name, factor, form)) / float(self._shown(name, 1.0, form))

    def text(self, factors: Factors) -> str:
        """The input file of the run."""
        text = self._text
        for each in self.asked:
            factor = factors.get(each.name, 1.0)
            text = self._places(each.name).sub(partial(self._filled, each.name, factor), text)
        return f"{self.command}\n" + text.replace("{folder}", str(self._file.resolve().parent))

    def run(self, folder: Path, factors: Factors) -> Run:
        """The matrices that it leaves in the folder."""
        name = self._file.name
        (folder / name).write_text(self.text(factors).partition("\n")[2])
        marks = {"{input}": name, "{stem}": Path(name).stem}
        words = [re.sub(r"\{input\}|\{stem\}", lambda m: marks[m[0]], word) for word in self._words]
        said = self.execute(folder, words, 'Correct command=, as in "nastran {input} batch=no".')
        written = sorted(each for each in folder.iterdir() if each.name not in (name, "antires.log"))
        files = [each for each in written if each.name.lower().endswith(tuple(FORMATS))]
        both = [
            each
            for each in files
            if each.name.lower().endswith(OF_BOTH) and len(matrices_in("source", each)) > 1
        ]
        pair = [both[0]] * 2 if both else [next((f for f in files if p.search(f.name)), None) for p in _SIDES]
        if None in pair:
            listed = some((each.name for each in written), 8) or "no file"
            self.refuse(
                folder,
                f"the command left {listed}, and no stiffness and mass; it said {said[-200:].strip()!r}",
            )
        k, m = (choose("source", file, letter) for file, letter in zip(pair, "KM", strict=True))  # type: ignore[arg-type]
        names = [] if k.points is None else list(k.points)
        return _run_of(k.matrix, in_rows_of("source", m, k), names)


#: Files of stiffness and of mass by their names: ``job_STIF1.mtx``, ``K.op4``.
_SIDES = re.compile(r"stif|(?:^|[_.-])k\d*[_.-]", re.I), re.compile(r"mass|(?:^|[_.-])m\d*[_.-]", re.I)


class Hook(Code):
    """A function of Python that returns stiffness and mass, and names of the dofs if it has them."""

    name = "the function"

    def ask(self, groups: Any) -> Iterator[Asked]:
        """Names of arguments with a number as their default."""
        defaults = {name: p.default for name, p in inspect.signature(self.source).parameters.items()}
        for name, place in _by_name(groups).items():
            value = defaults.get(place)
            if isinstance(value, bool) or not isinstance(value, int | float):
                wanted = "an argument of the function with a number as its default"
                reject(("groups", name), place, wanted, "As in def build(e_web=2.1e11): return K, M.")
            yield Asked(name, "value", place=place, value=float(value))

    def text(self, factors: Factors) -> str:
        """Its source, as far as it can be had."""
        try:
            source = inspect.getsource(self.source)
        except (OSError, TypeError):
            source = os.urandom(16).hex()
        return f"{dict(factors)}\n{source}"

    def run(self, folder: Path, factors: Factors) -> Run:
        """What it returns."""
        from scipy.sparse import coo_array

        values = {
            each.place: (each.value or 0.0) * factors[each.name]
            for each in self.asked
            if each.name in factors
        }
        k, m, *names = self.source(**values)
        return _run_of(coo_array(k), coo_array(m), names[0] if names else ())


CODES: dict[str, Callable[[Any, str | None], Code]]
CODES = {"calculix": CalculiX, "opensees": OpenSees, "command": Template, "python": Hook}


def _code_of(source: Any, code: str | None, command: str | None) -> Code:
    if code is None:
        name, own = str(source).lower(), command is None or "ccx" in command
        known = {"python": callable(source), "opensees": name.endswith(".py") or ".py:" in name}
        known |= {"calculix": name.endswith(".inp") and own, "command": command is not None}
        code = next((each for each, fits in known.items() if fits), None)
        if code is None:
            wanted = (
                "a .inp of CalculiX, a .py of OpenSeesPy, an input of any code with command=, or a function"
            )
            reject("source", str(source), wanted, "Say code= where the ending does not tell.")
    choice("code", code, tuple(CODES))
    if code == "command" and not command:
        reject("command", None, "how the code is run", 'As in command="nastran {input} batch=no".')
    if callable(source) != (code == "python"):
        reject(
            "source", str(source), f"what code={code!r} takes", "A function for 'python', a file for others."
        )
    return CODES[code](source, command)


# -- Runs in folders of their own, kept by a hash of all they depend on

FORMAT, VERSION = "antires_rs.run", 1


class Runs:
    """Runs of a code, each once; ``folder`` keeps them for the next time."""

    def __init__(self, code: Code, folder: Path, workers: int) -> None:
        self._code, self._folder, self._workers = code, folder, workers
        self.base: Run = self._kept({}, lambda run: run)
        self._both = self.base.both

    def changes(self, several: Sequence[Factors]) -> list[tuple[Any, Any]]:
        """How stiffness and mass change with each, as sparse arrays."""
        n, what = self.base.n_dof, f"run of {self._code.name}"
        with ThreadPoolExecutor(self._workers) as threads:
            try:
                with Workers(self._change, threads, seconds_a_chunk=0.0, losses=0) as workers:
                    found = list(workers.in_order(list(several), what=what))
            except BaseException:  # Ctrl-C among them: what runs would be waited for
                self._code.stop()
                raise
        return [replace(each, n_dof=n).both for each in found]

    def _change(self, factors: Factors) -> Run:
        return self._kept(factors, lambda run: self._difference(run, factors))

    def _difference(self, run: Run, factors: Factors) -> Run:
        if run.names != self.base.names or run.n_dof != self.base.n_dof:
            got = f"{run.n_dof} rows with {dict(factors)}, {self.base.n_dof} before"
            wanted = "a model whose dofs stay the same when the value of a group changes"
            remedy = (
                "Where thicknesses of shells begin to differ, CalculiX makes other rows: take all as one."
            )
            reject(("groups", next(iter(factors))), got, wanted, remedy)
        made = []
        for now, before in zip(run.both, self._both, strict=True):
            change = (now - before).tocsr()
            size = abs(now).maximum(abs(before))
            made.append(Entries.of_sparse(change.multiply(abs(change) > self._code.rounding * size).tocsr()))
        return Run(made[0], made[1])

    def _kept(self, factors: Factors, of: Callable[[Run], Run]) -> Run:
        """What a run gave, if it was made before, or now."""
        parts = [f"{FORMAT} {VERSION}", self._code.text({}), self._code.text(factors)]
        key = sha256("\0".join(parts).encode()).hexdigest()[:32]
        file, wanted = self._folder / f"{key}.npz", "a run that was kept"
        if file.is_file():
            try:
                return Run(**decoded(read_store(file, FORMAT, VERSION, wanted)[1]["run"], str(file)))
            except AntiresError:
                pass  # damaged: it is run again
        with tempfile.TemporaryDirectory(
            prefix=f"{key[:8]}.", dir=self._folder, ignore_cleanup_errors=True
        ) as folder:
            run = of(self._code.run(Path(folder), factors))
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
        self.powers: dict[int, Any] = {}
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
                made[power] = csr_array(
                    (values[kept], (at // self._n, at % self._n)), shape=(self._n, self._n)
                )
        return made


Terms = dict[str, tuple[dict[int, Any], dict[int, Any]]]  # of stiffness and mass by power, by group


class Finder:
    """Runs what each group needs, and checks all of it by one more run."""

    def __init__(self, code: Code, runs: Runs) -> None:
        self._code, self._runs = code, runs
        self._sizes = []
        for matrix in runs.base.both:
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
        got = f"matrices that are no polynomial in its value: {left:.1g} of the largest entries is left"
        remedy = "Take another quantity, or the part of the group for which it is one."
        reject(("groups", name), got, f"powers from -1 to 4 that leave at most {POLYNOMIAL:g}", remedy)

    def _check(self, found: Terms) -> None:
        """All groups at other values in one run; where it differs, find which is the reason."""
        factors = {
            each.name: 0.0
            if each.quantity == "stiffness"
            else 0.75 + round(0.5 * (0.382 + 0.618 * nth) % 0.5, 3)
            for nth, each in enumerate(self._code.asked)
        }
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
        called again after a stop, or with other groups, only what is not there is run.
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
    chosen = _code_of(source, code, command)
    chosen.asked = list(chosen.ask(groups))
    _apart(chosen.asked)
    with waiting(f"running {chosen.name}", progress), _folder(target) as folder:
        runs = Runs(chosen, folder, at_once)
        model = _model(chosen, runs.base, Finder(chosen, runs).terms())
    if target is not None:
        write_matrices(target, model)
    return model


@contextmanager
def _folder(target: Path | None) -> Iterator[Path]:
    """Where runs are kept: beside the model, or nowhere."""
    if target is None:
        with tempfile.TemporaryDirectory(prefix="antires_", ignore_cleanup_errors=True) as folder:
            yield Path(folder)
        return
    kept = target.with_suffix(".runs")
    kept.mkdir(exist_ok=True)
    yield kept


def _model(code: Code, base: Run, found: Terms) -> MatrixModel:
    sides: tuple[dict[str, Any], dict[str, Any]] = ({}, {})
    groups = []
    for each in code.asked:
        powers: list[tuple[tuple[int, int], ...]] = []
        linear = all([*side] in ([], [1]) for side in found[each.name])
        for terms, side in zip(sides, found[each.name], strict=True):
            powers.append(tuple((len(terms) + nth, power) for nth, power in enumerate(side)))
            terms.update(
                {each.name if linear else f"{each.name}^{power}": term for power, term in side.items()}
            )
        value = base.values.get(each.place, each.value)
        elements = np.array(each.elements, dtype=np.intp)
        groups.append(TermGroup(each.name, each.quantity, value, powers[0], powers[1], elements))
    k, m = base.both
    more: dict[str, Any] = {"dofs": base.names or None, "groups": groups, "mesh": base.mesh}
    if base.constraints:
        more["constraints"] = list(map(dict, base.constraints))
    return MatrixModel(k, m, stiffness_terms=sides[0], mass_terms=sides[1], **more)

"""Finite-element programs that are run: what a group is to each, and the matrices that it writes."""

from __future__ import annotations

import inspect
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from ..exceptions import MissingDependencyError, UnsuitableDataError, reject
from ..models.constraints import eliminate_constraints
from ..models.matrices import Entries
from ..models.term_groups import Mesh
from ..support.checks import choice, finite_scalar, integer
from ..support.directions import names_of
from ..support.messages import some
from . import _opensees, calculix
from .common import existing_file
from .matrix_files import FORMATS, OF_BOTH, choose, in_rows_of, matrices_in
from .own_format import read_archive

LINEAR = ("youngs_modulus", "density")  # quantities of which matrices are straight lines
Factors = Mapping[str, float]  # on the values of groups, by name


@dataclass(frozen=True)
class Asked:
    """A group: what of it is scaled, in which elements or at which place of the input, from which value."""

    name: str
    quantity: str
    elements: tuple[int, ...] = ()
    place: str = ""
    value: float | None = None

    def rounds(self) -> tuple[tuple[float, ...], ...]:
        """Factors of the runs; a second round is for what the first shows to be no straight line."""
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

    @classmethod
    def of(cls, stiffness: Any, mass: Any, names: Sequence[Any] = (), mesh: Mesh | None = None) -> Run:
        """Of matrices, dense or sparse."""
        from scipy.sparse import coo_array

        k, m = coo_array(stiffness), coo_array(mass)
        both, n = (Entries.of_sparse(k), Entries.of_sparse(m)), int(k.shape[0])
        return cls(*both, names_of("dofs", names or None, n), n, mesh=mesh)

    def both(self, n: int) -> tuple[Any, Any]:
        """Stiffness and mass as sparse arrays (n, n)."""
        return self.stiffness.sparse(n), self.mass.sparse(n)


class Code:
    """A program with the model that it runs; each kind is a class below."""

    name = ""
    rounding = 1e-15  # of the numbers that it writes
    tolerance = 1e-9  # of the last run against the terms, where all are straight lines
    keeps = True  # whether its text says all that a run depends on

    def __init__(self, source: Any, command: str | None, usual: Sequence[str] = ()) -> None:
        self.source = source
        self._words = shlex.split(command, posix=os.name == "posix") if command else list(usual)
        self.asked: list[Asked] = []
        self._lock, self._running, self._stopped = threading.Lock(), set[subprocess.Popen[bytes]](), False

    def ask(self, groups: Any) -> Iterator[Asked]:
        """The groups that a caller names."""
        raise NotImplementedError

    def text(self, factors: Factors) -> str:
        """The input, and all else that a run depends on."""
        raise NotImplementedError

    def run(self, folder: Path, factors: Factors) -> Run:
        """Run it in a folder."""
        raise NotImplementedError

    def input(self, factors: Factors, file: Path) -> str:
        """The input with other values, for the user to keep as ``file``."""
        reject("source", self.name, "a file that can be written again", "Call it with the values.")

    def written(self, name: str, factor: float) -> float:
        """The factor that a run has, where the input has few digits."""
        return factor

    def refuse(self, problem: str) -> NoReturn:
        """Raise for a run that failed."""
        remedy = f"Let {self.name} run on it without us; if that works, report this."
        raise UnsuitableDataError("source", f"{str(self.source)!r}: {problem}", "a model that runs", remedy)

    def execute(self, folder: Path, words: Sequence[str], install: str, stem: str = "model") -> str:
        """What a program says; with one thread, which makes its sums always the same."""
        marks = {"{stem}": stem, "{input}": f"{stem}{Path(str(self.source)).suffix}"}
        words = [re.sub(r"\{stem\}|\{input\}", lambda found: marks[found[0]], word) for word in words]
        threads = ("OMP_NUM_THREADS", "CCX_NPROC_STIFFNESS", "CCX_NPROC_RESULTS", "OPENBLAS_NUM_THREADS")
        log = folder / "antires.log"
        how: dict[str, Any] = {"cwd": folder, "stdin": subprocess.DEVNULL, "stderr": subprocess.STDOUT}
        how |= {"env": os.environ | dict.fromkeys(threads, "1"), "start_new_session": True}
        try:
            with self._lock, open(log, "wb") as opened:
                if self._stopped:
                    raise KeyboardInterrupt
                process = subprocess.Popen(words, stdout=opened, **how)
                self._running.add(process)
        except FileNotFoundError:
            text = f"{self.name} is run as {words[0]!r}, which is not there. {install}"
            raise MissingDependencyError(text) from None
        process.wait()
        self._running.discard(process)
        return log.read_text(encoding="utf-8", errors="replace")

    def stop(self) -> None:
        """End what runs; nothing begins any more."""
        with self._lock:
            self._stopped = True
            for process in self._running:
                with suppress(OSError):  # and what it has begun itself, as scripts around a code do
                    os.killpg(process.pid, signal.SIGKILL) if os.name == "posix" else process.kill()


def _by_name(groups: Any) -> dict[str, Any]:
    """What each group is, by its name."""
    wanted = "the name of a group, a list of such, or a mapping of names to what they are"
    groups = [groups] if isinstance(groups, str) else groups
    if not isinstance(groups, Mapping):
        if not isinstance(groups, Sequence) or not all(isinstance(each, str) for each in groups):
            reject("groups", groups, wanted, 'As in groups=["web", "skin:thickness"].')
        groups = {each: each for each in groups}
    if not groups:
        reject("groups", "none", wanted, 'As in groups="elset": a group for each set that a section has.')
    return {str(name): target for name, target in groups.items()}


def _tags(name: str, given: Any) -> tuple[int, ...]:
    if isinstance(given, str) or not isinstance(given, Sequence | np.ndarray) or not len(given):
        reject(("groups", name), given, "numbers of elements", 'As in groups={"columns": [1, 2, 3]}.')
    return tuple(integer(("groups", name), each, low=0) for each in given)


class CalculiX(Code):
    """An input file; groups are element sets or materials, and modulus, density or thickness of them."""

    name = "CalculiX"
    rounding = 1e-13
    _QUANTITIES = ("youngs_modulus", "density", "thickness")

    def __init__(self, source: Any, command: str | None) -> None:
        super().__init__(source, command, (_ccx(), "-i", "{stem}"))
        self._deck = calculix.Deck(existing_file(source))
        self._mesh = self._deck.mesh()

    def ask(self, groups: Any) -> Iterator[Asked]:
        """``"elset"``, ``"material"``, ``"NAME"``, ``"NAME:density"``, or numbers of elements."""
        if isinstance(groups, str) and groups in ("elset", "material"):
            groups = self._deck.names(groups)
        for name, target in _by_name(groups).items():
            quantity = "youngs_modulus"
            if isinstance(target, str):
                target, _, stated = target.partition(":")
                quantity = choice("groups", stated or quantity, self._QUANTITIES)
                target = list(dict.fromkeys(self._deck.elements_of(target)))
            elements = _tags(name, target)
            unknown = [each for each in elements if each not in self._deck.section_of]
            if unknown:
                remedy = "Springs, masses and the like cannot be in a group yet."
                reject(("groups", name), f"element {unknown[0]}", "elements that have a section", remedy)
            yield Asked(name, quantity, elements, value=self._deck.value(quantity, list(elements)))

    def _groups(self) -> calculix.Groups:
        return {each.name: (each.quantity, list(each.elements)) for each in self.asked}

    def text(self, factors: Factors) -> str:
        """The input file of the run."""
        return f"** {self._words}\n{self._deck.text(self._groups(), factors)}"

    def input(self, factors: Factors, file: Path) -> str:
        """With its own steps, and what it includes in it."""
        for each in self.asked:
            there = self._deck.value(each.quantity, list(each.elements))
            if there != each.value:
                got, wanted = f"{there} for {each.name!r}", f"{each.value}, as the model was read"
                reject("source", got, wanted, "Name the input that read_model had.")
        kept = {name: group for name, group in self._groups().items() if factors[name] != 1.0}
        return "".join(["** Values of groups by antires_rs\n", *self._deck.scaled(kept, factors)])

    def run(self, folder: Path, factors: Factors) -> Run:
        """The matrices that it stores."""
        (folder / "model.inp").write_text(self.text(factors))
        install = 'Install CalculiX ("apt install calculix-ccx", or calculix.de), or name it by command=.'
        said = self.execute(folder, self._words, install)
        try:
            nodes = frozenset(self._mesh.nodes.tolist())
            return Run.of(*calculix.stored(folder, "model", nodes), self._mesh)
        except (OSError, ValueError):
            self.refuse(f"CalculiX says {calculix.errors_in(said)!r}")


def _ccx() -> str:
    """CalculiX on PATH: ``ccx``, or with its version behind."""
    versions = (file for folder in os.get_exec_path() for file in sorted(Path(folder).glob("ccx_[0-9]*")))
    return shutil.which("ccx") or str(next(versions, "ccx"))


class OpenSees(Code):
    """A script of OpenSeesPy; groups are elements, or arguments of a function in it that builds the model."""

    name = "OpenSeesPy"

    def __init__(self, source: Any, command: str | None) -> None:
        super().__init__(source, command, (sys.executable,))
        script, _, function = str(source).rpartition(".py")
        self._script, self._function = existing_file(f"{script}.py").resolve(), function.lstrip(":") or None

    def ask(self, groups: Any) -> Iterator[Asked]:
        """Numbers of elements, or the name of an argument."""
        for name, target in _by_name(groups).items():
            if not isinstance(target, str):
                yield Asked(name, "stiffness", _tags(name, target))
                continue
            if self._function is None:
                got, wanted = f"{target!r}, an argument", "numbers of elements, or a function that has it"
                reject(("groups", name), got, wanted, f'Name the function: "{self._script.name}:build".')
            yield Asked(name, "value", place=target)

    def _request(self, factors: Factors) -> str:
        of = {each.name: each for each in self.asked}
        removed = sorted(tag for name in factors for tag in of[name].elements)
        values = {of[name].place: factor for name, factor in factors.items() if not of[name].elements}
        asked = {"script": str(self._script), "function": self._function, "factors": values}
        return json.dumps(asked | {"removed": removed})

    def text(self, factors: Factors) -> str:
        """What is asked of the script, itself, and those beside it, which it may import."""
        beside = sorted(self._script.parent.glob("*.py"))
        texts = (file.read_text(errors="replace") for file in beside)
        return "\n".join([self._request(factors), *self._words, *texts])

    def input(self, factors: Factors, file: Path) -> str:
        """A script with the same function, whose arguments have other defaults."""
        moved = [each for each in self.asked if factors[each.name] != 1.0]
        fixed = [each.name for each in moved if each.value is None or not each.place]
        if fixed or self._function is None:
            got = f"elements of {fixed[0]!r}" if fixed else "no function"
            wanted = "arguments of a function, which have values"
            remedy = 'Read the model as "frame.py:build", with groups that are arguments.'
            reject("source", got, wanted, remedy)
        values = {each.place: (each.value or 0.0) * factors[each.name] for each in moved}
        folder = os.path.relpath(self._script.parent, file.resolve().parent)
        return _SCRIPT.format(script=self._script.name, name=self._function, folder=folder, values=values)

    def run(self, folder: Path, factors: Factors) -> Run:
        """The matrices of the model that the script builds."""
        out, install = folder / "model.npz", "Name the Python that has OpenSeesPy by command=."
        program = [*self._words, "-P", _opensees.__file__, self._request(factors), str(out)]
        said = self.execute(folder, program, install)
        if out.is_file():
            return self._read(out)
        last = next((line for line in reversed(said.splitlines()) if ": " in line), said[-300:])[:300]
        if "No module named 'openseespy" in last:
            text = f'OpenSeesPy is not there. Install it ("pip install openseespy"). {install}'
            raise MissingDependencyError(text)
        if last.startswith("Unfit: "):
            reject("groups", last[7:], "elements and arguments that are there", "Correct the groups.")
        self.refuse(f"it ended with {last!r}")

    def _read(self, out: Path) -> Run:
        a = read_archive(out)
        about, n = json.loads(bytes(a["text"])), len(a["points"])
        parts = ([a[f"{side}.{part}"] for part in ("rows", "columns", "values")] for side in _opensees.SIDES)
        k, m = (Entries.joined(*each) for each in parts)
        ties: dict[int, list[tuple[int, float]]] = {}
        for row, dof, value in a["ties"].tolist():
            ties.setdefault(int(row), []).append((int(dof), value))
        if "reduced.mass" in a:  # as OpenSees itself takes constraints out
            kept = a["retained"].tolist()
            made = eliminate_constraints(k.sparse(n), m.sparse(n), [*map(dict, ties.values())], keep=kept)
            for side in _opensees.SIDES:
                own, theirs = np.sort(getattr(made, side).diagonal()), a[f"reduced.{side}"]
                if own.shape != theirs.shape or np.abs(own - theirs).max() > 1e-9 * np.abs(theirs).max():
                    self.refuse("its constraints are not those of equalDOF, rigidLink and rigidDiaphragm")
        names = [(node, code) if code else f"{node} dof {nth}" for node, code, nth in a["points"].tolist()]
        kinds = tuple(about["kinds"])
        mesh = Mesh(a["nodes"], a["coordinates"], a["elements"], a["connectivity"], kinds, a["kind"])
        equations = tuple(map(tuple, ties.values()))
        return Run(k, m, names_of("dofs", names, n), n, equations, mesh, about["defaults"])


_SCRIPT = """\
# {script} with other values, by antires_rs.
import sys
from functools import partial
from pathlib import Path
from runpy import run_path

folder = Path(__file__).resolve().parent / {folder!r}
sys.path.insert(0, str(folder))
# Run by its path: this file may have the same name.
{name} = partial(run_path(str(folder / {script!r}))[{name!r}], **{values!r})

if __name__ == "__main__":
    {name}()
"""


class Template(Code):
    """Any code: an input with ``{name}`` where a value stands, and a command that writes matrices."""

    name = "the command"
    tolerance = 1e-6  # punch files have seven digits

    def __init__(self, source: Any, command: str | None) -> None:
        super().__init__(source, command)
        self._file = existing_file(source)
        self._text = self._file.read_text(encoding="utf-8", errors="replace")

    def ask(self, groups: Any) -> Iterator[Asked]:
        """The number that stands in place of ``{name}``."""
        for name, value in _by_name(groups).items():
            if not self._places(name).search(self._text):
                got = f"{str(self._file)!r} without {{{name}}}"
                wanted = "an input with it in place of the number"
                remedy = f"Write {{{name}}}, or {{{name}:.6e}} for a field of few columns."
                reject(("groups", name), got, wanted, remedy)
            yield Asked(name, "value", value=finite_scalar(("groups", name), value))

    @staticmethod
    def _places(name: str) -> re.Pattern[str]:
        return re.compile(rf"\{{{re.escape(name)}(?::([^{{}}]*))?\}}")

    def _filled(self, name: str, factor: float, place: re.Match[str]) -> str:
        value = factor * next(each.value or 0.0 for each in self.asked if each.name == name)
        return format(value, place[1]) if place[1] else repr(value)

    def written(self, name: str, factor: float) -> float:
        """Of the first place where it stands."""
        place = next(self._places(name).finditer(self._text))
        return float(self._filled(name, factor, place)) / float(self._filled(name, 1.0, place))

    def input(self, factors: Factors, file: Path) -> str:
        """With numbers in all places."""
        text = self._text
        for name in (each.name for each in self.asked):
            text = self._places(name).sub(partial(self._filled, name, factors.get(name, 1.0)), text)
        return text.replace("{folder}", str(self._file.resolve().parent))

    def text(self, factors: Factors) -> str:
        """The input file of the run, and the command."""
        return f"{self._words}\n{self.input(factors, self._file)}"

    def run(self, folder: Path, factors: Factors) -> Run:
        """The matrices that it leaves in the folder."""
        (folder / self._file.name).write_text(self.input(factors, self._file))
        install = 'Correct command=, as in "nastran {input} batch=no".'
        said = self.execute(folder, self._words, install, self._file.stem)
        left = sorted(each for each in folder.iterdir() if each.name not in (self._file.name, "antires.log"))
        files = [each for each in left if each.name.lower().endswith(tuple(FORMATS))]
        both = (each for each in files if each.name.lower().endswith(OF_BOTH))
        one = next((each for each in both if len(matrices_in("source", each)) > 1), None)
        pair = [one or next((f for f in files if side.search(f.name)), None) for side in _NAMES_OF_SIDES]
        if pair[0] is None or pair[1] is None:
            listed = some((each.name for each in left), 8) or "no file"
            self.refuse(f"the command left {listed}, no stiffness and mass, and said {said[-200:].strip()!r}")
        k, m = choose("source", pair[0], "K"), choose("source", pair[1], "M")
        return Run.of(k.matrix, in_rows_of("source", m, k), k.points or ())


#: Files of stiffness and of mass by their names: ``job_STIF1.mtx``, ``K.op4``.
_NAMES_OF_SIDES = [
    re.compile(rf"{word}|(?:^|[_.-]){word[0]}\d*[_.-]", re.I) for word in ("k_?matrix|stif", "mass")
]


class Hook(Code):
    """A function of Python that returns stiffness and mass, and names of the dofs if it has them."""

    name = "the function"
    keeps = False

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
        """What is asked of it."""
        return str(dict(factors))

    def run(self, folder: Path, factors: Factors) -> Run:
        """What it returns."""
        values = {e.place: (e.value or 0.0) * factors[e.name] for e in self.asked if e.name in factors}
        found = self.source(**values)
        if not isinstance(found, list | tuple) or len(found) not in (2, 3):
            wanted = "K, M and, if they have some, the names of the dofs"
            reject("source", f"{type(found).__name__} from the function", wanted, "As in return K, M, names.")
        if np.shape(found[0]) != np.shape(found[1]):
            got = f"K {np.shape(found[0])} and M {np.shape(found[1])} from the function"
            reject("source", got, "two matrices of one size", "Return K and M of the same dofs.")
        return Run.of(found[0], found[1], found[2] if len(found) > 2 else ())


_CODES: dict[str, Callable[[Any, str | None], Code]]
_CODES = {"calculix": CalculiX, "opensees": OpenSees, "command": Template, "python": Hook}


def code_name(source: Any, code: str | None, command: str | None) -> str:
    """Which code is meant: as stated, or as source and command tell."""
    if code is None:
        name, own = str(source).lower(), command is None or "ccx" in command
        known = {"python": callable(source), "opensees": name.endswith(".py") or ".py:" in name}
        known |= {"calculix": name.endswith(".inp") and own, "command": command is not None}
        code = next((each for each, fits in known.items() if fits), None)
        if code is None:
            wanted = "a .inp of CalculiX, a .py of OpenSeesPy, a function, or any input with command="
            reject("source", str(source), wanted, "Say code= where the ending does not tell.")
    choice("code", code, tuple(_CODES))
    if code == "command" and not command:
        reject("command", None, "how the code is run", 'As in command="nastran {input} batch=no".')
    if callable(source) != (code == "python"):
        reject("source", str(source), f"what code={code!r} takes", "A function for 'python', else a file.")
    return code


def opened(source: Any, code: str | None, command: str | None, groups: Any = None) -> Code:
    """The code with its model, and the groups that are asked for; they share no elements."""
    found = _CODES[code_name(source, code, command)](source, command)
    if groups is None:
        return found
    found.asked = list(found.ask(groups))
    for nth, one in enumerate(found.asked):
        for other in found.asked[:nth]:
            common = {*one.elements} & {*other.elements}
            if common and {one.quantity, other.quantity} != {*LINEAR}:  # values multiply in the others
                names = f"{other.name!r} and {one.name!r}"
                got = f"{names}, which share {len(common)} element(s), as {min(common)}"
                reject("groups", got, "groups of different elements", "Leave one out, or take them apart.")
    return found

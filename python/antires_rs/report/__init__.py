"""Reports: one self-contained HTML file for a result (``pip install "antires-rs[report]"``).

Style and pictures are inside the file and nothing is fetched when it is opened, so it can be mailed, archived
and printed.
"""

from __future__ import annotations

import os
from base64 import b64encode
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from importlib.resources import files
from pathlib import Path
from platform import python_version
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core import __version__
from .._files import write_atomically
from .._validation import reject
from ..exceptions import MissingDependencyError
from ..plotting import plot_convergence, plot_damage, plot_differences, plot_transmissibility
from ..plotting.canvas import picture
from ..results import DamageResult, UpdateResult
from ..tables import ModalTable

if TYPE_CHECKING:
    from ..signals import FrequencyResponse
    from ..stabilization_diagram import StabilizationDiagram

__all__ = ["write_report"]


def write_report(result: UpdateResult, path: str | os.PathLike[str], *, title: str | None = None,
                 diagrams: Mapping[Any, StabilizationDiagram] | None = None,
                 response: FrequencyResponse | None = None, truth: Mapping[int, float] | None = None,
                 origin: Mapping[str, str | Sequence[str]] | None = None) -> Path:
    """Write a result with its tables, pictures and caveats into one HTML file.

    Parameters
    ----------
    result : UpdateResult or DamageResult
    path : path-like
        Replaced if it exists, in one step: a reader never sees half a report.
    title : str, optional
        Heading; what was done by default.
    diagrams : mapping of dof to StabilizationDiagram, optional
        Evidence of the identification, by response dof or by any name. Default: those that the measured sets
        carry.
    response : FrequencyResponse, optional
        Measured transmissibilities, drawn beside the model's before and after. With several positions of the
        force they belong to the first. Not with modes, which do not tell where the force was.
    truth : mapping of int to float, optional
        True stiffness loss by element, for a virtual test; shown beside what was found.
    origin : mapping of str to str or sequence of str, optional
        What repeats the run, such as its command and the checksums of its files; shown beside the seed.

    Returns
    -------
    pathlib.Path
        The file written.

    Raises
    ------
    InvalidInputError
        The folder does not exist, or something that is not a result.
    MissingDependencyError
        jinja2 or matplotlib is not installed.

    Examples
    --------
    >>> import tempfile, antires_rs as ar
    >>> chain = ar.MassSpringChain([1.0, 1.0, 1.0], [500.0, 500.0])
    >>> problem = ar.UpdatingProblem(chain, ar.stiffness_factor([0, 1], bounds=(0.8, 1.2)),
    ...                              ar.AntiresonanceSet(0, {0: [2.1, 5.6], 1: [3.5]}))
    >>> result = ar.update(problem, rng=0)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     result.report(folder + "/run.html")
    """
    if not isinstance(result, UpdateResult):
        reject("result", type(result).__name__, "an UpdateResult or a DamageResult")
    try:
        import matplotlib  # noqa: F401 - only asked whether it is there
        from jinja2 import Environment, StrictUndefined
    except ImportError as exc:
        raise MissingDependencyError('reports need jinja2 and matplotlib; install them with: '
                                     'pip install "antires-rs[report]"') from exc
    if not Path(path).parent.is_dir():  # known before any picture is drawn
        reject("path", str(path), "a file in a folder that exists")
    damage = result if isinstance(result, DamageResult) else None
    modal = result.problem.objective == "modal"
    if modal and response is not None:
        reject("response", "transmissibilities with measured modes", "None",
               "A ModalSet does not tell where the force was, which the model's transmissibilities need.")
    if diagrams is not None:
        shown = list(diagrams.items())
    elif modal:
        shown = [(None, each.diagram) for each in result.problem.measured if each.diagram is not None]
    else:
        shown = [(dof, d) for each in result.problem.measured for dof, d in each.diagrams.items()]
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True,
                              lstrip_blocks=True)
    template = files(__package__).joinpath("template.html").read_text(encoding="utf-8")
    html = environment.from_string(template).render(
        title=title or ("Damage assessment" if damage else "Model updating")
        + (" with resonances and mode shapes" if modal else " with antiresonances"),
        answer=_answer_damage(damage) if damage else _answer_update(result),
        result=result, damage=damage is not None,
        modal=modal, measured=_measured(result),
        largest=[_largest(result.table.largest_before_percent), _largest(result.table.largest_after_percent)],
        parameters=_damage_rows(damage, truth) if damage else _parameter_rows(result),
        known=truth is not None, rows=_frequency_rows(result), figures=_figures(result, response, truth),
        diagrams=[(dof, _data_uri(picture(lambda ax, d=d: d.plot(ax=ax), (9.0, 5.0), dpi=110)))
                  for dof, d in shown],
        origin={name: [lines] if isinstance(lines, str) else list(lines)
                for name, lines in (origin or {}).items()},
        islands=result.history.cost.shape[1], versions=_versions(),
        date=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"))
    return write_atomically(path, html.encode("utf-8"))


def _answer_damage(result: DamageResult) -> str:
    """The first thing to know."""
    label = result.problem.model.element_label
    found = [f"{label(e)} has lost {100 * result.severity[e]:.1f} % of its stiffness" for e in result.damaged]
    return f"{'; '.join(found)}.".capitalize() if found else "No damage found."


def _answer_update(result: UpdateResult) -> str:
    what = "resonance" if result.problem.objective == "modal" else "antiresonance"
    return (f"Largest {what} difference: {_largest(result.table.largest_before_percent)} before, "
            f"{_largest(result.table.largest_after_percent)} after.")


def _measured(result: UpdateResult) -> str:
    """What was measured, and where."""
    sets, count = result.problem.measured, result.problem.measured_hz.size
    if result.problem.objective == "modal":
        dofs = ", ".join(f"{len(each.dofs)} dofs" for each in sets)
        return f"{count} measured resonances with shapes at {dofs}"
    forces = ", ".join(str(each.excitation) for each in sets)
    return f"{count} measured antiresonances, force at dof {forces}"


def _largest(percent: float) -> str:
    return f"{percent:.2f} %" if np.isfinite(percent) else "no partner at all"


def _parameter_rows(result: UpdateResult) -> list[dict[str, Any]]:
    on_bound = set(result.at_bound)
    return [{"name": name, "value": f"{value:.4f}", "change": f"{100 * (value - nominal):+.2f}",
             "bounds": f"{low:g} to {high:g}", "on_bound": name in on_bound}
            for name, value, nominal, (low, high) in zip(
                result.problem.names, result.x, result.problem.nominal, result.problem.bounds, strict=True)]


def _damage_rows(result: DamageResult, truth: Mapping[int, float] | None) -> list[dict[str, Any]]:
    def percent(value: float | None) -> str:
        if value is None:
            return ""
        return "none" if not np.isfinite(value) else "0" if value == 0.0 else f"{100 * value:.1f}"
    label = result.problem.model.element_label
    return [{"name": label(e), "value": percent(result.severity[e]), "visible": percent(result.detectable[e]),
             "truth": percent((truth or {}).get(e)), "bounds": f"{100 * low:g} to {100 * high:g}",
             "damaged": result.severity[e] > 0.0}
            for e, (low, high) in zip(result.elements, result.problem.bounds, strict=True)]


def _frequency_rows(result: UpdateResult) -> list[dict[str, Any]]:
    table = result.table

    def number(value: float, form: str) -> str:
        return format(value, form) if np.isfinite(value) else "no partner"
    rows: list[dict[str, Any]] = [
        {"group": False, "measured": f"{measured:.3f}", "before": number(before, ".3f"),
         "before_percent": number(db, "+.2f"), "after": number(after, ".3f"),
         "after_percent": number(da, "+.2f")}
        for measured, before, db, after, da in zip(
            table.measured_hz, table.before_hz, table.before_percent, table.after_hz, table.after_percent,
            strict=True)]
    if isinstance(table, ModalTable):
        columns = zip(table.mode, table.before_mac, table.after_mac, strict=True)
        for row, (mode, before, after) in zip(rows, columns, strict=True):
            row.update(mode=mode, group=mode == table.mode[0], before_mac=number(before, ".3f"),
                       after_mac=number(after, ".3f"))
        return rows
    last = None
    for row, dof, force in zip(rows, table.dof, table.excitation, strict=True):
        row.update(group=(dof, force) != last, dof=dof, force=force)
        last = (dof, force)
    return rows


def _figures(result: UpdateResult, response: FrequencyResponse | None,
             truth: Mapping[int, float] | None) -> list[tuple[str, str]]:
    """Caption and data URI of each picture, the most telling first."""
    problem = result.problem
    figures = []
    if isinstance(result, DamageResult):
        width = max(7.0, 0.32 * len(result.x) + 1.5)
        figures.append(("Stiffness loss by element, and the smallest that would have been seen.",
                        picture(lambda ax: plot_damage(result, ax=ax, truth=truth), (width, 4.4))))
    names = (("without damage", "with the damage found") if isinstance(result, DamageResult)
             else ("before updating", "after updating"))
    what = "resonance" if problem.objective == "modal" else "antiresonance"
    figures.append((f"Difference of each {what} to the measured one, {names[0]} and {names[1]}.",
                    picture(lambda ax: plot_differences(result.table, ax=ax, names=names), (9.5, 4.6))))
    if response is not None:
        figures.append((f"Transmissibilities over dof {response.reference}, summed; the peaks are the "
                        "antiresonances of that dof. Their height in the models follows from an assumed "
                        "damping of 1 %.",
                        picture(lambda ax: plot_transmissibility(
                            response, problem.model, result.model, dof=None,
                            excitation=problem.measured[0].excitation, ax=ax, names=names), (9.0, 4.4))))
    figures.append(("The search: best objective of each island.",
                    picture(lambda ax: plot_convergence(result, ax=ax), (9.0, 4.2))))
    return [(caption, _data_uri(png)) for caption, png in figures]


def _data_uri(png: bytes) -> str:
    return "data:image/png;base64," + b64encode(png).decode("ascii")


def _versions() -> dict[str, str]:
    import scipy
    return {"antires_rs": __version__, "numpy": np.__version__, "scipy": scipy.__version__,
            "python": python_version()}

"""Reports: one self-contained HTML file, which fetches nothing, for a result or for a watch."""

from __future__ import annotations

import base64
import os
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from .._core import __version__
from ..damage.assess import DamageResult
from ..exceptions import reject
from ..identification.stabilization import StabilizationDiagram
from ..io.archive import versions
from ..io.common import require
from ..measured.modal_set import ModalSet
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.files import write_atomically
from ..updating.result import UpdateResult
from ..watch.monitor import Watched, alarm_lines, fault_lines, rate_lines
from . import report_parts as parts
from .canvas import picture
from .packing import asset, library, packed, policy, script
from .report_parts import Drawings, Facts
from .responses import dof_name
from .sets import draw_monitor, panels, size_in, watched_figure

Measurement = Recording | FrequencyResponse | Mapping[str, str | Sequence[str]]  # what describes a set
_DESCRIBING = (Recording, FrequencyResponse, Mapping)


def write_report(
    result: UpdateResult,
    path: str | os.PathLike[str],
    *,
    title: str | None = None,
    measurement: Measurement | Sequence[Measurement] | None = None,
    diagrams: Mapping[Any, StabilizationDiagram] | None = None,
    response: FrequencyResponse | None = None,
    truth: Mapping[int, float] | None = None,
    origin: Mapping[str, str | Sequence[str]] | None = None,
    warnings: Sequence[str] | None = None,
    baseline: Sequence[Mapping[str, str | Sequence[str]]] | None = None,
    modes: ModalSet | Sequence[ModalSet] | None = None,
    drawn: Drawings | None = None,
) -> Path:
    """Write a result with its tables, pictures and caveats into one HTML file below 3 MB.

    ``modes`` are measured ones that were not fitted, to be compared beside the antiresonances.

    The file asks nothing of any network. Where bokeh is installed (``pip install "antires-rs[look]"``), its
    figures can be zoomed, hovered and their lines switched off; printed, without scripts, or without bokeh
    pictures stand there. Where all stabilization diagrams together would make it larger, the last are left
    out, and it says how many.
    """
    if not isinstance(result, UpdateResult):
        remedy = "Pass what update or assess_damage returned."
        reject("result", type(result).__name__, "an UpdateResult or a DamageResult", remedy)
    for package in ("matplotlib", "jinja2"):
        require("a report", package, "report")
    from jinja2 import Environment, StrictUndefined

    damage = isinstance(result, DamageResult)
    problem = result.problem
    modal = problem.objective == "modal"
    if modal and response is not None:
        remedy = "A ModalSet does not tell where the force was, which the model's transmissibilities need."
        reject("response", "transmissibilities with measured modes", "None", remedy)
    measured = _measured(result, measurement)
    values = "resonances and mode shapes" if modal else "antiresonances"
    if drawn is None:
        beside = None if modes is None else result.modes_beside(modes)
        drawn = parts.drawings_of(result, response, truth, diagrams, beside)
    shown, left_out = parts.fitting(drawn)
    if warnings is None:
        checks = [getattr(each, "data_check", None) for each in problem.measured]
        warnings = [line for check in checks if check is not None for line in check.warnings]
    made = ", ".join(f"{name} {version}" for name, version in versions().items())
    when = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    template = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    html = template.from_string(asset("report.html")).render(
        title=title or f"{'Damage assessment' if damage else 'Model updating'} with {values}",
        answer=parts.answer_of(result),
        lead=_lead(result),
        warnings=list(warnings),
        result=result,
        tables=parts.tables_of(result, truth, drawn.beside),
        modal=modal,
        measured=measured,
        intact=[_lines(each) for each in baseline or ()],
        figures=drawn.figures,
        diagrams=shown,
        left_out=left_out,
        model=parts.of_model(problem.model),
        run=parts.of_search(result) | _lines(origin or {}) | {"Report made with": [made, when]},
        library=library(),
        script=script() if library() or any(each.scene for each in drawn.figures.values()) else "",
        policy=policy(),
    )
    return write_atomically(path, html.encode("utf-8"))


def _lead(result: UpdateResult) -> str:
    """What was measured, what was unknown, and for damage what was reached."""
    problem = result.problem
    sets, count = problem.measured, problem.measured_hz.size
    if problem.objective == "modal":
        what, dofs = "resonance", ", ".join(f"{len(each.dofs)} dofs" for each in sets)
        given = f"{count} measured resonances with shapes at {dofs}"
    else:
        what, names = "antiresonance", [dof_name(problem.model, each.excitation) for each in sets]
        kind = "".join(names[0].partition(" ")[:2]) if " " in names[0] else ""  # "dof" or "node", once
        forces = ", ".join(name.removeprefix(kind) for name in names)
        given = f"{count} measured antiresonances, force at {kind}{forces}"
    if not isinstance(result, DamageResult):
        return f"{given}; {len(result.x)} parameters."
    if result.has_baseline:
        among = f"{len(result.x)} candidate element{'s' if len(result.x) > 1 else ''}."
        seen = [100.0 * beta for beta in result.detectable.values() if np.isfinite(beta)]
        if seen and result.assessment.n_baselines > 1:
            span = f"{min(seen):.2g} to {max(seen):.2g} %, depending on the element."
            among += f" Smallest loss that nine of ten such tests would show: {span}"
        return f"{given}, compared with those of the intact structure; {among}"
    before, after = parts.largest(result.table)
    change = f"Largest {what} difference {before} without damage, {after} with the damage found."
    return f"{given}; {len(result.x)} candidate elements. {change}"


def _measured(result: UpdateResult, measurement: Any) -> list[Facts]:
    """Facts about each measured set; what was given leads."""
    sets = result.problem.measured
    if isinstance(measurement, _DESCRIBING):
        measurement = [measurement]
    given = list(measurement or [None] * len(sets))
    if len(given) != len(sets) or not all(isinstance(one, (*_DESCRIBING, type(None))) for one in given):
        wanted = f"{len(sets)}, a Recording, a FrequencyResponse or facts by name for each measured set"
        reject("measurement", given, wanted, "Pass None where there is none.")
    facts: list[Facts] = []
    for one, found in zip(given, sets, strict=True):
        own = _lines(one or {}) if one is None or isinstance(one, Mapping) else parts.of_signal(one)
        facts.append(own | parts.of_set(found, result.problem.model))
    return facts


def _lines(facts: Mapping[str, str | Sequence[str]]) -> Facts:
    return {name: [value] if isinstance(value, str) else list(value) for name, value in facts.items()}


# -- The page of a watch: what it found, its charts, its alarms; small enough to be written after every test


def write_monitor_report(watched: Watched, path: str | os.PathLike[str]) -> None:
    """Write the page, whole or not at all."""
    count, size = len(panels(watched)), size_in(watched)
    drawn = picture(lambda axes: draw_monitor(np.atleast_1d(axes), watched), size, rows=count, dpi=130)
    image = base64.b64encode(drawn).decode()
    rest = watched.outside_baseline
    count, alarms = int(rest.sum()), int(watched.alarm[rest].sum())
    state = "no test"
    for now in np.flatnonzero(~np.isnan(watched.statistic))[-1:]:
        state = f"test {watched.names[now]}, the latest: {'ALARM' if watched.alarm[now] else 'no alarm'}"
    notes = [*rate_lines(watched), *fault_lines(watched)]
    if watched.failed:
        notes.append(f"failed, not judged: {len(watched.failed)} tests")
    # The style of the other reports; the charts are explored where bokeh is installed.
    style = asset("report.html").split("<style>")[1].split("</style>")[0]
    live = draw = ""
    if drawer := library():
        block_of = '<script type="text/plain" {}>{}</script>'
        block = block_of.format('class="packed"', packed(lambda: watched_figure(watched)))
        live = f'<div class="live" id="figure-charts"></div>{block}'
        draw = block_of.format('id="library"', drawer) + f"<script>{script()}</script>"
    # Indented lines belong to the one above.
    text = escape("\n".join(line.rstrip() for line in alarm_lines(watched))).replace("\n  ", "<br>")
    told = "".join(f"<p>{line}</p>" for line in text.splitlines())
    page = Template(asset("watch.html")).substitute(
        policy=policy(),
        style=style,
        alarms=f"{alarms:,}",
        count=f"{count:,}",
        lead=f"{escape(state)}. Baseline: {watched.baseline.size} tests,\n{watched.dof.size} antiresonances.",
        image=image,
        live=live,
        told=told or "<p>None.</p>",
        notes="".join(f"<li>{escape(line)}</li>" for line in notes),
        made=f"antires_rs {escape(__version__)}, {datetime.now(UTC):%Y-%m-%d %H:%M} UTC",
        draw=draw,
    )
    write_atomically(path, page.encode())

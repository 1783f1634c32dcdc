"""The page of a watch: what it found, its charts, its alarms; small enough to be written after every test."""

from __future__ import annotations

import base64
import os
from datetime import UTC, datetime
from html import escape
from importlib.resources import files
from typing import TYPE_CHECKING

import numpy as np

from .._core import __version__
from ..explore.watched import watched_figure
from ..monitoring.printed import alarm_lines, fault_lines, rate_lines
from ..plotting.canvas import picture
from ..plotting.monitor import draw_monitor, panels, size_in
from ..support.files import write_atomically
from .live import library, packed, policy, script

if TYPE_CHECKING:
    from ..monitoring.watched import Watched

__all__ = ["write_monitor_report"]

#: So many of the latest alarms are in the table.
_LATEST = 50


def write_monitor_report(watched: Watched, path: str | os.PathLike[str]) -> None:
    """Write the page, whole or not at all.

    Parameters
    ----------
    watched : Watched
    path : path-like
        Replaced if it exists.
    """
    drawn = picture(
        lambda axes: draw_monitor(np.atleast_1d(axes), watched),
        size_in(watched),
        rows=len(panels(watched)),
        dpi=130,
    )
    image = base64.b64encode(drawn).decode()
    rest = watched.outside_baseline
    count, alarms = int(rest.sum()), int(watched.alarm[rest].sum())
    last = np.flatnonzero(~np.isnan(watched.statistic))
    state = "no test"
    if last.size:
        now = int(last[-1])
        state = f"test {watched.names[now]}, the latest: {'ALARM' if watched.alarm[now] else 'no alarm'}"
    notes = [*rate_lines(watched), *fault_lines(watched)]
    if watched.failed:
        notes.append(f"failed, not judged: {len(watched.failed)} tests")
    page = f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy()}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Watch: {alarms} of {count} tests alarm</title><link rel="icon" href="data:,">
<style>{_style()}</style></head><body>
<h1>antires_rs watch</h1>
<p class="answer">{alarms:,} of {count:,} tests outside the baseline alarm</p>
<p class="lead">{escape(state)}. Baseline: {watched.baseline.size} tests,
{watched.dof.size} antiresonances.</p>
<figure><img alt="Charts of all tests over their limits, and the first condition"
src="data:image/png;base64,{image}">{_live(watched)}
<figcaption>Each chart over its limit: crosses above 1 are alarms. The baseline is shaded; its tests are
judged by the others.</figcaption></figure>
<h2>Alarms</h2>
{_paragraphs(alarm_lines(watched)) or "<p>None.</p>"}
{_table(watched)}
<h2>Rate and conditions</h2>
<ul class="notes">{"".join(f"<li>{escape(line)}</li>" for line in notes)}</ul>
<p class="lead">antires_rs {escape(__version__)}, {datetime.now(UTC):%Y-%m-%d %H:%M} UTC</p>
{_script()}</body></html>
"""
    write_atomically(path, page.encode())


def _live(watched: Watched) -> str:
    """The charts to be explored, where they can be made."""
    block = packed(lambda: watched_figure(watched))
    if not block:
        return ""
    return (
        '<div class="live" id="figure-charts"></div>'
        f'<script type="text/plain" class="packed">{block}</script>'
    )


def _script() -> str:
    """What draws them."""
    if not library():
        return ""
    return f'<script type="text/plain" id="library">{library()}</script><script>{script()}</script>'


def _style() -> str:
    """That of the other reports."""
    text = files(__package__).joinpath("template.html").read_text(encoding="utf-8")
    return text.split("<style>")[1].split("</style>")[0]


def _paragraphs(lines: list[str]) -> str:
    """Indented lines belong to the one above."""
    made: list[str] = []
    for line in lines:
        if line.startswith("  ") and made:
            made[-1] += "<br>" + escape(line.strip())
        else:
            made.append(escape(line))
    return "".join(f"<p>{line}</p>" for line in made)


def _table(watched: Watched) -> str:
    """The latest alarms outside the baseline."""
    at = np.flatnonzero(watched.alarm & watched.outside_baseline)[::-1]
    if not at.size:
        return ""
    rows = "".join(
        f"<tr><th scope='row' class='name'>{escape(watched.names[i])}</th>"
        f"<td>{watched.statistic[i]:.2f}</td><td>{escape(', '.join(watched.why(i)))}</td></tr>"
        for i in at[:_LATEST].tolist()
    )
    what = f"The latest {min(at.size, _LATEST)} of {at.size:,} alarms" if at.size > _LATEST else "All alarms"
    return (
        f"<div class='scroll'><table><caption>{what}</caption><thead><tr><th class='name'>test</th>"
        f"<th>statistic / limit</th><th>charts</th></tr></thead><tbody>{rows}</tbody></table></div>"
    )

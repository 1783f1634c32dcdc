"""A watch as text: the rate and how it was checked, alarms, damage, faults."""

from __future__ import annotations

from collections import Counter

import numpy as np

from .judged_tests import JudgedTests

__all__ = ["alarm_lines", "fault_lines", "printed", "rate_lines"]

#: So many runs and faults are listed; the others are counted.
_LISTED = 8


def printed(watched: JudgedTests) -> str:
    """The summary."""
    count = int(watched.outside_baseline.sum())
    alarms = int(watched.alarm[watched.outside_baseline].sum())
    title = (
        f"{len(watched):,} tests watched, {watched.baseline.size} of them the baseline, "
        f"by {watched.dof.size} antiresonances"
    )
    found = (
        f"{alarms} of {count:,} tests outside the baseline alarm" if count else "no test outside the baseline"
    )
    lines = [title, found, *rate_lines(watched), *alarm_lines(watched), *fault_lines(watched)]
    unjudged = int(watched.unjudged.sum())
    if unjudged:
        lines.append(f"not judged, most responses being at fault: {unjudged} tests, see .unjudged")
    if watched.failed:
        lines.append(f"failed, not judged: {len(watched.failed)} tests, see .failed")
    return "\n".join(lines)


def rate_lines(watched: JudgedTests) -> list[str]:
    """The rate, how it was checked, and what it was learned on."""
    rate, base = 100.0 * watched.false_alarm_rate, watched.baseline
    hits = int(watched.alarm[base].sum())
    lines = [
        f"false alarms: {rate:g} % of intact tests stated; {hits} of {base.size} baseline tests "
        f"({100.0 * hits / base.size:.1f} %) alarm when left out"
    ]
    if base.size < watched.needed:
        lines.append(
            f"the baseline is short for this rate: {base.size} tests, "
            f"{watched.needed} are needed to rely on it"
        )
    if watched.used:
        told = [
            name + (f" (bent at {watched.bends[name]:.3g})" if name in watched.bends else "")
            for name in watched.used
        ]
        lines.append(f"corrected for {', '.join(told)}")
        out = int(np.sum(watched.outside & watched.outside_baseline))
        if out:
            lines.append(
                f"{out:,} tests at conditions that the baseline does not have: lines go on, "
                "their uncertainty counted"
            )
    else:
        lines.append(
            "corrected for what the baseline's antiresonances do together, no condition being of use"
        )
    if watched.clocks:
        lines.append(f"not used, since it only grows or falls with the tests: {', '.join(watched.clocks)}")
    return lines


def alarm_lines(watched: JudgedTests) -> list[str]:
    """Runs of alarms outside the baseline, with their damage."""
    inside = set(watched.baseline.tolist())
    runs = [run for run in watched.runs if run[1] not in inside]
    # Those that say most first to be listed, then in order.
    longest = sorted(sorted(runs, key=lambda run: run[0] - run[1])[:_LISTED])
    lines = []
    for first, last in longest:
        hits = int(watched.alarm[first : last + 1].sum())
        why = Counter(name for i in range(first, last + 1) if watched.alarm[i] for name in watched.why(i))
        names = watched.names[first] if first == last else f"{watched.names[first]} to {watched.names[last]}"
        text = f"alarm: test {names}, " if first == last else f"alarm: tests {names}, {hits} alarms, "
        lines.append(text + ", ".join(name for name, _ in why.most_common()))
        if first in watched.assessments:
            lines.append("  " + watched.assessments[first].headline.replace("\n", "\n  "))
    if len(runs) > len(longest):
        lines.append(f"and {len(runs) - len(longest)} shorter runs of alarms, see .runs")
    return lines


def fault_lines(watched: JudgedTests) -> list[str]:
    """Responses at fault, counted."""
    told = Counter((str(f.dof), f.text) for here in watched.faults.values() for f in here)
    lines = [
        f"sensor fault: dof {dof}, {text}" + (f" ({count} tests)" if count > 1 else "")
        for (dof, text), count in told.most_common(_LISTED)
    ]
    if len(told) > _LISTED:
        lines.append(f"and {len(told) - _LISTED} other faults, see .faults")
    return lines

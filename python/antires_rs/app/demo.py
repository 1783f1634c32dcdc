"""``antires demo``: tells the story of the eight-mass chain, and draws it.

The tested structure differs from the model by up to 8 % in every mass and spring. The pipeline sees records
only: the truth is printed beside its answers, never used for them.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .. import cases
from .._core import __version__
from ..cases.chain8 import DURATION_S, FS_HZ, Chain8
from ..damage.assess import DamageResult, assess_damage
from ..exceptions import MissingDependencyError
from ..figures.canvas import picture
from ..figures.report_parts import drawings_of
from ..identification.identify import identify_antiresonances
from ..measured.antiresonance_set import AntiresonanceSet
from ..optimize.island_ga import IslandGA
from ..signals.recording import Recording
from ..signals.transfer_functions import transmissibility
from ..support.files import write_atomically
from ..updating.result import UpdateResult
from ..updating.update import update
from .command import say, show
from .run import number, write_json

PERTURBATION = 0.08
#: Budget of the updating: a flat valley (common scale, mass 0) keeps it from ending by itself. Over eight
#: seeds this one, half the default, left 0.05 to 0.42 % as the largest difference, in a second.
MAX_EVALUATIONS = 100_000
MATCH = 0.02  # a found value this close to a true one is that one
NPERSEG = 8192  # segments of the transmissibilities that are drawn, 16 s


@dataclass(frozen=True)
class Story:
    """What happened: the undamaged test first, then the damaged one, judged against it."""

    case: Chain8
    records: list[Recording]
    found: list[AntiresonanceSet]
    updated: UpdateResult
    damage: DamageResult


def tell(seed: int = 0, noise: float = 0.01, workers: int | None = None) -> Story:
    """Run the whole chain: two virtual tests, two identifications, one updating, one assessment."""
    structure, *tests, for_update, for_damage = np.random.default_rng(seed).spawn(5)
    case = cases.chain8(perturbation=PERTURBATION, rng=structure)
    records, found = [], []
    for level, rng in enumerate(tests):
        say(f"testing the {'damaged' if level else 'undamaged'} structure")
        records.append(case.experiment(level, noise=noise, rng=rng))
        found.append(identify_antiresonances(records[-1], excitation=case.excitation, band_hz=case.band_hz))
    say("updating 15 parameters of the model")
    ga = IslandGA(max_evaluations=MAX_EVALUATIONS)
    updated = update(case.updating_problem(found[0]), optimizer=ga, rng=for_update, workers=workers)
    if updated.status == "interrupted":
        raise KeyboardInterrupt  # a search returns its best so far on Ctrl-C; a demo has no use for it
    say("looking for the damage")
    damage = assess_damage(case.model, found[1], baseline=found[0], rng=for_damage, workers=workers)
    return Story(case, records, found, updated, damage)


def matches(story: Story, level: int) -> dict[str, Any]:
    """How many antiresonances of a test were found and are false, and the largest error."""
    truth, found = story.case.truth(level)["freq_hz"], story.found[level]
    errors = [np.abs(found[dof][:, None] / true_hz - 1.0) for dof, true_hz in truth.items()]
    least, best = (np.concatenate([np.min(e, axis=axis, initial=1.0) for e in errors]) for axis in (0, 1))
    near = least <= MATCH
    counts = {"true": least.size, "found": int(near.sum()), "false": int(np.sum(best > MATCH))}
    return counts | {"largest_error_percent": 100.0 * float(np.max(least[near], initial=0.0))}


def text(story: Story) -> str:
    """The story's tables."""
    said = "{found} of {true} antiresonances found, {false} false, "
    said += "largest error {largest_error_percent:.2f} %"
    before, after = (said.format(**matches(story, level)) for level in (0, 1))
    truth = story.case.truth(1)["severity"].items()
    lost = ", ".join(f"{story.case.model.element_label(e)} {100 * b:g} %" for e, b in truth if b > 0.0)
    return f"""\
An eight-mass chain, masses and springs up to {100 * PERTURBATION:g} % off the model
numbers count from 0: dof 0 is mass 0, spring 4 (the paper's fifth) joins masses 4 and 5.

1. Undamaged: antiresonances from the responses alone
{DURATION_S:g} s at {FS_HZ:g} Hz, eight accelerometers; the force at dof 0 is not used.
{before}

2. Updating: eight masses and seven springs within +-10 %
{story.updated.summary()}

3. Damaged: recorded and identified again, and compared with the undamaged test
{after}
true loss of stiffness: {lost}

{story.damage.summary()}"""


def summary(story: Story, seed: int, noise: float) -> dict[str, Any]:
    """The story's numbers, ready for JSON; null where there is none."""
    updated, damage, label = story.updated, story.damage, story.case.model.element_label
    parameters = dict(zip(updated.problem.names, updated.x.tolist(), strict=True))
    updating = {"status": updated.status, "evaluations": updated.nfev, "J": updated.fun}
    ends = ("largest_before_percent", "largest_after_percent")
    updating |= {name: number(getattr(updated.table, name)) for name in ends}
    losses = {"severity": damage.severity, "probability": damage.probability}
    losses["truth"] = story.case.truth(1)["severity"]
    return {
        "antires_rs": __version__,
        "seed": seed,
        "noise": noise,
        "identification": matches(story, 0),
        "updating": updating | {"parameters": parameters},
        "identification_damaged": matches(story, 1),
        "damage": {"headline": damage.headline, "probability_of_damage": damage.probability_of_damage}
        | {name: {label(e): number(value) for e, value in own.items()} for name, own in losses.items()},
    }


def write_files(story: Story, folder: Path) -> None:
    """``updating.html`` and ``damage.html``, and the paper's pictures as PNG."""
    from ..figures.report import write_report

    truth = story.case.truth(1)["severity"]
    intact, damaged = (found.diagrams[0] for found in story.found)
    response = transmissibility(story.records[0], 0, nperseg=NPERSEG, estimator="rank1")
    model = drawings_of(story.updated, response)
    damage = drawings_of(story.damage, None, truth, {0: damaged})
    pictures = {"stabilization": picture(lambda ax: intact.plot(ax=ax), (9.0, 5.2))}
    pictures |= {name: model.figures[name].png for name in ("response", "differences", "convergence")}
    for name, png in (pictures | {"damage": damage.figures["damage"].png}).items():
        write_atomically(folder / f"{name}.png", png)
    title = "antires demo: the updated model"
    write_report(story.updated, folder / "updating.html", title=title, drawn=model)
    title = "antires demo: the damaged spring"
    write_report(story.damage, folder / "damage.html", title=title, truth=truth, drawn=damage)


def demo(args: argparse.Namespace) -> int:
    """Tell the story, and write its files."""
    out: Path = args.out
    out.mkdir(parents=True, exist_ok=True)
    story = tell(args.seed, args.noise, args.workers)
    numbers = summary(story, args.seed, args.noise)
    write_json(out / "summary.json", numbers)
    show(args.json, numbers, text(story))
    closing = [
        f"Open {out / 'damage.html'} (where the damage is) and {out / 'updating.html'} (the model).",
        f"The pictures are beside them as PNG, all numbers in {out / 'summary.json'}.",
    ]
    try:
        say("drawing pictures and writing reports")
        write_files(story, out)
    except MissingDependencyError as exc:
        closing = [f"All numbers are in {out / 'summary.json'}. Not everything was drawn:", str(exc)]
    print("", *closing, sep="\n", file=sys.stderr if args.json else sys.stdout)
    return 0

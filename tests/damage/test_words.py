"""What an assessment says in words: is there damage, where, how sure, how much, what else it may be."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from antires_rs.damage import hypotheses as words
from antires_rs.damage.hypotheses import UNKNOWN, Assessment, Hypotheses, Hypothesis, without_idle
from antires_rs.damage.words import headline, headline_of_one_state, reservations
from antires_rs.figures.report_parts import hypothesis_rows
from tests.support.snapshots import compare


def one(elements, probability, severities=None, *, candidate=True):
    elements = (elements,) if isinstance(elements, int) else elements
    sizes = tuple(severities or (0.2,) * len(elements)) if elements != UNKNOWN else ()
    low, high = (tuple(np.round(np.array(sizes) + by, 3).tolist()) for by in (-0.01, 0.02))
    return Hypothesis(elements, probability, sizes, low, high, candidate)


def nothing(probability):
    return one((), probability)


def unknown(probability):
    return one(UNKNOWN, probability, candidate=False)


def label(element):
    return f"spring {element}"


def assessed(rows, declared=(), group=None, **fields):
    rows = sorted(rows, key=lambda row: -row.probability)
    known = {  # what is not named here says nothing of its own
        **{field.name: 0 for field in dataclasses.fields(Assessment)},
        **{"notes": (), "chi_square": 1.0, "n_values": 20, "n_matched": 20, "kappa": 0.0, "factor_std": 0.02},
        **{"root_std": 0.001, "threshold": None, "detectable": (0.1,) * 7, "baseline": True},
        **{"assumed_std": False, "odd_baselines": ()},
    }
    table = Hypotheses(rows, {e: label(e) for e in range(7)})
    alike = tuple(group if group is not None else [row for row in rows if row.elements][:1])
    return Assessment(**(known | {"hypotheses": table, "group": alike, "declared": declared} | fields))


ONE = [one(4, 0.97), nothing(0.03)]
ALIKE = [one(2, 0.5), one(3, 0.48, (0.25,)), nothing(0.02)]
NESTED = [one(4, 0.5), one((4, 5), 0.3), one((4, 6), 0.17), nothing(0.03)]
MANY = [one(tuple(sorted({3, e})), 0.16) for e in (0, 1, 2, 4, 5, 6)] + [nothing(0.04)]
GROUP = [one(3, 0.44), one(2, 0.28), unknown(0.27), nothing(0.01)]
BLIND = Hypothesis((6,), 0.09, (0.0,), (0.0,), (0.93,), candidate=False)
IDLE = [one(4, 0.70, (0.3,)), one((1, 4), 0.15, (1e-5, 0.3)), one((4, 6), 0.12, (0.3, 0.004)), nothing(0.03)]
IDLE_ANSWER = [one((1, 4), 0.6, (0.3, 0.001)), one((1, 6), 0.35, (0.3, 0.2)), nothing(0.05)]
CRACK = dataclasses.replace(one(4, 0.999, candidate=False), place="a crack in spring 4")
SHIFT, OFF = {"moved_alike": -0.008}, {"factor_std": 0.6}

UNFIT = "the data of now are unfit. Too short. Record 9 s."
ODD = {"odd_baselines": (2,), "baseline_gap": 0.032, "usual_gap": 0.00097}
SAID = {  #: Assessments, whose headlines are in headlines.txt.
    "one": assessed([one(4, 0.97, (0.55,)), nothing(0.03)], (4,)),
    "two": assessed([one((1, 4), 0.95, (0.3, 0.2))], (1, 4)),
    "two values": assessed(ONE, (4,), n_values=2, n_matched=2),
    "two alike and something else": assessed(GROUP, (3,), GROUP[:2]),
    "something else, perhaps": assessed([unknown(0.6), one(1, 0.38), nothing(0.02)], (), []),
    "something else or nothing": assessed([unknown(0.6), nothing(0.4)], (), []),
    "something else": assessed([unknown(0.97), nothing(0.03)]),
    "no candidate": assessed([one(5, 0.98, (0.4,), candidate=False), nothing(0.02)]),
    "two alike": assessed(ALIKE, (2,), ALIKE[:2]),
    "one and perhaps another": assessed(NESTED, (4,), NESTED[:3]),
    "one and another": assessed(NESTED[1:3] + [nothing(0.03)], (4, 5), NESTED[1:3]),
    "one and perhaps others": assessed(MANY, (0, 3), []),
    "anywhere": assessed([one(e, 0.14) for e in range(7)] + [nothing(0.02)], (0,), []),
    "probably one": assessed([one(4, 0.8), one(5, 0.15), nothing(0.05)], (4,)),
    "an odd baseline": assessed(ONE, (4,), **ODD),
    "two baselines that differ": assessed(ONE, (4,), odd_baselines=(0, 1), baseline_gap=0.05),
    "another model": assessed(ALIKE, (2,), ALIKE[:2], n_intact=20, n_intact_matched=5),
    "another model, with a hint": assessed(ONE, (4,), hint="In mm?", **OFF),
    "another model, nothing": assessed([nothing(0.99)], **OFF),
    "another model, all alike": assessed([unknown(0.98)], **OFF, **SHIFT),
    "stopped": assessed(ONE, (4,), interrupted=True),
    "stopped, nothing": assessed([nothing(0.999), one(1, 0.001)], interrupted=True),
    "stopped, none explains": assessed([unknown(0.999), one(1, 0.001)], interrupted=True),
    "all alike": assessed([unknown(0.98), nothing(0.02)], **SHIFT),
    "all alike, probably": assessed([unknown(0.6), one(1, 0.4)], **SHIFT),
    "idle elements": without_idle(assessed(IDLE, (4,), IDLE[:3])),
    "unfit data": assessed(ONE, (4,), unfit=UNFIT),
    "nothing, or what is not shown": assessed([nothing(0.6), one(0, 0.4, (1e-5,))]),
    "nothing": assessed([nothing(0.99), one(1, 0.01)]),
    "nothing, that does not explain": assessed([nothing(0.95), one(1, 0.05)], (), [], chi_square=6),
    "nothing, perhaps": assessed([nothing(0.6), one(0, 0.3, (0.01,)), unknown(0.1)]),
    "nothing, probably": assessed([nothing(0.89), BLIND, one(1, 0.02)], (), []),
    "nothing or no candidate": assessed([nothing(0.89), one(6, 0.09, candidate=False), one(1, 0.02)], (), []),
    "one, perhaps": assessed([one(0, 0.6), nothing(0.4)], (0,)),
    "declared, improbable": assessed([nothing(0.9), one(0, 0.1)], (0,), threshold=-3.0),
    "probable, not declared": assessed([one(0, 0.6), nothing(0.4)], (), threshold=1.0),
    "one, that does not explain": assessed([one(4, 0.99)], (4,), chi_square=9.0),
    "what is no candidate and does not explain": assessed([CRACK, nothing(0.001)], (), [], chi_square=9.0),
}
ALONE = {  #: The same without a baseline: losses, and whether the search came to its end.
    "one state, stopped": ({1: 0.2}, False),
    "one state, stopped, nothing": ({}, False),
    "one state, nothing": ({}, True),
    "one state": ({1: 0.2}, True),
}


def test_the_headlines():
    said = {case: " ".join(headline(found)) for case, found in SAID.items()}
    for case, (losses, finished) in ALONE.items():
        said[case] = " ".join(headline_of_one_state(losses, label, finished=finished))
    compare(Path(__file__).with_name("headlines.txt"), said)


def test_supersets_whose_further_elements_lose_nothing_are_the_smaller_set():
    table, others = hypothesis_rows(without_idle(assessed(IDLE, (4,), IDLE[:3])))
    assert {row["name"]: row["probability"] for row in table} == {"spring 4": "97.0", "no damage": "3.0"}
    assert others == ""
    merged = without_idle(assessed(IDLE_ANSWER, (1, 4), IDLE_ANSWER[:2]))
    assert (merged.declared, merged.probability_of_nothing) == ((1,), 0.05)
    assert "spring 4" not in " ".join(headline(merged))
    place = "crack 0.2 m from node 3 in element {}"
    for idle, left, kind, where in (
        ((0.004, 0.2), 4, "element", ""),  # what has the crack loses next to nothing
        ((0.2, 0.004), 1, "crack", place.format(1)),
    ):
        both = dataclasses.replace(one((1, 4), 0.97, idle), kind="crack and element", place=place.format(1))
        first = without_idle(assessed([both, nothing(0.03)], (1, 4))).best
        assert (first.elements, first.kind, first.place) == ((left,), kind, where)
    cracks = "; ".join(map(place.format, (1, 4)))
    both = dataclasses.replace(one((1, 4), 0.97, (0.004, 0.2)), kind="crack", place=cracks)
    first = without_idle(assessed([both, nothing(0.03)], (1, 4))).best
    assert (first.elements, first.kind, first.place) == ((4,), "crack", place.format(4))
    whole = assessed([one(4, 0.6, (0.3,)), one((1, 4), 0.37, (0.01, 0.3)), nothing(0.03)], (4,))
    assert without_idle(whole) is whole  # a whole percent is told


NOTES = [(assessed(ONE, (4,), n_values=2, n_matched=2), "2 values cannot locate damage.")]
NOTES += [(assessed(ONE, (4,), chi_square=9.0), "reduced chi-square 9.0")]
KNOWN = "predicts changes to about 0.042 %: it explained the baseline to 0.00032 %"
NOTES += [(assessed(ONE, (4,), kappa=0.00042, root_std=3.2e-6), KNOWN)]
NOTES += [(assessed(ONE, (4,), n_baselines=1), "One test of the intact structure")]
NOTES += [(assessed(ONE, (4,), n_baselines=3, scatter=2.5), "2.5 times as much")]
NOTES += [(assessed(ONE, (4,), n_matched=18), "2 of 20 values have no partner")]
NOTES += [(assessed(ONE, (4,), n_matched=0), "No value of now has a partner")]
NOTES += [(assessed(ONE, (4,), assumed_std=True), "known to 0.05 %")]
NOTES += [(assessed(ONE, (4,), baseline=False), "Without a baseline every error")]


@pytest.mark.parametrize(("found", "note"), NOTES)
def test_reservations(found, note):
    assert [note in each for each in reservations(found)].count(True) == 1
    assert not any(note in each for each in reservations(assessed(ONE, (4,))))


def test_an_element_that_was_no_candidate_may_explain_and_an_unknown_change_does_not():
    rows = [one(5, 0.98, (0.4,), candidate=False)]
    found = (assessed(rows), assessed(rows, chi_square=9.0), assessed([unknown(0.98)]))
    assert [each.explained for each in found] == [True, False, False]


def test_no_figure_is_rounded_to_certainty():
    sure = ["above 99.9 %", "above 99.9 %", "50.0 %", "below 0.1 %"]
    assert [words.percent(p) for p in (1.0, 0.9995, 0.5, 2e-4)] == sure
    assert (words.span(0.38, 0.41), words.span(0.3998, 0.4003)) == ("38.0 to 41.0", "39.98 to 40.03")
    assert words.loss(0.0004, 0.0001, 0.0011) == "0.04 (0.01 to 0.11)"
    assert words.loss(0.3996, 0.3991, 0.4000, " %") == "39.96 % (39.91 to 40.00)"
    assert [words.figure(f) for f in (0.05, 0.996, 0.0)] == ["5 %", "100 %", "0 %"]

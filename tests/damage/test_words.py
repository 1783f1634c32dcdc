"""What an assessment says in words: is there damage, where, how sure, how much, what else it may be."""

import dataclasses

import numpy as np
import pytest

from antires_rs.damage import hypotheses as words
from antires_rs.damage.hypotheses import UNKNOWN, Assessment, Hypotheses, Hypothesis, without_idle
from antires_rs.damage.words import headline, headline_of_one_state, reservations
from antires_rs.figures.report_parts import hypothesis_rows
from tests.support.refusals import each_of


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
SHIFT, OFF = {"moved_alike": -0.008}, {"factor_std": 0.6}

SAID = {  #: Sentences, and what they are said of.
    "Damage: spring 4 has lost 55.0 % of its stiffness. Probability 97.0 %; 90 % interval of the loss "
    "54.0 to 57.0 %.": assessed([one(4, 0.97, (0.55,)), nothing(0.03)], (4,)),
    "Damage: spring 1 has lost 30.0 % of its stiffness and spring 4 20.0 %. Probability 95.0 %; 90 % "
    "intervals of the loss 29.0 to 32.0 and 19.0 to 22.0 "
    "%.": assessed([one((1, 4), 0.95, (0.3, 0.2))], (1, 4)),
    "Damage; if only one element is damaged: spring 4": assessed(ONE, (4,), n_values=2, n_matched=2),
    "2 values cannot tell more.": assessed(ONE, (4,), n_values=2, n_matched=2),
    "What else it may be: a change that no element explains (27.0 %).": assessed(GROUP, (3,), GROUP[:2]),
    "Something has changed (probability 98.0 %), perhaps what none of the candidates explains (probability "
    "60.0 %). What else it may be: spring 1 has lost 20.0 % of its stiffness (38.0 %); nothing (2.0 %).": (
        assessed([unknown(0.6), one(1, 0.38), nothing(0.02)], (), [])
    ),
    "It cannot be told whether something has changed (probability 60.0 %)": (
        assessed([unknown(0.6), nothing(0.4)], (), [])
    ),
    "Something has changed that none of the candidates explains (probability 97.0 %).": (
        assessed([unknown(0.97), nothing(0.03)])
    ),
    "What would explain it, and was no candidate: spring 5 has lost 40.0 % of its stiffness (90 % "
    "interval of the loss 39.0 to 42.0 %).": assessed([one(5, 0.98, (0.4,), candidate=False), nothing(0.02)]),
    "There is damage (probability 98.0 %): spring 2 or spring 3. The values cannot tell which. Together "
    "98.0 %. 50.0 %: spring 2 has lost 20.0 % of its stiffness (90 % interval of the loss 19.0 to 22.0 %); "
    "48.0 %: spring 3 has lost 25.0 % of its stiffness (90 % interval of the loss 24.0 to 27.0 %).": (
        assessed(ALIKE, (2,), ALIKE[:2])
    ),
    "spring 4 (97.0 %); perhaps spring 5 or spring 6 as well.": assessed(NESTED, (4,), NESTED[:3]),
    "spring 4 (47.0 %); and spring 5 or spring 6, the values cannot tell which.": (
        assessed(NESTED[1:3] + [nothing(0.03)], (4, 5), NESTED[1:3])
    ),
    "spring 3 (96.0 %); perhaps others as well, the values cannot tell which. First of many: ": (
        assessed(MANY, (0, 3), [])
    ),
    "There is damage (probability 98.0 %), but the values cannot tell where.": (
        assessed([one(e, 0.14) for e in range(7)] + [nothing(0.02)], (0,), [])
    ),
    "Something has changed (probability 99.0 %): spring 2 or spring 3. The values cannot tell which. "
    "Together 72.0 %. ": assessed(GROUP, (3,), GROUP[:2]),
    "There is damage (probability 95.0 %), probably this: spring 4 has lost 20.0 % of its stiffness.": (
        assessed([one(4, 0.8), one(5, 0.15), nothing(0.05)], (4,))
    ),
    "The baseline contradicts itself: baseline set 2 differs from the others by 3.2 %, these among "
    "themselves by 0.097 %": assessed(ONE, (4,), odd_baselines=(2,), baseline_gap=0.032, usual_gap=0.00097),
    "baseline set 0 and baseline set 1 differ by up to 5 %": (
        assessed(ONE, (4,), odd_baselines=(0, 1), baseline_gap=0.05)
    ),
    "If the baseline can be trusted at all, the values point to damage of spring 4; the table has the "
    "figures.": (assessed(ONE, (4,), odd_baselines=(2,))),
    "The model does not explain the measurement: 5 of 20 values of the intact structure have a partner "
    "in it. Check its units, dofs, force and supports. If the model can be trusted at all, the values "
    "point to damage of spring 2 or spring "
    "3": assessed(ALIKE, (2,), ALIKE[:2], n_intact=20, n_intact_matched=5),
    "its stiffnesses and masses would have to be off by 60 %, and its frequencies by 0.1 % beyond that. "
    "In mm?": (assessed(ONE, (4,), hint="In mm?", **OFF)),
    "If the model can be trusted at all, no damage is to be seen": assessed([nothing(0.99)], **OFF),
    "If the model can be trusted at all, all values have moved alike": assessed(
        [unknown(0.98)], **OFF, **SHIFT
    ),
    "The search was stopped: 2 hypotheses were judged, and the likeliest of these is that spring 4 has "
    "lost": (assessed(ONE, (4,), interrupted=True)),
    "and the likeliest of these is that nothing has changed. Others may explain": (
        assessed([nothing(0.999), one(1, 0.001)], interrupted=True)
    ),
    "2 hypotheses were judged, and none of these explains the values.": (
        assessed([unknown(0.999), one(1, 0.001)], interrupted=True)
    ),
    "No damage found: all values are 0.8 % lower than in the intact state, as another temperature or "
    "sampling clock would have it (probability 98.0 %).": assessed([unknown(0.98), nothing(0.02)], **SHIFT),
    "Probably no damage: all values are 0.8 % lower": assessed([unknown(0.6), one(1, 0.4)], **SHIFT),
    "Damage: spring 4 has lost 30.0 % of its stiffness. Probability 97.0 %": (
        without_idle(assessed(IDLE, (4,), IDLE[:3]))
    ),
    "It cannot be told whether there is damage: the data of now are unfit. Too short. Record 9 s. If the "
    "data can be trusted at all, the values point to damage of spring 4": (
        assessed(ONE, (4,), unfit="the data of now are unfit. Too short. Record 9 s.")
    ),
    "What else it may be: damage of spring 0, which these values do not show (40.0 %).": (
        assessed([nothing(0.6), one(0, 0.4, (1e-5,))])
    ),
    "No damage found: nothing has changed (probability 99.0 %).": assessed([nothing(0.99), one(1, 0.01)]),
    "But that does not explain all of the values": assessed(
        [nothing(0.95), one(1, 0.05)], (), [], chi_square=6
    ),
    "It cannot be told whether there is damage; probably nothing has changed (probability 60.0 %). What "
    "else it may be: spring 0 has lost 1.0 % of its stiffness (30.0 %); a change that no element "
    "explains (10.0 %).": (assessed([nothing(0.6), one(0, 0.3, (0.01,)), unknown(0.1)])),
    "No damage found: probably nothing has changed (probability 89.0 %). Not to be excluded: damage of "
    "spring 6, which these values do not show (9.0 "
    "%).": assessed([nothing(0.89), BLIND, one(1, 0.02)], (), []),
    "It cannot be told whether there is damage": (
        assessed([nothing(0.89), one(6, 0.09, candidate=False), one(1, 0.02)], (), [])
    ),
    "Perhaps damage (60.0 %): spring 0 has lost 20.0 % of its stiffness. Probability 60.0 %; 90 % "
    "interval of the loss 19.0 to 22.0 %. Probability that nothing has changed: 40.0 %.": (
        assessed([one(0, 0.6), nothing(0.4)], (0,))
    ),
    "Damage is declared for the rate of false alarms asked for, though it is improbable: ": (
        assessed([nothing(0.9), one(0, 0.1)], (0,), threshold=-3.0)
    ),
    "No damage declared: it is probable (60.0 %), but not enough for the rate of false alarms asked for.": (
        assessed([one(0, 0.6), nothing(0.4)], (), threshold=1.0)
    ),
    "But it does not explain all of the values": assessed([one(4, 0.99)], (4,), chi_square=9.0),
}


@pytest.mark.parametrize("said", SAID)
def test_the_headline(said):
    assert said in " ".join(headline(SAID[said]))


@pytest.mark.parametrize(
    ("losses", "finished", "said"),
    [
        ({1: 0.2}, False, "The search was stopped: the best so far, if the model is exact, is that spring 1"),
        ({}, False, "stopped: no damage so far. Without a baseline it is not known what was there"),
        ({}, True, "No damage found."),
        ({1: 0.2}, True, "Spring 1 has lost 20.0 % of its stiffness, if the model is exact."),
    ],
)
def test_the_headline_without_a_baseline(losses, finished, said):
    assert said in " ".join(headline_of_one_state(losses, label, finished=finished))


def test_supersets_whose_further_elements_lose_nothing_are_the_smaller_set():
    table, others = hypothesis_rows(without_idle(assessed(IDLE, (4,), IDLE[:3])))
    assert {row["name"]: row["probability"] for row in table} == {"spring 4": "97.0", "no damage": "3.0"}
    assert others == ""
    merged = without_idle(assessed(IDLE_ANSWER, (1, 4), IDLE_ANSWER[:2]))
    assert (merged.declared, merged.probability_of_nothing) == ((1,), 0.05)
    assert "spring 4" not in " ".join(headline(merged))
    whole = assessed([one(4, 0.6, (0.3,)), one((1, 4), 0.37, (0.01, 0.3)), nothing(0.03)], (4,))
    assert without_idle(whole) is whole  # a whole percent is told


NOTES = [(assessed(ONE, (4,), n_values=2, n_matched=2), "2 values cannot locate damage.")]
NOTES += [(assessed(ONE, (4,), chi_square=9.0), "reduced chi-square 9.0")]
NOTES += [
    (
        assessed(ONE, (4,), kappa=0.00042, root_std=3.2e-6),
        "predicts changes to about 0.042 %: it explained the baseline to 0.00032 %",
    )
]
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


PRINTED = {
    words.percent: [((1.0,), "above 99.9 %"), ((0.9995,), "above 99.9 %"), ((0.5,), "50.0 %")]
    + [((2e-4,), "below 0.1 %")]
}
PRINTED |= {words.span: [((0.38, 0.41), "38.0 to 41.0"), ((0.3998, 0.4003), "39.98 to 40.03")]}
PRINTED |= {
    words.loss: [((0.0004, 0.0001, 0.0011), "0.04 (0.01 to 0.11)")]
    + [((0.3996, 0.3991, 0.4000, " %"), "39.96 % (39.91 to 40.00)")]
}
PRINTED |= {words.figure: [((0.05,), "5 %"), ((0.996,), "100 %"), ((0.0,), "0 %")]}


@pytest.mark.parametrize(("printed", "case"), each_of(PRINTED))
def test_no_figure_is_rounded_to_certainty(printed, case):
    assert printed(*case[0]) == case[1]

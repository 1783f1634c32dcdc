"""What an assessment says in words: is there damage, where, how sure, how much, what else it may be."""

import dataclasses

import numpy as np
import pytest

from antires_rs.damage.hypotheses import (
    UNKNOWN,
    Assessment,
    Hypotheses,
    Hypothesis,
    figure,
    loss,
    percent,
    span,
)
from antires_rs.damage.words import headline, headline_of_one_state, reservations, without_idle
from antires_rs.figures.report_parts import hypothesis_rows


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
BLIND = Hypothesis((6,), 0.09, (0.0,), (0.0,), (0.93,), candidate=False)
IDLE = [one(4, 0.70, (0.3,)), one((1, 4), 0.15, (1e-5, 0.3)), one((4, 6), 0.12, (0.3, 0.004)), nothing(0.03)]
IDLE_ANSWER = [one((1, 4), 0.6, (0.3, 0.001)), one((1, 6), 0.35, (0.3, 0.2)), nothing(0.05)]
SHIFT = {"moved_alike": -0.008}
STOPPED = "The search was stopped: 2 hypotheses were judged, and "
DOUBT = "If the model can be trusted at all, the values point to damage of "
NO_MODEL = "The model does not explain the measurement: "
CHECK = "Check its units, dofs, force and supports."

#: What was found, and what is said of it.
SAID = {
    "one element": (
        assessed([one(4, 0.97, (0.55,)), nothing(0.03)], (4,)),
        "Damage: spring 4 has lost 55.0 % of its stiffness.",
        "Probability 97.0 %; 90 % interval of the loss 54.0 to 57.0 %.",
    ),
    "two elements": (
        assessed([one((1, 4), 0.95, (0.3, 0.2))], (1, 4)),
        "Damage: spring 1 has lost 30.0 % of its stiffness and spring 4 20.0 %.",
        "Probability 95.0 %; 90 % intervals of the loss 29.0 to 32.0 and 19.0 to 22.0 %.",
    ),
    "two values": (
        assessed(ONE, (4,), n_values=2, n_matched=2),
        "Damage; if only one element is damaged: spring 4 has lost 20.0 % of its stiffness.",
        "Probability 97.0 %; 90 % interval of the loss 19.0 to 22.0 %. 2 values cannot tell more.",
    ),
    "perhaps unknown": (
        assessed([unknown(0.6), one(1, 0.38), nothing(0.02)], (), []),
        "Something has changed (probability 98.0 %), perhaps what none of the candidates explains "
        "(probability 60.0 %).",
        "What else it may be: spring 1 has lost 20.0 % of its stiffness (38.0 %); nothing (2.0 %).",
    ),
    "unknown or nothing": (
        assessed([unknown(0.6), nothing(0.4)], (), []),
        "It cannot be told whether something has changed (probability 60.0 %)",
    ),
    "nothing that is known": (
        assessed([unknown(0.98), nothing(0.02)]),
        "Something has changed that none of the candidates explains (probability 98.0 %).",
    ),
    "no candidate": (
        assessed([one(5, 0.98, (0.4,), candidate=False), nothing(0.02)]),
        "Something has changed that none of the candidates explains (probability 98.0 %).",
        "What would explain it, and was no candidate: spring 5 has lost 40.0 % of its stiffness "
        "(90 % interval of the loss 39.0 to 42.0 %).",
    ),
    "alike": (
        assessed(ALIKE, (2,), ALIKE[:2]),
        "There is damage (probability 98.0 %): spring 2 or spring 3. The values cannot tell which.",
        "Together 98.0 %. "
        "50.0 %: spring 2 has lost 20.0 % of its stiffness (90 % interval of the loss 19.0 to 22.0 %); "
        "48.0 %: spring 3 has lost 25.0 % of its stiffness (90 % interval of the loss 24.0 to 27.0 %).",
    ),
    "nested": (
        assessed(NESTED, (4,), NESTED[:3]),
        "There is damage (probability 97.0 %): spring 4 (97.0 %); perhaps spring 5 or spring 6 as well.",
        "Together 97.0 %. 50.0 %: spring 4 has lost",
    ),
    "nested without the smallest": (
        assessed(NESTED[1:3] + [nothing(0.03)], (4, 5), NESTED[1:3]),
        "spring 4 (47.0 %); and spring 5 or spring 6, the values cannot tell which.",
    ),
    "one element in many sets": (
        assessed(
            [one(tuple(sorted({3, e})), 0.16) for e in (0, 1, 2, 4, 5, 6)] + [nothing(0.04)], (0, 3), []
        ),
        "There is damage (probability 96.0 %): spring 3 (96.0 %); perhaps others as well, the values cannot "
        "tell which.",
        "First of many: ",
    ),
    "nowhere in particular": (
        assessed([one(e, 0.14) for e in range(7)] + [nothing(0.02)], (0,), []),
        "There is damage (probability 98.0 %), but the values cannot tell where.",
        "First of many: ",
    ),
    "a group and something else": (
        assessed(
            [one(3, 0.44), one(2, 0.28), unknown(0.27), nothing(0.01)], (3,), [one(3, 0.44), one(2, 0.28)]
        ),
        "Something has changed (probability 99.0 %): spring 2 or spring 3. The values cannot tell which.",
        "Together 72.0 %. ",
        "What else it may be: a change that no element explains (27.0 %).",
    ),
    "probably one": (
        assessed([one(4, 0.8), one(5, 0.15), nothing(0.05)], (4,)),
        "There is damage (probability 95.0 %), probably this: spring 4 has lost 20.0 % of its stiffness.",
        "Probability 80.0 %; 90 % interval of the loss 19.0 to 22.0 %. What else it may be: spring 5 has "
        "lost 20.0 % of its stiffness (15.0 %); nothing (5.0 %).",
    ),
    "an odd baseline": (
        assessed(ONE, (4,), odd_baselines=(2,), baseline_gap=0.032, usual_gap=0.00097),
        "The baseline contradicts itself: baseline set 2 differs from the others by 3.2 %, these among "
        "themselves by 0.097 %",
        "If the baseline can be trusted at all, the values point to damage of spring 4; the table has the "
        "figures.",
    ),
    "a model without partners": (
        assessed(
            [one(4, 0.6), one(5, 0.39), nothing(0.01)],
            (4,),
            [one(4, 0.6), one(5, 0.39)],
            n_intact=20,
            n_intact_matched=5,
        ),
        f"{NO_MODEL}5 of 20 values of the intact structure have a partner in it. {CHECK}",
        f"{DOUBT}spring 4 or spring 5; the table has the figures.",
    ),
    "a model far off": (
        assessed(ONE, (4,), factor_std=0.6, hint="Is it in mm?"),
        f"{NO_MODEL}its stiffnesses and masses would have to be off by 60 %, and its frequencies by 0.1 % "
        f"beyond that. Is it in mm? {CHECK}",
        f"{DOUBT}spring 4; the table has the figures.",
    ),
    "stopped at damage": (
        assessed([one(4, 0.999), one(1, 0.001)], (4,), interrupted=True),
        f"{STOPPED}the likeliest of these is that spring 4 has lost 20.0 % of its stiffness.",
        "Others may explain",
    ),
    "stopped at something else": (
        assessed([unknown(0.999), one(1, 0.001)], interrupted=True),
        f"{STOPPED}none of these explains the values.",
    ),
    "all moved alike": (
        assessed([unknown(0.98), nothing(0.02)], **SHIFT),
        "No damage found: all values are 0.8 % lower than in the intact state, as another temperature or "
        "sampling clock would have it (probability 98.0 %).",
    ),
    "moved alike by a model far off": (
        assessed([unknown(0.98)], factor_std=0.6, **SHIFT),
        "If the model can be trusted at all, all values have moved alike",
    ),
    "idle elements": (
        assessed(IDLE, (4,), IDLE[:3]),
        "Damage: spring 4 has lost 30.0 % of its stiffness.",
        "Probability 97.0 %; 90 % interval of the loss 29.0 to 32.0 %.",
    ),
    "a loss of zero": (
        assessed([nothing(0.6), one(0, 0.4, (1e-5,))]),
        "It cannot be told whether there is damage; probably nothing has changed (probability 60.0 %).",
        "What else it may be: damage of spring 0, which these values do not show (40.0 %).",
    ),
    "nothing for sure": (
        assessed([nothing(0.99), one(1, 0.01)]),
        "No damage found: nothing has changed (probability 99.0 %).",
    ),
    "nothing, unexplained": (
        assessed([nothing(0.95), one(1, 0.05)], (), [], chi_square=6.0),
        "No damage found: ",
        "But that does not explain all of the values",
    ),
    "nothing perhaps": (
        assessed([nothing(0.6), one(0, 0.3, (0.01,)), unknown(0.1)]),
        "It cannot be told whether there is damage; probably nothing has changed (probability 60.0 %).",
        "What else it may be: spring 0 has lost 1.0 % of its stiffness (30.0 %); a change that no element "
        "explains (10.0 %).",
    ),
    "nothing, but for what no value shows": (
        assessed([nothing(0.89), BLIND, one(1, 0.02)], (), []),
        "No damage found: probably nothing has changed (probability 89.0 %).",
        "Not to be excluded: damage of spring 6, which these values do not show (9.0 %).",
    ),
    "nothing, but for an element that values show": (
        assessed([nothing(0.89), one(6, 0.09, candidate=False), one(1, 0.02)], (), []),
        "It cannot be told whether there is damage",
    ),
    "damage perhaps": (
        assessed([one(0, 0.6), nothing(0.4)], (0,)),
        "Perhaps damage (60.0 %): spring 0 has lost 20.0 % of its stiffness.",
        "Probability 60.0 %; 90 % interval of the loss 19.0 to 22.0 %. Probability that nothing has changed: "
        "40.0 %.",
    ),
    "a low threshold": (
        assessed([nothing(0.9), one(0, 0.1)], (0,), threshold=-3.0),
        "Damage is declared for the rate of false alarms asked for, though it is improbable: ",
    ),
    "a high threshold": (
        assessed([one(0, 0.6), nothing(0.4)], (), threshold=1.0),
        "No damage declared: it is probable (60.0 %), but not enough for the rate of false alarms asked for.",
    ),
    "damage, unexplained": (
        assessed([one(4, 0.99)], (4,), chi_square=9.0),
        "But it does not explain all of the values",
    ),
}


def is_said(lines, wanted):
    text = " ".join(lines)
    assert [want for want in wanted if want not in text] == [], text


@pytest.mark.parametrize("case", SAID)
def test_the_headline(case):
    found, *wanted = SAID[case]
    is_said(headline(found), wanted)
    assert "spring 4" not in " ".join(headline(assessed(IDLE_ANSWER, (1, 4), IDLE_ANSWER[:2])))


@pytest.mark.parametrize(
    ("losses", "finished", "wanted"),
    [
        ({1: 0.2}, False, ["stopped: the best so far, if the model is exact, is that spring 1"]),
        ({}, False, ["The search was stopped: no damage so far.", "it is not known what was there"]),
        ({}, True, ["No damage found."]),
        ({1: 0.2}, True, ["Spring 1 has lost 20.0 % of its stiffness, if the model is exact."]),
    ],
)  # fmt: skip
def test_the_headline_without_a_baseline(losses, finished, wanted):
    is_said(headline_of_one_state(losses, label, finished=finished), wanted)


def test_supersets_whose_further_elements_lose_nothing_are_the_smaller_set():
    table, others = hypothesis_rows(without_idle(assessed(IDLE, (4,), IDLE[:3])))
    assert [(row["name"], row["probability"]) for row in table] == [
        ("spring 4", "97.0"),
        ("no damage", "3.0"),
    ]
    assert others == ""
    # The answer itself may be such a set, and the smaller one may not have been judged.
    merged = without_idle(assessed(IDLE_ANSWER, (1, 4), IDLE_ANSWER[:2]))
    assert (merged.declared, merged.probability_of_nothing) == ((1,), 0.05)
    whole = assessed([one(4, 0.6, (0.3,)), one((1, 4), 0.37, (0.01, 0.3)), nothing(0.03)], (4,))
    assert without_idle(whole) is whole  # a whole percent is told


@pytest.mark.parametrize(
    ("found", "note"),
    [
        (assessed(ONE, (4,), n_values=2, n_matched=2), "Only 2 values are compared, 1 more than"),
        (assessed(ONE, (4,), chi_square=9.0), "reduced chi-square 9.0"),
        (
            assessed(ONE, (4,), kappa=0.00042, root_std=3.2e-6),
            "predicts changes to about 0.042 %: it explained the baseline to 0.00032 %",
        ),
        (assessed(ONE, (4,), n_baselines=1), "One test of the intact structure"),
        (assessed(ONE, (4,), n_baselines=3, scatter=2.5), "2.5 times as much"),
        (assessed(ONE, (4,), n_matched=18), "2 of 20 values have no partner"),
        (assessed(ONE, (4,), n_matched=0), "No value of now has a partner"),
        (assessed(ONE, (4,), assumed_std=True), "known to 0.05 %"),
        (assessed(ONE, (4,), baseline=False), "Without a baseline every error"),
    ],
)
def test_reservations(found, note):
    assert [note in each for each in reservations(found)].count(True) == 1
    assert not any(note in each for each in reservations(assessed(ONE, (4,))))


def test_an_element_that_was_no_candidate_may_explain_and_an_unknown_change_does_not():
    rows = [one(5, 0.98, (0.4,), candidate=False)]
    found = (assessed(rows), assessed(rows, chi_square=9.0), assessed([unknown(0.98)]))
    assert [each.explained for each in found] == [True, False, False]


@pytest.mark.parametrize(
    ("printed", "words"),
    [
        (percent(1.0), "above 99.9 %"),
        (percent(0.9995), "above 99.9 %"),
        (percent(0.5), "50.0 %"),
        (percent(2e-4), "below 0.1 %"),
        (span(0.38, 0.41), "38.0 to 41.0"),
        (span(0.3998, 0.4003), "39.98 to 40.03"),
        (loss(0.0004, 0.0001, 0.0011), "0.04 (0.01 to 0.11)"),
        (loss(0.3996, 0.3991, 0.4000, " %"), "39.96 % (39.91 to 40.00)"),
        (figure(0.05), "5 %"),
        (figure(0.996), "100 %"),
        (figure(0.0), "0 %"),
    ],
)
def test_no_figure_is_rounded_to_certainty(printed, words):
    assert printed == words

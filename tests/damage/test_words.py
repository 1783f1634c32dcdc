"""What an assessment says in words: is there damage, where, how sure, how much, what else it may be."""

import dataclasses

import numpy as np
import pytest

from antires_rs.damage.assessment import Assessment
from antires_rs.damage.hypotheses import UNKNOWN, Hypotheses, Hypothesis
from antires_rs.damage.percent import percent, span
from antires_rs.damage.words import headline, reservations


def one(elements, probability, severities=None, *, candidate=True):
    sizes = tuple(severities or (0.2,) * len(elements)) if elements != UNKNOWN else ()
    low, high = (tuple(np.round(np.array(sizes) + by, 3).tolist()) for by in (-0.01, 0.02))
    return Hypothesis(elements, probability, sizes, low, high, candidate)


def label(element):
    return f"spring {element + 1}"


def said(rows, declared=(), group=None, **fields):
    rows = sorted(rows, key=lambda row: -row.probability)
    known = {  # what is not named here says nothing of its own
        **{field.name: 0 for field in dataclasses.fields(Assessment)},
        "notes": (),
        "chi_square": 1.0,
        "n_values": 20,
        "n_matched": 20,
        "kappa": 0.0,
        "factor_std": 0.02,
        "root_std": 0.001,
        "threshold": None,
        "detectable": (0.1,) * 7,
        "baseline": True,
        "assumed_std": False,
    }
    table = Hypotheses(rows, {e: label(e) for e in range(7)})
    alike = tuple(group if group is not None else [row for row in rows if row.elements][:1])
    found = Assessment(**(known | {"hypotheses": table, "group": alike, "declared": declared} | fields))
    return headline(found, label), found


def test_one_damaged_element():
    lines, _ = said([one((4,), 0.97, (0.55,)), one((), 0.03)], (4,))
    assert lines == [
        "Damage: spring 5 has lost 55.0 % of its stiffness.",
        "Probability 97.0 %; 90 % interval of the loss 54.0 to 57.0 %.",
    ]


def test_two_damaged_elements():
    lines, _ = said([one((1, 4), 0.95, (0.3, 0.2))], (1, 4))
    assert lines == [
        "Damage: spring 2 has lost 30.0 % of its stiffness and spring 5 20.0 %.",
        "Probability 95.0 %; 90 % intervals of the loss 29.0 to 32.0 and 19.0 to 22.0 %.",
    ]


def test_elements_that_cannot_be_told_apart():
    rows = [one((2,), 0.5), one((3,), 0.48, (0.25,)), one((), 0.02)]
    lines, _ = said(rows, (2,), rows[:2])
    assert lines == [
        "There is damage (probability 98.0 %): spring 3 or spring 4. The values cannot tell which.",
        "Together 98.0 %. "
        "50.0 %: spring 3 has lost 20.0 % of its stiffness (90 % interval of the loss 19.0 to 22.0 %); "
        "48.0 %: spring 4 has lost 25.0 % of its stiffness (90 % interval of the loss 24.0 to 27.0 %).",
    ]


def test_damage_nowhere_in_particular():
    rows = [one((e,), 0.14) for e in range(7)] + [one((), 0.02)]
    lines, _ = said(rows, (0,), [])
    assert lines[0] == "There is damage (probability 98.0 %), but the values cannot tell where."


def test_nothing_for_sure():
    lines, _ = said([one((), 0.99), one((1,), 0.01)])
    assert lines == ["No damage found: nothing has changed (probability 99.0 %)."]


def test_nothing_perhaps():
    lines, _ = said([one((), 0.6), one((0,), 0.3, (0.01,)), one(UNKNOWN, 0.1, candidate=False)])
    assert lines == [
        "It cannot be told whether there is damage; probably nothing has changed (probability 60.0 %).",
        "What else it may be: spring 1 has lost 1.0 % of its stiffness (30.0 %); a change that no element "
        "explains (10.0 %).",
    ]


def test_damage_perhaps():
    lines, _ = said([one((0,), 0.6), one((), 0.4)], (0,))
    assert lines[0] == "Perhaps damage (60.0 %): spring 1 has lost 20.0 % of its stiffness."
    assert lines[1].endswith("Probability that nothing has changed: 40.0 %.")


def test_an_element_that_was_no_candidate():
    lines, _ = said([one((5,), 0.98, (0.4,), candidate=False), one((), 0.02)])
    assert lines == [
        "Something has changed that none of the candidates explains (probability 98.0 %).",
        "What would explain it, and was no candidate: spring 6 has lost 40.0 % of its stiffness "
        "(90 % interval of the loss 39.0 to 42.0 %).",
    ]


def test_nothing_that_is_known():
    lines, _ = said([one(UNKNOWN, 0.98, candidate=False), one((), 0.02)])
    assert lines == ["Something has changed that none of the candidates explains (probability 98.0 %)."]


def test_a_threshold_declares_more_or_less():
    lines, _ = said([one((), 0.9), one((0,), 0.1)], (0,), threshold=-3.0)
    assert lines[0].startswith(
        "Damage is declared for the rate of false alarms asked for, though it is impro"
    )
    lines, _ = said([one((0,), 0.6), one((), 0.4)], (), threshold=1.0)
    assert lines[0] == (
        "No damage declared: it is probable (60.0 %), but not enough for the rate of false alarms asked for."
    )


def test_what_is_not_explained_is_said_at_once():
    lines, found = said([one((4,), 0.99)], (4,), chi_square=9.0)
    assert not found.explained
    assert lines[-1].startswith("But it does not explain all of the values")
    assert any("reduced chi-square 9.0" in note for note in reservations(found, label))


@pytest.mark.parametrize(
    ("probability", "words"),
    [(1.0, "above 99.9 %"), (0.9995, "above 99.9 %"), (0.5, "50.0 %"), (2e-4, "below 0.1 %")],
)
def test_no_probability_is_rounded_to_certainty(probability, words):
    assert percent(probability) == words


def test_ends_of_an_interval_can_be_told_apart():
    assert span(0.38, 0.41) == "38.0 to 41.0"
    assert span(0.3998, 0.4003) == "39.98 to 40.03"

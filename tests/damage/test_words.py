"""What an assessment says in words: is there damage, where, how sure, how much, what else it may be."""

import dataclasses

import numpy as np
import pytest

from antires_rs.damage.hypotheses import UNKNOWN, Assessment, Hypotheses, Hypothesis, figure, percent, span
from antires_rs.damage.words import headline, reservations, without_idle
from antires_rs.figures.report_parts import hypothesis_rows


def one(elements, probability, severities=None, *, candidate=True):
    sizes = tuple(severities or (0.2,) * len(elements)) if elements != UNKNOWN else ()
    low, high = (tuple(np.round(np.array(sizes) + by, 3).tolist()) for by in (-0.01, 0.02))
    return Hypothesis(elements, probability, sizes, low, high, candidate)


def label(element):
    return f"spring {element}"


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
        "odd_baselines": (),
    }
    table = Hypotheses(rows, {e: label(e) for e in range(7)})
    alike = tuple(group if group is not None else [row for row in rows if row.elements][:1])
    found = Assessment(**(known | {"hypotheses": table, "group": alike, "declared": declared} | fields))
    return headline(found), found


def test_one_damaged_element():
    lines, _ = said([one((4,), 0.97, (0.55,)), one((), 0.03)], (4,))
    assert lines == [
        "Damage: spring 4 has lost 55.0 % of its stiffness.",
        "Probability 97.0 %; 90 % interval of the loss 54.0 to 57.0 %.",
    ]


def test_few_values_are_answered_with_reserve():
    rows = [one((4,), 0.97), one((), 0.03)]
    lines, found = said(rows, (4,), n_values=2, n_matched=2)
    assert lines == [
        "Damage; if only one element is damaged: spring 4 has lost 20.0 % of its stiffness.",
        "Probability 97.0 %; 90 % interval of the loss 19.0 to 22.0 %. 2 values cannot tell more.",
    ]
    assert any("Only 2 values are compared, 1 more than" in note for note in reservations(found))
    lines, found = said(rows, (4,), n_values=5, n_matched=5)
    assert lines[0].startswith("Damage: ")
    assert not any("Only" in note for note in reservations(found))


def test_an_unknown_change_that_is_not_sure_is_not_said_to_be():
    rows = [one(UNKNOWN, 0.6, candidate=False), one((1,), 0.38), one((), 0.02)]
    lines, _ = said(rows, (), [])
    assert lines == [
        "Something has changed (probability 98.0 %), perhaps what none of the candidates explains "
        "(probability 60.0 %).",
        "What else it may be: spring 1 has lost 20.0 % of its stiffness (38.0 %); nothing (2.0 %).",
    ]
    lines, _ = said([one(UNKNOWN, 0.6, candidate=False), one((), 0.4)], (), [])
    assert lines[0].startswith("It cannot be told whether something has changed (probability 60.0 %)")


def test_two_damaged_elements():
    lines, _ = said([one((1, 4), 0.95, (0.3, 0.2))], (1, 4))
    assert lines == [
        "Damage: spring 1 has lost 30.0 % of its stiffness and spring 4 20.0 %.",
        "Probability 95.0 %; 90 % intervals of the loss 29.0 to 32.0 and 19.0 to 22.0 %.",
    ]


def test_elements_that_cannot_be_told_apart():
    rows = [one((2,), 0.5), one((3,), 0.48, (0.25,)), one((), 0.02)]
    lines, _ = said(rows, (2,), rows[:2])
    assert lines == [
        "There is damage (probability 98.0 %): spring 2 or spring 3. The values cannot tell which.",
        "Together 98.0 %. "
        "50.0 %: spring 2 has lost 20.0 % of its stiffness (90 % interval of the loss 19.0 to 22.0 %); "
        "48.0 %: spring 3 has lost 25.0 % of its stiffness (90 % interval of the loss 24.0 to 27.0 %).",
    ]


def test_nested_sets_begin_with_what_they_share():
    rows = [one((4,), 0.5), one((4, 5), 0.3), one((4, 6), 0.17), one((), 0.03)]
    lines, _ = said(rows, (4,), rows[:3])
    assert lines[0] == (
        "There is damage (probability 97.0 %): spring 4 (97.0 %); perhaps spring 5 or spring 6 as well."
    )
    assert lines[1].startswith("Together 97.0 %. 50.0 %: spring 4 has lost")
    lines, _ = said(rows[1:3] + [one((), 0.03)], (4, 5), rows[1:3])
    assert "spring 4 (47.0 %); and spring 5 or spring 6, the values cannot tell which." in lines[0]


def test_many_sets_with_one_element_in_all_of_them():
    rows = [one(tuple(sorted({3, e})), 0.16) for e in (0, 1, 2, 4, 5, 6)] + [one((), 0.04)]
    lines, _ = said(rows, (0, 3), [])
    assert lines[0] == (
        "There is damage (probability 96.0 %): spring 3 (96.0 %); perhaps others as well, the values cannot "
        "tell which."
    )


def test_intact_tests_that_contradict_each_other_come_first():
    rows = [one((4,), 0.97), one((), 0.03)]
    lines, _ = said(rows, (4,), odd_baselines=(2,), baseline_gap=0.032, usual_gap=0.00097)
    assert lines[0].startswith(
        "The baseline contradicts itself: baseline set 2 differs from the others by 3.2 %, these among "
        "themselves by 0.097 %."
    )
    assert lines[1:] == [
        "If the baseline can be trusted at all, the values point to damage of spring 4; the table has the "
        "figures."
    ]
    lines, _ = said(rows, (4,), odd_baselines=(0, 1), baseline_gap=0.05)
    assert "baseline set 0 and baseline set 1 differ by up to 5 %" in lines[0]


def test_a_model_that_does_not_explain_the_intact_structure_weakens_what_follows():
    rows = [one((4,), 0.6), one((5,), 0.39), one((), 0.01)]
    lines, _ = said(rows, (4,), rows[:2], n_intact=20, n_intact_matched=5)
    assert lines == [
        "The model does not explain the measurement: 5 of 20 values of the intact structure have a partner "
        "in it. Check its units, dofs, force and supports.",
        "If the model can be trusted at all, the values point to damage of spring 4 or spring 5; the table "
        "has the figures.",
    ]
    for best, what in (
        (one((), 0.999), "no damage is to be seen"),
        (one(UNKNOWN, 0.999, candidate=False), "something has changed that none of the candidates explains"),
    ):
        lines, _ = said([best, one((1,), 0.001)], (), factor_std=0.6)
        assert lines[1] == f"If the model can be trusted at all, {what}; the table has the figures."


def test_a_search_that_was_stopped_says_so_and_gives_no_probability():
    for best, what in (
        (one((4,), 0.999), "the likeliest of these is that spring 4 has lost 20.0 % of its stiffness"),
        (one((), 0.999), "the likeliest of these is that nothing has changed"),
        (one(UNKNOWN, 0.999, candidate=False), "none of these explains the values"),
    ):
        lines, _ = said([best, one((1,), 0.001)], best.elements if best.candidate else (), interrupted=True)
        assert lines[0] == f"The search was stopped: 2 hypotheses were judged, and {what}."
        assert "99.9" not in " ".join(lines)


def test_a_shift_of_all_values_is_no_damage():
    shift = {"moved_alike": -0.008}
    lines, _ = said([one(UNKNOWN, 0.98, candidate=False), one((), 0.02)], **shift)
    assert lines == [
        "No damage found: all values are 0.8 % lower than in the intact state, as another temperature or "
        "sampling clock would have it (probability 98.0 %)."
    ]
    lines, _ = said([one(UNKNOWN, 0.6, candidate=False), one((1,), 0.4)], **shift)
    assert lines[0].startswith("Probably no damage: all values are 0.8 % lower")
    assert lines[1] == "What else it may be: spring 1 has lost 20.0 % of its stiffness (40.0 %)."
    lines, _ = said([one(UNKNOWN, 0.98, candidate=False)], factor_std=0.6, **shift)
    assert "all values have moved alike" in lines[1]


def test_supersets_whose_further_elements_lose_nothing_are_the_smaller_set():
    rows = [
        one((4,), 0.70, (0.3,)),
        one((1, 4), 0.15, (1e-5, 0.3)),
        one((4, 6), 0.12, (0.3, 0.004)),
        one((), 0.03),
    ]
    lines, found = said(rows, (4,), rows[:3])
    assert lines == [
        "Damage: spring 4 has lost 30.0 % of its stiffness.",
        "Probability 97.0 %; 90 % interval of the loss 29.0 to 32.0 %.",
    ]
    table, others = hypothesis_rows(without_idle(found))
    assert [row["name"] for row in table] == ["spring 4", "no damage"]
    assert [row["probability"] for row in table] == ["97.0", "3.0"]
    assert others == ""
    # The answer itself may be such a set, and the smaller one may not have been judged.
    rows = [one((1, 4), 0.6, (0.3, 0.001)), one((1, 6), 0.35, (0.3, 0.2)), one((), 0.05)]
    lines, found = said(rows, (1, 4), rows[:2])
    assert "spring 4" not in " ".join(lines)
    assert without_idle(found).declared == (1,)
    assert without_idle(found).probability_of_nothing == 0.05


def test_a_loss_of_a_whole_percent_is_told():
    rows = [one((4,), 0.6, (0.3,)), one((1, 4), 0.37, (0.01, 0.3)), one((), 0.03)]
    lines, found = said(rows, (4,), rows[:2])
    assert "spring 1" in lines[0]
    assert without_idle(found) is found


def test_errors_that_are_tiny_keep_their_digits():
    _, found = said([one((4,), 0.99)], (4,), kappa=0.00042, root_std=3.2e-6)
    told = " ".join(reservations(found))
    assert "predicts changes to about 0.042 %: it explained the baseline to 0.00032 %" in told
    assert (figure(0.05), figure(0.996), figure(0.0)) == ("5 %", "100 %", "0 %")


def test_an_element_that_was_no_candidate_may_explain_and_an_unknown_change_does_not():
    _, found = said([one((5,), 0.98, (0.4,), candidate=False)])
    assert found.explained
    _, found = said([one((5,), 0.98, (0.4,), candidate=False)], chi_square=9.0)
    assert not found.explained
    _, found = said([one(UNKNOWN, 0.98, candidate=False)])
    assert not found.explained


def test_an_alternative_that_loses_nothing_is_not_given_a_loss_of_zero():
    lines, _ = said([one((), 0.6), one((0,), 0.4, (1e-5,))])
    assert "lost 0.0 %" not in lines[1]


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
        "What else it may be: spring 0 has lost 1.0 % of its stiffness (30.0 %); a change that no element "
        "explains (10.0 %).",
    ]


def test_damage_perhaps():
    lines, _ = said([one((0,), 0.6), one((), 0.4)], (0,))
    assert lines[0] == "Perhaps damage (60.0 %): spring 0 has lost 20.0 % of its stiffness."
    assert lines[1].endswith("Probability that nothing has changed: 40.0 %.")


def test_an_element_that_was_no_candidate():
    lines, _ = said([one((5,), 0.98, (0.4,), candidate=False), one((), 0.02)])
    assert lines == [
        "Something has changed that none of the candidates explains (probability 98.0 %).",
        "What would explain it, and was no candidate: spring 5 has lost 40.0 % of its stiffness "
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
    assert any("reduced chi-square 9.0" in note for note in reservations(found))


@pytest.mark.parametrize(
    ("probability", "words"),
    [(1.0, "above 99.9 %"), (0.9995, "above 99.9 %"), (0.5, "50.0 %"), (2e-4, "below 0.1 %")],
)
def test_no_probability_is_rounded_to_certainty(probability, words):
    assert percent(probability) == words


def test_ends_of_an_interval_can_be_told_apart():
    assert span(0.38, 0.41) == "38.0 to 41.0"
    assert span(0.3998, 0.4003) == "39.98 to 40.03"


def test_what_is_beyond_a_group_is_named_and_a_change_of_another_kind_is_not_called_damage():
    rows = [one((3,), 0.44), one((2,), 0.28), one(UNKNOWN, 0.27, candidate=False), one((), 0.01)]
    lines, _ = said(rows, (3,), rows[:2])
    assert lines[0] == (
        "Something has changed (probability 99.0 %): spring 2 or spring 3. The values cannot tell which."
    )
    assert lines[1].startswith("Together 72.0 %. ")
    assert lines[2] == ("What else it may be: a change that no element explains (27.0 %).")


def test_no_damage_that_leaves_values_unexplained_says_so():
    lines, found = said([one((), 0.95), one((1,), 0.05)], (), [], chi_square=6.0)
    assert not found.explained
    assert lines[0].startswith("No damage found")
    assert lines[-1].startswith("But that does not explain all of the values")
    lines, _ = said([one((), 0.95), one((1,), 0.05)], (), [])
    assert len(lines) == 1


def test_an_element_that_no_value_shows_does_not_make_an_intact_structure_doubtful():
    ground = Hypothesis((6,), 0.09, (0.0,), (0.0,), (0.93,), candidate=False)
    lines, _ = said([one((), 0.89), ground, one((1,), 0.02)], (), [])
    assert lines == [
        "No damage found: probably nothing has changed (probability 89.0 %).",
        "Not to be excluded: damage of spring 6, which these values do not show (9.0 %).",
    ]
    lines, _ = said([one((), 0.8), ground, one((1,), 0.11)], (), [])
    assert lines[0].startswith("It cannot be told whether there is damage")
    shown = one((6,), 0.09, candidate=False)
    lines, _ = said([one((), 0.89), shown, one((1,), 0.02)], (), [])
    assert lines[0].startswith("It cannot be told whether there is damage")

"""Records in which nothing can be identified: no value is trusted, and the reason is told in plain words."""

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.identification.scores import with_second, without_common
from antires_rs.measured.response_table import ResponseTable, doubts_of
from reference import nothing_to_find, structures
from tests.support.campaign import some_of

BAND = (3.0, 130.0)
#: What is said of each: the name of the warning, and words of it; of the two that are refused, of the error.
REASONS = {"noise": ("signal_to_noise", "only noise in the band")}
REASONS |= {"two forces": ("one_force", "need more than one force")}
REASONS |= {"clocks apart": ("time_shift", r"against the other channels by \d.* s")}
REASONS |= {"clocks that drift": ("time_shift", r"on a clock of its own, .* ms off at first")}
REASONS |= {"one channel alive": ("dead_channel", "only noise in the band")}
REASONS |= {"free decay": (None, "the energy never rises from rest, as in a free decay")}
REASONS |= {"too short": (None, "a record that lasts 0.125 s; wanted at least")}
REASONS |= {"clipped": ("clipped_channel", r"clipped at .* % of the record")}
REASONS |= {"two steps": ("quantized_channel", "moves over 2 steps of its converter")}
REASONS |= {"one signal": ("duplicated_channels", "All channels hold one signal")}
REASONS |= {"sine": ("signal_to_noise", r"at \d.* % of the lines of the band, at 31.75 Hz")}


def identified(source):
    with warnings.catch_warnings(record=True, action="always") as seen:
        found = ar.identify_antiresonances(source, excitation=0, band_hz=BAND)
    return found, "\n".join(str(one.message) for one in seen), {n for one in seen for n in one.message.about}


assert set(REASONS) == set(nothing_to_find.RECORDS)  # eleven cases


@pytest.mark.parametrize(
    ("case", "seed"), some_of([(case, seed) for seed in (1, 4, 5) for case in REASONS], len(REASONS))
)
def test_it_says_so_and_why(case, seed):
    name, words = REASONS[case]
    source = nothing_to_find.record(case, seed)
    if name is None:
        with pytest.raises(ar.AntiresError, match=words):
            identified(source)
        return
    found, said, about = identified(source)
    assert name in about
    assert found.data_check.fatal
    assert re.search(words, said)
    grades = [grade for dof in found for grade in found.tables[dof].scores.get("grade", ())]
    assert set(grades) <= {"weak"}
    if name != "one_force":
        assert not grades
        assert "nothing_found" in about


def test_a_record_too_short_for_its_resonances_leaves_nothing_sure():
    columns = {"rows": [30], "spread": [1e-4], "dominance": [1.0], "how": "chain"}
    table = ResponseTable.of_sweep([10.0], [0.01], **columns).with_scores(grade=np.array(["sure"]))
    short = ar.Finding("record_length", "fatal", (), 0.5, 2.0, "It is too short.", "Record for longer.")
    for finding, grade in ((short, "weak"), (replace(short, severity="warning"), "sure")):
        checked = ar.DataCheck((finding,), {}, (0, 1), 0, BAND)
        assert with_second(table, checked).scores["grade"].tolist() == [grade]
    assert "record too short" in doubts_of(with_second(table, ar.DataCheck((short,), {}, (0, 1), 0, BAND)))[0]


def test_an_ambient_record_is_not_of_one_force():
    chains = (structures.random_chain(1, k) for k in range(8))
    x = sum(one.record(noise=0.01, seed=10 + k, duration_s=30.0).responses for k, one in enumerate(chains))
    found, _, about = identified(ar.Recording(x, structures.FS_HZ))
    assert "one_force" in about
    assert {grade for dof in found for grade in found.tables[dof].scores["grade"]} <= {"weak"}
    assert "second force or noise" in str(found)


@pytest.mark.parametrize("kind", ["hit", "random"])
def test_a_channel_in_noise_has_no_values(kind):
    one = structures.random_chain(1)
    shaken = kind == "random"
    x = one.record(noise=0.01, seed=1, duration_s=60.0).responses if shaken else nothing_to_find.hit(one, 1)
    whole, _, _ = identified(ar.Recording(x, structures.FS_HZ))
    noise = 3e-3 * np.abs(x).max() * np.random.default_rng(2).standard_normal(x.shape[1])
    found, said, about = identified(ar.Recording(np.vstack([x, noise]), structures.FS_HZ))
    assert "dead_channel" in about
    assert "Dof 8 holds only noise" in said
    assert found[8].size == 0
    assert all(np.abs(found[dof] / value - 1.0).min() < 0.01 for dof in whole for value in whole[dof])
    assert sum(map(len, found.values())) <= sum(map(len, whole.values())) + 1


def test_a_channel_of_few_steps_is_told():
    x = structures.random_chain(1).record(noise=0.01, seed=1, duration_s=30.0).responses.copy()
    step = np.ptp(x[3]) / 16
    x[3] = step * np.round(x[3] / step)
    (told,) = ar.check_data(ar.Recording(x, structures.FS_HZ), band_hz=BAND).named("quantized_channel")
    assert told.where == (3,)
    assert told.severity == "warning"
    assert told.value in (15.0, 16.0)


def test_what_all_responses_share_is_left_out_with_its_reason():
    f = np.linspace(1.0, 20.0, 400)
    noise = 1e-3 * np.random.default_rng(1).standard_normal(400)
    poles = ((5.0,), (5.0, 12.0), (5.0,))
    curves = [sum(p**2 / (p**2 - f**2 + 0.02j * p * f) for p in own) + noise for own in poles]
    found = without_common({i: ar.stabilization(f, one, max_order=20) for i, one in enumerate(curves)})
    assert [one.identified.round(1).tolist() for one in found.values()] == [[], [12.0], []]
    for one in found.values():
        assert one.left_out.freq_hz.round(1).tolist() == [5.0]
        assert one.left_out.scores["why"].tolist() == ["all responses share it"]

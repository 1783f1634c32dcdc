"""Several records, or several impacts, of one test: one set of antiresonances with honest errors."""

import re
from functools import cache

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

import antires_rs as ar
from reference.matching import match
from reference.measured import as_transmissibilities
from reference.virtual_records import hit_record, random_record, true_antiresonances
from tests.support.campaign import some_of
from tests.support.checked_records import BAND, FS, MASS, STIFFNESS, TRUTH
from tests.support.refusals import refused, unsuitable


@cache
def impact(seed, shift=0.0):
    moved = (1 + shift) ** 2 * STIFFNESS
    return ar.Recording(hit_record(moved, MASS, seed=seed, duration_s=16.0, noise=0.01)[0], FS)


@cache
def shaken(seed, shift=0.0):
    moved = (1 + shift) ** 2 * STIFFNESS
    return ar.Recording(random_record(moved, MASS, seed=seed, duration_s=40.0, noise=0.01)[0], FS)


def identified(source, **options):
    return ar.identify_antiresonances(source, excitation=0, band_hz=BAND, **options)


def deviations(found):
    """Error over standard deviation of every value; and how many of the 28 were found, how many false."""
    scores, matched = [], [match(found[dof], TRUTH[dof]) for dof in range(8)]
    for dof, each in enumerate(matched):
        for value, true in each.pairs:
            scores.append((value - true) / found.std_hz[dof][found[dof].tolist().index(value)])
    return np.array(scores), sum(len(m.false) for m in matched)


@pytest.mark.parametrize("first", some_of([0, 100, 200]))
def test_impacts_in_files_of_their_own(first):
    scores, false = deviations(identified([impact(seed) for seed in range(first, first + 10)]))
    assert (scores.size, false) == (28, 0)
    assert 0.6 < np.sqrt(np.mean(scores**2)) < 1.6


def test_impacts_in_one_file_are_those_in_several():
    records = [impact(seed) for seed in range(5)]
    together = ar.Recording(np.concatenate([rec.responses for rec in records], axis=1), FS)
    one, several = identified(together), identified(records)
    for dof in several:
        assert one[dof].size == several[dof].size
        # The record is cut shortly before each impact and not where the files end; what is left of the last
        # impact is in the noise.
        assert np.all(np.abs(one[dof] - several[dof]) < 3 * several.std_hz[dof])
        assert np.all(one.std_hz[dof] < 3 * several.std_hz[dof])


@pytest.mark.parametrize("make", some_of([shaken, impact]))
def test_what_differs_from_record_to_record_is_in_the_errors(make):
    rng = np.random.default_rng(3)
    steady = identified([make(seed) for seed in range(6)])
    shifts = 3e-3 * rng.standard_normal(6)
    # The check takes it for a second force, and says that it may be this.
    moving = identified([make(seed, shift) for seed, shift in enumerate(shifts)], check="off")
    expected = np.std(shifts, ddof=1) / np.sqrt(6)
    for dof in (2, 3, 4):
        told = moving.std_hz[dof] / moving[dof]
        # Five degrees of freedom, and weights that are not those of a plain mean.
        assert np.all((told > 0.4 * expected) & (told < 2.0 * expected))
        assert np.all(steady.std_hz[dof] / steady[dof] < 0.3 * expected)


def test_channels_may_stand_in_another_order():
    one, two = shaken(1), shaken(2)
    turned = ar.Recording(two.responses[::-1], FS, dofs=range(7, -1, -1))
    assert identified([one, turned]) == identified([one, two])


def test_the_data_check_looks_at_every_record_and_at_the_average():
    records = [impact(seed) for seed in range(10)]
    checked = ar.check_data(records, excitation=0, band_hz=BAND)
    assert checked.ok
    assert checked.n_averages == 10
    assert not checked.named("single_hit")
    wrong = ar.check_data(records, excitation=4, band_hz=BAND)
    assert [f.where for f in wrong.named("force_location")] == [(4,)] or wrong.fatal
    dead = np.array(records[3].responses)
    dead[5] = 0.25
    checked = ar.check_data([*records[:3], ar.Recording(dead, FS)], excitation=0, band_hz=BAND)
    (finding,) = checked.named("dead_channel")
    assert finding.where == (5,)
    assert "record 3 of 4" in finding.text


def test_records_that_do_not_belong_together_are_named():
    one = shaken(1)
    with pytest.raises(ar.InvalidInputError, match=r"^source\[1\]: got a sampling rate of 256"):
        identified([one, ar.Recording(one.responses, 256.0)])
    with pytest.raises(ar.InvalidInputError, match=r"^source\[2\]: got a record of dofs.*merge_setups"):
        identified([one, one, ar.Recording(one.responses[:5], FS)])
    again = "got the numbers of measurement 0, counted from 0"
    refused("^source: got an empty list", identified, [])
    refused(
        r"^source\[2\]: got the numbers of measurement 0, counted from 0", identified, [one, shaken(2), one]
    )
    with pytest.raises(ar.InvalidInputError, match=r"^source\[1\]: got FrequencyResponse"):
        identified([one, ar.transmissibility(one, 0, nperseg=2048)])
    unsuitable(r"2 decay.*record 2, counted from 0\)", identified, [impact(0), impact(1), one])
    ratios = ar.transmissibility(one, 2, nperseg=4096)
    other = ar.FrequencyResponse(ratios.freq_hz + 0.01, ratios.values, ratios.dofs, ratios.kind, 2)
    refused(r"^source\[1\].*lines of the first", identified, [ratios, other])
    refused(rf"^source\[1\]: {again}", identified, [ratios, ratios])


# ---- Curves of several tests: what moves a whole curve from test to test is in the errors
SPRINGS = 5e4 * np.array([1.0, 0.8, 1.3, 0.9, 1.2, 0.7])
SENSORS, ETA, WIDE, TESTS = (0, 1, 3, 5), 0.02, (8.0, 60.0), 6


def free_chain(springs):
    """Stiffness of a free chain of masses of 1 kg."""
    n = len(springs) + 1
    stiffness = np.zeros((n, n))
    for i, spring in enumerate(springs):
        stiffness[i : i + 2, i : i + 2] += spring * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return stiffness


def of_one_test(shift, rng, *, noise=0.005, each=0.0):
    springs = varied(shift, each, rng)
    freq = np.arange(5.0, 75.0, 0.1)
    dynamic = free_chain(springs) * (1.0 + 1j * ETA) - ((2 * np.pi * freq) ** 2)[:, None, None] * np.eye(7)
    column = np.linalg.inv(dynamic)[:, SENSORS, 0].T
    rough = rng.standard_normal(column.shape) + 1j * rng.standard_normal(column.shape)
    size = np.sqrt(np.mean(np.abs(column) ** 2, axis=1, keepdims=True) / 2)
    return ar.FrequencyResponse(freq, column + noise * size * rough, dofs=SENSORS)


def of_list(tests, kind="frf"):
    source = tests if kind == "frf" else [as_transmissibilities(one, 3) for one in tests]
    return ar.identify_antiresonances(source, excitation=0, band_hz=WIDE, check="off")


def truth(dof, springs=SPRINGS):
    zeros = true_antiresonances(free_chain(springs), np.eye(7), dof, 0) * np.sqrt(abs(1.0 + 1j * ETA))
    return zeros[(zeros > WIDE[0]) & (zeros < WIDE[1])]


def varied(shift, each, rng):
    """Springs of one test: all frequencies moved by ``shift``, every spring changed by itself."""
    return SPRINGS * (1.0 + shift) ** 2 * (1.0 + each * rng.standard_normal(SPRINGS.size))


def scatter(dof, shift, each):
    """Relative scatter of the mean of the tests by what differs between them alone, from 300 structures."""
    rng = np.random.default_rng(0)
    every = [truth(dof, varied(shift * rng.standard_normal(), each, rng)) for _ in range(300)]
    return np.std(np.array(every), axis=0) / truth(dof) / np.sqrt(TESTS)


@pytest.mark.parametrize(
    ("kind", "first"), some_of([(k, n) for n in (400, 500) for k in ("frf", "transmissibility")])
)
def test_intervals_cover_what_other_tests_would_give(kind, first):
    between = {dof: scatter(dof, 2e-3, 5e-3) for dof in SENSORS}
    # Nothing was set on these seeds. On seeds 300 to 311 the intervals of FRFs cover 90 %; without the
    # scatter between tests it was 78 %.
    scores, stated = [], []
    for seed in range(first, first + 4):
        rng = np.random.default_rng(seed)
        tests = [of_one_test(2e-3 * rng.standard_normal(), rng, each=5e-3) for _ in range(TESTS)]
        found = of_list(tests, kind)
        for dof in SENSORS:
            assert np.all(found.scores[dof]["averages"] == TESTS - 1 + 8)
            for value, std in zip(found[dof], found.std_hz[dof], strict=True):
                off = truth(dof) - value
                at = np.argmin(np.abs(off))
                scores.append(off[at] / std)
                stated.append(std / value / between[dof][at])
    assert len(scores) >= 36
    # 90 % of values on 5 + 8 degrees of freedom; all values of a list share its shifts, so that lists differ.
    assert np.mean(np.abs(scores) < 1.77) >= 0.8
    assert 0.7 < np.median(stated) < 1.7


# -- Records that are not of one test


def differing(records):
    found = ar.check_data(records, excitation=0, band_hz=BAND).named("records_differ")
    assert {one.severity for one in found} <= {"fatal"}
    return [one.text for one in found]


def changed(rec, rows=range(8), signs=1.0):
    return ar.Recording(np.array(signs).reshape(-1, 1) * rec.responses[list(rows)], rec.fs_hz)


@pytest.mark.parametrize("record", [impact, shaken])
def test_channels_that_are_exchanged_in_one_record_are_named(record):
    first, second, third, last = (record(seed) for seed in range(4))
    assert not differing([first, second, third, last])
    (text,) = differing([first, second, third, changed(last, (0, 1, 3, 2, 4, 5, 6, 7))])
    assert text.startswith("Record 3: channels 2 and 3 look swapped ")
    (text,) = differing([first, changed(second, signs=[1, 1, 1, 1, 1, -1, 1, 1]), third, last])
    assert text.startswith("Record 1: channel 5 looks turned round ")
    (text,) = differing([changed(first, (1, 2, 0, 3, 4, 5, 6, 7)), second, third])
    assert text.startswith("Record 0: channels 0, 1 and 2 look exchanged ")
    # Of two records nothing tells which is right.
    (text,) = differing([first, changed(second, (7, 1, 2, 3, 4, 5, 6, 0))])
    assert text.startswith(
        ("Record 1 or record 0: channels 0 and 7 ", "Record 0 or record 1: channels 0 and 7 ")
    )


@pytest.mark.parametrize("noise", [0.01, 0.1])
def test_hits_at_two_places_are_not_one_test(noise):
    def hits(place, seeds):
        options = {"duration_s": 16.0, "noise": noise, "excitation": place}
        return [ar.Recording(hit_record(STIFFNESS, MASS, seed=seed, **options)[0], FS) for seed in seeds]

    at_one = hits(0, range(3))
    assert not differing(at_one)
    for others in (hits(3, [7]), hits(3, [7, 8]), hits(6, [7, 8, 9])):
        (text,) = differing([*at_one, *others])
        numbers = ", ".join(map(str, range(3, 3 + len(others))))
        assert re.match(rf"Records 0, 1, 2 and records? {numbers} do not share one force place", text)
    with pytest.warns(ar.exceptions.AntiresWarning, match="do not share one force place"):
        found = identified([*at_one, *hits(3, [7, 8])])
    assert all(set(found.scores[dof]["doubt"]) == {"records differ"} for dof in found if len(found[dof]))


@pytest.mark.parametrize("shift", [0.0, 0.002, 0.01])
def test_a_structure_that_changes_a_little_is_one_test(shift):
    for record in (impact, shaken):
        assert not differing([record(40), record(41, shift), record(42, -shift)])


@pytest.mark.parametrize("seed", some_of([1, 2, 3]))
def test_a_louder_record_whose_noise_is_louder_too_is_one_test(seed):
    model, records = ar.cases.chain8().model, []
    for nth, (duration_s, size, band_hz) in enumerate(
        ((60.0, 1.0, 20.0), (20.0, 10.0, 40.0), (120.0, 1e-2, 99.0))
    ):
        rec = model.simulate(
            excitation=0, fs_hz=250.0, duration_s=duration_s, damping_ratio=0.01, rng=10 * seed + nth
        )
        sos = butter(2, band_hz, "highpass" if nth == 1 else "lowpass", fs=250.0, output="sos")
        x = size * sosfilt(sos, rec.responses)
        rng = np.random.default_rng([seed, nth])
        noise = 0.1 * x.std(axis=1, keepdims=True) * rng.standard_normal(x.shape)
        records.append(ar.Recording(x + noise, 250.0))
    assert not ar.check_data(records, excitation=0, band_hz=(3, 100), method="welch").named("records_differ")

"""What the data check names, what it lets pass, and what it says it cannot tell."""

from itertools import product

import numpy as np
import pytest

import antires_rs as ar
from reference.virtual_records import hit_record
from tests.support.campaign import some_of
from tests.support.checked_records import BAND, FS, MASS, STIFFNESS, changed, check, data, record, seen
from tests.support.refusals import assert_refused, each_of

# ---- no false alarm ----
GOOD = product((0.0, 0.01, 0.1), (0.005, 0.02), (60.0, 200.0))


@pytest.mark.parametrize(
    ("noise", "damping_ratio", "duration_s"),
    some_of(GOOD, [(0.1, 0.005, 60.0), (0.0, 0.02, 60.0), (0.01, 0.005, 200.0)]),
)
def test_good_records_pass(noise, damping_ratio, duration_s):
    responses, force = data(noise, 31, duration_s, damping_ratio=damping_ratio)
    result = check(ar.Recording(responses, FS, force=force if duration_s > 100.0 else None))
    assert result.ok, str(result)
    assert result.not_tested == {}
    for some in ([0, 3, 6], [0, 2, 4, 7], [1, 4, 6]):
        assert check(ar.Recording(responses[some], FS, dofs=some)).ok


def test_scale_sign_order_offset_and_digits_of_channels_do_not_matter(good):
    responses, force = good
    gains = np.array([1.0, 1e3, 1e-3, 5.0, -1.0, 20.0, 0.1, -7.0])[:, None]
    assert check(ar.Recording(gains * responses + 3.0, FS, force=force)).ok
    order = [3, 0, 7, 5, 1, 6, 2, 4]
    assert check(ar.Recording(responses[order], FS, dofs=order)).ok
    step = 10.0 * responses.std() / 2**9
    assert check(ar.Recording(step * np.round(responses / step), FS)).ok


# ---- one force ----
TWO = product((0.0, 0.01, 0.05), (0.1, 0.3, 1.0), (3, 7))


@pytest.mark.parametrize(
    ("noise", "relative", "other"), some_of(TWO, [(0.05, 0.1, 3), (0.01, 0.3, 7), (0.0, 1.0, 3)])
)
def test_a_second_force_is_named(noise, relative, other):
    first, second = data(noise, 43)[0], data(0.0, 44, excitation=other)[0]
    (finding,) = check(ar.Recording(first + relative * second, FS)).named("one_force")
    assert finding.severity == ("warning" if relative < 0.3 else "fatal")
    assert finding.value > finding.limit


def test_hits_on_two_points_tell_a_second_force_but_not_two_channels_or_few_averages(good):
    assert "two channels" in check(ar.Recording(good[0][[0, 5]], FS)).not_tested["one_force"]
    long = check(ar.Recording(good[0], FS), nperseg=32768)
    assert "independent averages" in long.not_tested["one_force"]
    assert [name for name, _ in seen(long)] == ["averages"]
    times = 0.5 + 8.0 * np.arange(6)
    options = {"duration_s": 48.5, "noise": 0.001}
    same, _ = hit_record(STIFFNESS, MASS, hit_times_s=tuple(times), seed=61, **options)
    assert check(ar.Recording(same, FS)).ok
    here, _ = hit_record(STIFFNESS, MASS, hit_times_s=tuple(times[::2]), seed=62, **options)
    there, _ = hit_record(STIFFNESS, MASS, excitation=4, hit_times_s=tuple(times[1::2]), seed=63, **options)
    assert check(ar.Recording(here + there, FS)).named("one_force")[0].severity == "fatal"


# ---- place of the force -----------------------------------------------------------------------------------
@pytest.mark.parametrize("with_force", [False, True])
@pytest.mark.parametrize(("noise", "seed"), some_of([(0.05, 55), (0.0, 54)]))
def test_every_wrong_place_is_named_and_the_right_one_suggested(with_force, noise, seed):
    rec = record(noise, seed, with_force=with_force)
    assert check(rec, 0).named("force_location") == ()
    for wrong in (1, 4, 7) if with_force else range(1, 8):
        (finding,) = check(rec, wrong).findings
        assert (finding.name, finding.severity, finding.where) == ("force_location", "fatal", (wrong,))
        assert finding.advice.startswith("Dof 0 ")


def test_a_force_in_the_middle_is_found_and_one_that_was_not_recorded_cannot_be_tested(good):
    result = check(ar.Recording(good[0][1:], FS, dofs=range(1, 8)), 0)
    assert "was not recorded" in result.not_tested["force_location"]
    unstated = ar.check_data(ar.Recording(good[0], FS), band_hz=BAND)
    assert "no excitation" in unstated.not_tested["force_location"]
    # The true place missing, a wrong one stated: nothing to suggest, so not fatal.
    (finding,) = check(ar.Recording(good[0][1:], FS, dofs=range(1, 8)), 5).findings
    assert finding.severity == "warning"
    assert "No recorded dof would fit" in finding.advice
    responses, _ = data(0.01, 56, excitation=3)
    for stated in range(8):
        assert bool(check(ar.Recording(responses, FS), stated).named("force_location")) == (stated != 3)


# ---- resolution and length --------------------------------------------------------------------------------
@pytest.mark.parametrize(("nperseg", "severity"), [(512, "fatal"), (1024, "warning"), (4096, None)])
def test_too_coarse_segments_are_named(good, nperseg, severity):
    result = check(ar.Recording(good[0], FS), nperseg=nperseg)
    assert [f.severity for f in result.named("resolution")] == [severity] * (severity is not None)
    assert len(seen(result)) == (severity is not None)
    if severity:
        assert result.findings[0].advice.endswith("or let nperseg=None choose.")


@pytest.mark.parametrize(
    ("duration_s", "severity"), [(2.0, "fatal"), (8.0, "fatal"), (20.0, "warning"), (60.0, None)]
)
def test_too_short_records_are_named(duration_s, severity):
    result = check(record(seed=59, duration_s=duration_s))
    assert [f.severity for f in result.named("record_length")] == [severity] * (severity is not None)
    assert result.ok == (severity is None)


# ---- hits -------------------------------------------------------------------------------------------------
def test_a_single_hit_says_what_it_cannot_tell_and_a_missed_one_is_named():
    responses, force = hit_record(STIFFNESS, MASS, noise=0.001, seed=60)
    result = check(ar.Recording(responses, FS, force=force))
    assert result.ok
    assert [f.name for f in result.findings] == ["single_hit"]
    assert {"one_force", "dead_channel"} <= set(result.not_tested)
    for rec in (ar.Recording(responses, FS, force=force), ar.Recording(responses, FS)):
        assert check(rec, 3).fatal
    responses, _ = hit_record(STIFFNESS, MASS, seed=64)
    result = check(ar.Recording(responses[:, 300:], FS), method="transient")
    assert result.fatal
    assert result.findings[0].name == "missed_hit"


# ---- what comes back --------------------------------------------------------------------------------------
def test_the_result_keeps_its_evidence_and_cannot_change():
    result = check(record(0.1, 67), nperseg=4096)
    n = result.freq_hz.size
    assert result.eigenvalues.shape == (n, 8)
    assert np.all(np.diff(result.eigenvalues, axis=1) <= 0.0)
    assert result.coherence.shape == (8, n)
    assert result.second_expected.shape == (n,)
    assert np.median(result.eigenvalues[:, 1] / result.second_expected) == pytest.approx(1.0, abs=0.1)
    assert result.nperseg == 4096
    assert 25 < result.n_averages < 31  # 31 segments that overlap by half
    assert (result.freq_hz[0], result.freq_hz[-1]) == BAND
    with pytest.raises(ValueError, match="read-only"):
        result.eigenvalues[0, 0] = 1.0
    with pytest.raises(AttributeError):
        result.findings = ()


def test_the_table_lists_the_worst_first_and_what_was_not_tested(good):
    findings = (
        ar.Finding("one_force", "fatal", (), 0.5, 0.1, "Seen.", "Stop it."),
        ar.Finding("signal_to_noise", "note", (3, "a"), 0.5, 0.1, "Under noise.", "Wait."),
    )
    result = ar.DataCheck(findings, {"dropouts": "a hit"}, (0, 1), 0, (3.0, 130.0), n_averages=12.34)
    assert str(result).splitlines() == [
        "data check, 3-130 Hz, 12.3 independent averages",
        "fatal    one_force: Seen. Stop it.",
        "note     signal_to_noise: Under noise. Wait.",
        "untested dropouts: a hit",
    ]
    assert repr(result) == "DataCheck(1 fatal, 0 warning, 1 note; 1 not tested)"
    assert result.warnings == ["one_force: Seen. Stop it."]
    assert result.fatal
    assert not result.ok
    assert "nothing found" in str(ar.DataCheck((), {}, (0,), None, (3.0, 130.0)))
    responses = good[0].copy()
    responses[4] = 0.0
    limit = 2.0 * responses[2].std()
    responses[2] = np.clip(responses[2], -limit, limit)
    assert seen(check(ar.Recording(responses, FS))) == [("dead_channel", (4,)), ("clipped_channel", (2,))]


WRONG = {"source": [np.zeros((2, 100))], "band_hz": [(3.0, 300.0)], "excitation": [1.5], "method": ["burst"]}
WRONG |= {"nperseg": [10**7], "window": ["bell"]}


@pytest.mark.parametrize(("argument", "value"), each_of(WRONG))
def test_bad_arguments_are_named(good, argument, value):
    given = {"source": ar.Recording(good[0], FS), "band_hz": BAND} | {argument: value}
    assert_refused(argument, ar.check_data, **given)


# ---- Channels that are dead, clipped, doubled, torn, late or of another quantity
def test_a_dead_channel_is_named(good):
    result = check(changed(good, 4, np.zeros_like))
    assert seen(result) == [("dead_channel", (4,))]
    assert result.fatal
    assert result.dofs == (0, 1, 2, 3, 5, 6, 7)
    rng = np.random.default_rng(57)
    for level in (1.0, 1e-4):
        result = check(changed(good, 4, lambda x, level=level: level * rng.standard_normal(x.size)))
        assert seen(result) == [("dead_channel", (4,))]
        assert "only noise" in result.findings[0].text
    still = ar.check_data(ar.Recording(np.ones((2, 4096)), FS), band_hz=BAND)
    assert seen(still) == [("dead_channel", (0, 1))]


@pytest.mark.parametrize(("low", "high"), [(-2.5, 2.5), (-9.0, 2.0), (-3.2, 9.0)])
def test_a_clipped_channel_is_named(good, low, high):
    def adc(x):
        step = x.std() / 2**6
        return step * np.clip(np.round(x / step), -(2**7), 2**7)

    assert seen(check(changed(good, 2, adc))) == [("clipped_channel", (2,))]  # also with coarse digits
    result = check(changed(good, 2, lambda x: np.clip(x, low * x.std(), high * x.std())))
    assert seen(result) == [("clipped_channel", (2,))]
    x = good[0][2]
    beyond = np.mean((x < low * x.std()) | (x > high * x.std()))
    # The pile holds what was beyond, and the few samples just below.
    assert beyond <= result.findings[0].value <= 1.3 * beyond


def test_doubled_integrated_late_and_noisy_channels_are_named(good):
    responses = good[0].copy()
    responses[6] = -2.0 * responses[1]
    result = check(ar.Recording(responses, FS))
    assert seen(result) == [("duplicated_channels", (1, 6))]
    assert "-2" in result.findings[0].text

    def integral(f):
        return (f > 1) / (2j * np.pi * np.maximum(f, 1))

    result = check(changed(good, 4, lambda x: filtered(x, integral)))
    assert seen(result) == [("quadrature", (4,))]
    assert check(changed(good, 4, np.negative)).ok  # polarity cannot be seen
    late = filtered(good[0][5], lambda f: np.exp(-2j * np.pi * f * 2 / FS))
    assert seen(check(ar.Recording([good[0][0], late], FS))) == [("time_shift", (0, 1))]
    rng = np.random.default_rng(58)
    result = check(changed(good, 5, lambda x: x + 0.5 * x.std() * rng.standard_normal(x.size)))
    assert result.ok
    assert [(f.severity, f.where) for f in result.named("signal_to_noise")] == [("note", (5,))]


def test_dropouts_and_spikes_are_named(good):
    def dropout(x):
        x[5000:5060] = x[5000]
        return x

    def spike(x):
        x[5000] += 30.0 * x.std()
        return x

    assert seen(check(changed(good, 3, dropout))) == [("dropouts", (3,))]
    assert seen(check(changed(good, 3, spike))) == [("spikes", (3,))]


def filtered(x, response):
    return np.fft.irfft(np.fft.rfft(x) * response(np.fft.rfftfreq(x.size, 1.0 / FS)), x.size)


@pytest.mark.parametrize("delay_samples", [1.0, -1.0, 30.0])
def test_a_late_channel_is_named_with_its_delay(good, delay_samples):
    turn = -2j * np.pi * delay_samples / FS
    result = check(changed(good, 4, lambda x: filtered(x, lambda f: np.exp(turn * f))))
    assert seen(result) == [("time_shift", (4,))]
    assert result.findings[0].value * FS == pytest.approx(delay_samples, abs=0.1)


@pytest.mark.parametrize("band", [(30, 40), (50, 60), (40, 60)])
def test_an_antiresonance_in_a_narrow_band_is_no_delay(good, band):
    result = ar.check_data(ar.Recording(good[0], FS), excitation=0, band_hz=band)
    assert not result.named("time_shift") + result.named("quadrature")

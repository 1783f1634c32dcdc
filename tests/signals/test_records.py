"""What the data check names, what it lets pass, and what it says it cannot tell."""

import numpy as np
import pytest

from antires_rs.exceptions import InvalidInputError
from antires_rs.signals.channel_checks import of_segments
from antires_rs.signals.data_check import check_data
from antires_rs.signals.one_force import DataCheck, Finding, noise_ratio
from antires_rs.signals.recording import Recording
from antires_rs.signals.spectra import cross_spectra, noise_power
from reference.virtual_records import hit_record
from tests.support.campaign import some_of
from tests.support.checked_records import BAND, FS, MASS, STIFFNESS, check, data, record, seen

# ---- no false alarm ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("noise", "damping_ratio", "duration_s", "seed"),
    [
        (0.0, 0.005, 60.0, 31),
        (0.0, 0.01, 200.0, 32),
        (0.0, 0.02, 60.0, 33),
        (0.01, 0.005, 200.0, 34),
        (0.01, 0.01, 60.0, 35),
        (0.01, 0.02, 200.0, 36),
        (0.05, 0.005, 60.0, 37),
        (0.05, 0.01, 200.0, 38),
        (0.05, 0.02, 60.0, 39),
        (0.1, 0.005, 200.0, 40),
        (0.1, 0.01, 60.0, 41),
        (0.1, 0.02, 200.0, 42),
    ],
)
def test_good_records_pass(noise, damping_ratio, duration_s, seed):
    responses, force = data(noise, seed, duration_s, damping_ratio=damping_ratio)
    result = check(Recording(responses, FS, force=force if seed % 2 else None))
    assert result.ok, str(result)
    assert result.not_tested == {}
    for some in ([0, 3, 6], [0, 2, 4, 7], [1, 4, 6]):
        assert check(Recording(responses[some], FS, dofs=some)).ok


def test_scale_sign_order_offset_and_digits_of_channels_do_not_matter(good):
    responses, force = good
    gains = np.array([1.0, 1e3, 1e-3, 5.0, -1.0, 20.0, 0.1, -7.0])[:, None]
    assert check(Recording(gains * responses + 3.0, FS, force=force)).ok
    order = [3, 0, 7, 5, 1, 6, 2, 4]
    assert check(Recording(responses[order], FS, dofs=order)).ok
    step = 10.0 * responses.std() / 2**9
    assert check(Recording(step * np.round(responses / step), FS)).ok


# ---- one force --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("noise", [0.0, 0.01, 0.05])
@pytest.mark.parametrize(("relative", "severity"), [(0.1, "warning"), (0.3, "fatal"), (1.0, "fatal")])
def test_a_second_force_is_named(noise, relative, severity):
    for other in (3, 7):
        first, _ = data(noise, 43)
        second, _ = data(0.0, 44, excitation=other)
        result = check(Recording(first + relative * second, FS))
        (finding,) = result.named("one_force")
        assert finding.severity == severity
        assert finding.value > finding.limit


def test_two_channels_and_few_averages_do_not_tell_a_second_force(good):
    assert "two channels" in check(Recording(good[0][[0, 5]], FS)).not_tested["one_force"]
    long = check(Recording(good[0], FS), nperseg=32768)
    assert "independent averages" in long.not_tested["one_force"]
    assert [name for name, _ in seen(long)] == ["averages"]


@pytest.mark.parametrize(("n", "averages"), [(4, 12), (8, 14), (8, 40), (5, 200)])
def test_the_second_eigenvalue_of_noise_is_as_expected(n, averages):
    rng = np.random.default_rng(50)
    shape = (3000, n, averages)
    segments = rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
    segments[:, 0] *= 1e3  # one strong signal in the first channel
    values = np.linalg.eigvalsh(segments @ segments.conj().transpose(0, 2, 1) / averages)[:, ::-1]
    got = values[:, 1].mean() / values[:, 2:].mean()
    # The law is asymptotic and 8 % low for 4 channels and 12 averages; lines count from twice its value on.
    assert noise_ratio(n, averages) == pytest.approx(got, rel=0.1)


def test_noise_of_channels_is_found_whatever_the_number_of_forces():
    levels = np.array([0.02, 0.05, 0.02, 0.1, 0.02, 0.03, 0.02, 0.02])
    for forces in (1, 2):
        rng = np.random.default_rng(51)
        clean, _ = data(0.0, 52)
        if forces == 2:
            clean = clean + 0.5 * data(0.0, 53, excitation=5)[0]
        rec = Recording(clean + levels[:, None] * rng.standard_normal(clean.shape), FS)
        spectra = cross_spectra(rec, nperseg=4096)
        inside = (spectra.freq_hz > 3) & (spectra.freq_hz < 130)
        got = noise_power(spectra.matrix[inside], spectra.n_effective)
        # White noise of unit variance has a one-sided density of 2 / fs. The median over lines and the little
        # that the others do not tell of a channel leave 25 %.
        np.testing.assert_allclose(got, levels**2 * 2 / FS, rtol=0.25)


# ---- place of the force -----------------------------------------------------------------------------------


@pytest.mark.parametrize("with_force", [False, True])
@pytest.mark.parametrize(("noise", "seed"), some_of([(0.05, 55), (0.0, 54)]))
def test_every_wrong_place_is_named_and_the_right_one_suggested(with_force, noise, seed):
    rec = record(noise, seed, with_force=with_force)
    assert check(rec, 0).named("force_location") == ()
    for wrong in range(1, 8):
        (finding,) = check(rec, wrong).findings
        assert (finding.name, finding.severity, finding.where) == ("force_location", "fatal", (wrong,))
        assert finding.advice.startswith("Dof 0 ")


def test_a_force_in_the_middle_is_found_there():
    responses, _ = data(0.01, 56, excitation=3)
    for stated in range(8):
        named = check(Recording(responses, FS), stated).named("force_location")
        assert bool(named) == (stated != 3)


def test_a_place_that_was_not_recorded_cannot_be_tested(good):
    result = check(Recording(good[0][1:], FS, dofs=range(1, 8)), 0)
    assert "was not recorded" in result.not_tested["force_location"]
    assert "no excitation" in check_data(Recording(good[0], FS), band_hz=BAND).not_tested["force_location"]
    # The true place missing, a wrong one stated: nothing to suggest, so not fatal.
    (finding,) = check(Recording(good[0][1:], FS, dofs=range(1, 8)), 5).findings
    assert finding.severity == "warning"
    assert "No recorded dof would fit" in finding.advice


# ---- resolution and length --------------------------------------------------------------------------------


@pytest.mark.parametrize(("nperseg", "severity"), [(512, "fatal"), (1024, "warning"), (4096, None)])
def test_too_coarse_segments_are_named(good, nperseg, severity):
    result = check(Recording(good[0], FS), nperseg=nperseg)
    assert [f.severity for f in result.named("resolution")] == [severity] * (severity is not None)
    assert len(seen(result)) == (severity is not None)
    if severity:
        assert result.findings[0].advice.endswith("or let nperseg=None choose.")


def test_who_left_the_choice_of_segments_is_not_told_to(good, monkeypatch):
    from antires_rs.signals import averaging

    monkeypatch.setattr(averaging, "choose_nperseg", lambda rec, band, correlation: 512)
    [finding] = check(Recording(good[0], FS)).named("resolution")
    assert finding.advice.startswith("Use longer segments, of ")
    assert "nperseg" not in finding.advice


@pytest.mark.parametrize(
    ("duration_s", "severity"), [(2.0, "fatal"), (8.0, "fatal"), (20.0, "warning"), (60.0, None)]
)
def test_too_short_records_are_named(duration_s, severity):
    result = check(record(seed=59, duration_s=duration_s))
    assert [f.severity for f in result.named("record_length")] == [severity] * (severity is not None)
    assert result.ok == (severity is None)


@pytest.mark.parametrize("duration_s", [100.0, 82.0, 50.0])
def test_no_one_is_told_to_record_less(duration_s):
    """Segments are powers of two, so that a record may be too short which is long enough by the count."""
    [short] = of_segments(0.244, 0.125, duration_s, longer=False, chosen=True, known=True)
    assert short.advice == (
        "Record 82 s, better 660 s." if duration_s < 81.0 else "Record for longer, at best 660 s."
    )


# ---- hits -------------------------------------------------------------------------------------------------


def test_a_single_hit_says_what_it_cannot_tell():
    responses, force = hit_record(STIFFNESS, MASS, noise=0.001, seed=60)
    result = check(Recording(responses, FS, force=force))
    assert result.ok
    assert [f.name for f in result.findings] == ["single_hit"]
    assert {"one_force", "dead_channel"} <= set(result.not_tested)
    # The place of the force needs no averages.
    for rec in (Recording(responses, FS, force=force), Recording(responses, FS)):
        assert check(rec, 3).fatal


def test_hits_on_one_point_are_one_force_and_on_two_are_not():
    times = 0.5 + 8.0 * np.arange(6)
    options = {"duration_s": 48.5, "noise": 0.001}
    same, _ = hit_record(STIFFNESS, MASS, hit_times_s=tuple(times), seed=61, **options)
    assert check(Recording(same, FS)).ok
    here, _ = hit_record(STIFFNESS, MASS, hit_times_s=tuple(times[::2]), seed=62, **options)
    there, _ = hit_record(STIFFNESS, MASS, excitation=4, hit_times_s=tuple(times[1::2]), seed=63, **options)
    assert check(Recording(here + there, FS)).named("one_force")[0].severity == "fatal"


def test_a_record_that_starts_after_its_hit_is_named():
    responses, _ = hit_record(STIFFNESS, MASS, seed=64)
    result = check(Recording(responses[:, 300:], FS), method="transient")
    assert result.fatal
    assert result.findings[0].name == "missed_hit"


# ---- what comes back --------------------------------------------------------------------------------------


def test_the_result_keeps_its_evidence_and_cannot_change():
    # With 10 % of noise leakage does not show in the second eigenvalue.
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


def test_the_table_lists_the_worst_first_and_what_was_not_tested():
    findings = (
        Finding("one_force", "fatal", (), 0.5, 0.1, "Seen.", "Stop it."),
        Finding("signal_to_noise", "note", (3, "a"), 0.5, 0.1, "Under noise.", "Wait."),
    )
    result = DataCheck(findings, {"dropouts": "a hit"}, (0, 1), 0, (3.0, 130.0), n_averages=12.34)
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
    assert "nothing found" in str(DataCheck((), {}, (0,), None, (3.0, 130.0)))


def test_several_faults_are_ordered_by_severity(good):
    responses = good[0].copy()
    responses[4] = 0.0
    limit = 2.0 * responses[2].std()
    responses[2] = np.clip(responses[2], -limit, limit)
    result = check(Recording(responses, FS))
    assert seen(result) == [("dead_channel", (4,)), ("clipped_channel", (2,))]


def test_the_same_data_give_the_same_findings(good):
    first, again = (check(Recording(good[0], FS)) for _ in range(2))
    assert np.array_equal(first.eigenvalues, again.eigenvalues)
    assert first.findings == again.findings


@pytest.mark.parametrize(
    ("kwargs", "name"),
    [
        ({"source": np.zeros((2, 100))}, "source"),
        ({"band_hz": (3.0, 300.0)}, "band_hz"),
        ({"excitation": 1.5}, "excitation"),
        ({"method": "burst"}, "method"),
        ({"nperseg": 10**7}, "nperseg"),
        ({"window": "bell"}, "window"),
    ],
)
def test_bad_arguments_are_named(good, kwargs, name):
    arguments = {"source": Recording(good[0], FS), "band_hz": BAND} | kwargs
    with pytest.raises(InvalidInputError) as caught:
        check_data(**arguments)
    assert str(caught.value).startswith(f"{name}: got ")

"""From records and responses to antiresonances: chain8, a measured frame, and what must be refused."""

import numpy as np
import pytest

from antires_rs import FitOptions
from antires_rs.exceptions import AntiresWarning, InvalidInputError, UnsuitableDataError
from antires_rs.identification.identify import identify_antiresonances
from antires_rs.identification.options import PRESETS, CallOptions, options_of
from antires_rs.signals.frequency_response import FrequencyResponse
from antires_rs.signals.recording import Recording
from antires_rs.signals.transfer_functions import frf, transmissibility
from reference.virtual_records import accelerance, chain8_matrices, random_record, true_antiresonances
from tests.support.campaign import some_of
from tests.support.measured_data import FLOORS, needs_southampton, southampton

STIFFNESS, MASS = chain8_matrices()
TRUTH = [true_antiresonances(STIFFNESS, MASS, dof, 0) for dof in range(8)]
BAND = (3.0, 130.0)
FS = 512.0


def record(noise=0.0, seed=0, duration_s=256.0, **kwargs):
    responses, force = random_record(STIFFNESS, MASS, noise=noise, seed=seed, duration_s=duration_s, **kwargs)
    return Recording(responses, FS, force=force)


def exact(damping=0.01, df=1 / 16):
    freq = np.arange(2.0, 140.0, df)
    return FrequencyResponse(freq, accelerance(STIFFNESS, MASS, 0, freq, damping))


def assert_all(found, rel):
    """28 of 28, none more, each within ``rel``."""
    assert [found[dof].size for dof in found] == [7, 6, 5, 4, 3, 2, 1, 0]
    for dof in found:
        assert np.allclose(found[dof], TRUTH[dof], rtol=rel, atol=0)


@pytest.mark.parametrize("seed", some_of([0, 1, 2]))
def test_chain8_clean_by_both_routes(seed):
    rec = record(seed=seed)
    by_responses = identify_antiresonances(rec, excitation=0, band_hz=BAND)
    assert_all(by_responses, 1e-4)
    # The FRF route has no rank-one trick at the dips; the bar of the project is 0.5 %.
    by_force = identify_antiresonances(rec, excitation=0, band_hz=BAND, route="frf")
    assert_all(by_force, 5e-3)


@pytest.mark.parametrize("seed", some_of([3, 4]))
def test_chain8_with_one_percent_noise(seed):
    # Measured over 10 seeds: largest error 5e-4.
    assert_all(identify_antiresonances(record(0.01, seed), excitation=0, band_hz=BAND), 2e-3)


def test_the_force_is_never_read():
    rec = record(0.01, 5, 64.0)
    without = Recording(rec.responses, FS)
    assert identify_antiresonances(rec, excitation=0, band_hz=BAND) == identify_antiresonances(
        without, excitation=0, band_hz=BAND
    )
    with pytest.raises(UnsuitableDataError, match="needs none"):
        identify_antiresonances(without, excitation=0, band_hz=BAND, route="frf")


def test_an_unrecorded_excitation_needs_no_channel():
    rec = record(0.0, 6)
    some = Recording(rec.responses[[1, 3, 6]], FS, dofs=["b", "d", "g"])
    found = identify_antiresonances(some, excitation="a", band_hz=BAND)
    assert found.excitation == "a"
    for dof, row in (("b", 1), ("d", 3), ("g", 6)):
        assert np.allclose(found[dof], TRUTH[row], rtol=1e-3)


def test_one_set_of_transmissibilities_serves_all_dofs():
    resp = exact()
    first = identify_antiresonances(resp, excitation=0, band_hz=BAND)
    assert_all(first, 1e-3)  # the damped zero's abs(s) differs from the undamped root by about zeta**2
    for reference in (0, 7):
        quotients = FrequencyResponse(
            resp.freq_hz, resp.values / resp.values[reference], kind="transmissibility", reference=reference
        )
        found = identify_antiresonances(quotients, excitation=0, band_hz=BAND)
        assert_all(found, 1e-3)


@pytest.mark.parametrize("estimator", some_of(["h1", "h2", "hv"]))
def test_other_estimators_work_on_clean_records(estimator):
    found = identify_antiresonances(record(seed=7), excitation=0, band_hz=BAND, estimator=estimator)
    assert sum(found[dof].size for dof in found) >= 27


def test_responses_from_our_own_estimators_are_sources():
    rec = record(seed=8)
    assert_all(identify_antiresonances(frf(rec, nperseg=8192), excitation=0, band_hz=BAND), 5e-3)
    t = transmissibility(rec, 4, nperseg=8192, estimator="rank1")
    assert_all(identify_antiresonances(t, excitation=0, band_hz=BAND), 5e-3)


def test_a_selection_of_dofs_and_the_band_are_kept():
    found = identify_antiresonances(exact(), excitation=0, band_hz=(30.0, 100.0), dofs=[4, 2])
    assert list(found) == [4, 2]
    for dof in found:
        inside = TRUTH[dof][(TRUTH[dof] > 30) & (TRUTH[dof] < 100)]
        assert np.allclose(found[dof], inside, rtol=1e-3)
    assert found.diagrams[4].identified.tolist() == found[4].tolist()
    assert found.damping_ratio[4].shape == found[4].shape


def test_scale_and_order_of_channels_do_not_matter():
    rec = record(0.0, 10, 128.0)
    gains = np.array([1.0, 1e3, 1e-3, 5.0, -1.0, 20.0, 0.1, 1.0])[:, None]
    order = [3, 0, 7, 5, 1, 6, 2, 4]
    plain = identify_antiresonances(rec, excitation=0, band_hz=BAND)
    other = identify_antiresonances(
        Recording((gains * rec.responses)[order], FS, dofs=order), excitation=0, band_hz=BAND
    )
    for dof in plain:
        assert other[dof].size == plain[dof].size
        # Not bit for bit: the scales enter rounding, and ties between poles.
        assert np.allclose(other[dof], plain[dof], rtol=1e-4)


def test_a_time_scale_does_not_matter():
    # A structure 25 times as fast, sampled at 12.8 kHz: the default segments must follow.
    fast = Recording(record(seed=11).responses, 25 * FS)
    found = identify_antiresonances(fast, excitation=0, band_hz=(75.0, 3250.0))
    for dof in found:
        assert np.allclose(found[dof], 25 * TRUTH[dof], rtol=1e-3)


@pytest.mark.parametrize(
    ("kwargs", "name"),
    [
        ({"source": np.zeros((2, 100))}, "source"),
        ({"band_hz": (3.0, 300.0)}, "band_hz"),
        ({"band_hz": (50.0, 10.0)}, "band_hz"),
        ({"band_hz": (50.0, 50.2)}, "band_hz"),
        ({"band_hz": (np.nan, 10.0)}, "band_hz"),
        ({"route": "modal"}, "route"),
        ({"fit": FitOptions(method="burst")}, "method"),
        ({"estimator": "h4"}, "estimator"),
        ({"dofs": [0, 11]}, "dofs"),
        ({"dofs": []}, "dofs"),
        ({"dofs": 3}, "dofs"),
        ({"excitation": None}, "excitation"),
        ({"excitation": 1.5}, "excitation"),
        ({"nperseg": 10**6}, "nperseg"),
        ({"max_order": 0}, "max_order"),
        ({"max_order": 8}, "max_order"),
        ({"fit": FitOptions(min_rows=-1)}, "min_rows"),
        ({"fit": FitOptions(window="bell")}, "window"),
    ],
)
def test_bad_arguments_are_named(kwargs, name):
    arguments = {"source": record(duration_s=40.0), "excitation": 0, "band_hz": BAND} | kwargs
    with pytest.raises(InvalidInputError) as caught:
        identify_antiresonances(**arguments)
    assert str(caught.value).startswith(f"{name}: got ")


def test_data_that_cannot_answer_are_refused():
    rec = record(duration_s=64.0)
    with pytest.raises(UnsuitableDataError, match="single channel"):
        identify_antiresonances(Recording(rec.responses[:1], FS), excitation=0, band_hz=BAND)
    dead = np.vstack([rec.responses[:2], np.zeros(rec.n_samples)])
    with pytest.raises(UnsuitableDataError, match="dof 2"):
        identify_antiresonances(Recording(dead, FS), excitation=0, band_hz=BAND)
    with pytest.raises(InvalidInputError, match="Transmissibilities do not hold"):
        identify_antiresonances(
            FrequencyResponse(
                exact().freq_hz, np.ones((2, exact().n_freq)), kind="transmissibility", reference=0
            ),
            excitation=0,
            band_hz=BAND,
            route="frf",
        )


def test_a_single_frf_has_zeros_on_the_frf_route():
    resp = exact()
    single = FrequencyResponse(resp.freq_hz, resp.values[3], dofs=[3])
    found = identify_antiresonances(single, excitation=0, band_hz=BAND, route="frf")
    assert np.allclose(found[3], TRUTH[3], rtol=1e-3)


# By column (excited floor) and floor: ranges of the reference, from a rational fit of each FRF by hand.
FRAME_ZEROS = {
    "Experimental.csv": [[(8.5, 8.9), (23.7, 24.1)], [(14.3, 14.65)], []],
    "test_2.csv": [[(14.3, 14.65)], [(14.8, 15.0), (19.6, 20.0)], [(19.3, 19.5)]],
    # The first: no zero of the three storeys, but a dip of 14 dB beside a fourth mode, at 28.9 Hz.
    "test_3.csv": [[(28.6, 28.9)], [(19.3, 19.5)], [(14.0, 14.4), (25.1, 25.5)]],
}


@needs_southampton
@pytest.mark.parametrize("name", FRAME_ZEROS)
def test_southampton_frame(name):
    found = identify_antiresonances(southampton(name), excitation=FLOORS.index(name), band_hz=(5.0, 32.0))
    for floor, ranges in enumerate(FRAME_ZEROS[name]):
        assert found[floor].size == len(ranges)
        for value, (low, high) in zip(found[floor], ranges, strict=True):
            assert low <= value <= high


def test_options_of_curves_are_named_for_records():
    with pytest.warns(
        AntiresWarning, match=r"min_share and min_depth_db have no effect on the sweep.*'numerators'"
    ):
        identify_antiresonances(
            record(duration_s=40.0),
            excitation=0,
            band_hz=BAND,
            check="off",
            fit=FitOptions(min_share=0.4, min_depth_db=2.0),
        )


@pytest.mark.parametrize("preset", [None, *PRESETS])
def test_what_is_given_wins(preset):
    held = FitOptions(min_rows=3, persistent=False).under(preset)
    assert (held.min_rows, held.persistent) == (3, False)
    assert held.damping_tol == FitOptions().under(preset).damping_tol
    assert held.given == {"min_rows", "persistent"}


@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset_is_a_set_of_options(preset):
    assert options_of(CallOptions(preset=preset), FitOptions()).rule == FitOptions().under(preset).checked()


def test_presets_cannot_be_changed_by_accident():
    with pytest.raises(TypeError):
        PRESETS["paper"]["min_rows"] = 1


def test_unknown_names_are_told():
    with pytest.raises(InvalidInputError, match="^preset: got 'loose'; wanted one of None, 'paper'"):
        options_of(CallOptions(preset="loose"), FitOptions())
    with pytest.raises(TypeError, match="rows"):
        FitOptions(rows=3)

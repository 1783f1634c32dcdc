"""From records and responses to antiresonances: chain8, a measured frame, and what must be refused."""

from functools import cache

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.identification.options import PRESETS, CallOptions, options_of
from reference.virtual_records import accelerance, random_record
from tests.support.campaign import some_of
from tests.support.checked_records import BAND, FS, MASS, STIFFNESS, TRUTH
from tests.support.measured_data import FLOORS, needs_southampton, southampton
from tests.support.refusals import assert_refused, each_of, refused, unsuitable


@cache
def record(noise=0.0, seed=0, duration_s=256.0):
    responses, force = random_record(STIFFNESS, MASS, noise=noise, seed=seed, duration_s=duration_s)
    return ar.Recording(responses, FS, force=force)


def zeros_of(source, **options):
    return ar.identify_antiresonances(source, **({"excitation": 0, "band_hz": BAND} | options))


@cache
def exact(damping=0.01, df=1 / 8):
    freq = np.arange(2.0, 140.0, df)
    return ar.FrequencyResponse(freq, accelerance(STIFFNESS, MASS, 0, freq, damping))


def assert_all(found, rel):
    assert [found[dof].size for dof in found] == [7, 6, 5, 4, 3, 2, 1, 0]
    for dof in found:
        assert np.allclose(found[dof], TRUTH[dof], rtol=rel, atol=0)


@pytest.mark.parametrize("seed", some_of([0, 1, 2]))
def test_chain8_by_both_routes(seed):
    assert_all(zeros_of(record(seed=seed)), 1e-4)
    # The FRF route has no rank-one trick at the dips; the bar of the project is 0.5 %.
    assert_all(zeros_of(record(seed=seed), route="frf"), 5e-3)
    assert_all(zeros_of(record(0.01, seed + 3)), 2e-3)


def test_the_force_is_never_read_and_its_place_needs_no_channel():
    rec = record(0.01, 5, 64.0)
    without = ar.Recording(rec.responses, FS)
    assert zeros_of(rec) == zeros_of(without)
    unsuitable("needs none", zeros_of, without, route="frf")
    found = zeros_of(ar.Recording(record().responses[[1, 3, 6]], FS, dofs=["b", "d", "g"]), excitation="a")
    assert found.excitation == "a"
    for dof, row in (("b", 1), ("d", 3), ("g", 6)):
        assert np.allclose(found[dof], TRUTH[row], rtol=1e-3)


def test_one_set_of_transmissibilities_serves_all_dofs_our_own_estimates_too():
    freq, values = exact().freq_hz, exact().values
    for reference in (0, 7):  # abs(s) of the damped zero differs from the undamped root by zeta**2
        quotients = {"kind": "transmissibility", "reference": reference}
        assert_all(zeros_of(ar.FrequencyResponse(freq, values / values[reference], **quotients)), 1e-3)
    assert_all(zeros_of(ar.frf(record(), nperseg=8192)), 5e-3)
    assert_all(zeros_of(ar.transmissibility(record(), 4, nperseg=8192, estimator="rank1")), 5e-3)


def test_a_selection_of_dofs_and_the_band_are_kept():
    found = zeros_of(exact(), band_hz=(30.0, 100.0), dofs=[4, 2])
    assert list(found) == [4, 2]
    for dof in found:
        assert np.allclose(found[dof], TRUTH[dof][(TRUTH[dof] > 30) & (TRUTH[dof] < 100)], rtol=1e-3)
    assert found.diagrams[4].identified.tolist() == found[4].tolist()
    assert found.damping_ratio[4].shape == found[4].shape
    single = ar.FrequencyResponse(exact().freq_hz, exact().values[3], dofs=[3])  # has zeros as an FRF
    assert np.allclose(zeros_of(single, route="frf")[3], TRUTH[3], rtol=1e-3)


def test_scale_and_order_of_channels_and_of_time_do_not_matter():
    rec = record(0.0, 10, 128.0)
    gains = np.array([1.0, 1e3, 1e-3, 5.0, -1.0, 20.0, 0.1, 1.0])[:, None]
    order = [3, 0, 7, 5, 1, 6, 2, 4]
    plain, other = zeros_of(rec), zeros_of(ar.Recording((gains * rec.responses)[order], FS, dofs=order))
    for dof in plain:
        assert other[dof].size == plain[dof].size
        # Not bit for bit: the scales enter rounding, and ties between poles.
        assert np.allclose(other[dof], plain[dof], rtol=1e-4)
    # A structure 25 times as fast, sampled at 12.8 kHz: the default segments must follow.
    fast = zeros_of(ar.Recording(rec.responses, 25 * FS), band_hz=(75.0, 3250.0))
    for dof in fast:
        assert np.allclose(fast[dof], 25 * TRUTH[dof], rtol=1e-3)


WRONG = {"source": [np.zeros((2, 100))]}
WRONG |= {"band_hz": [(3.0, 300.0), (50.0, 10.0), (50.0, 50.2), (np.nan, 10.0)], "route": ["modal"]}
WRONG |= {"estimator": ["h4"], "dofs": [[0, 11], [], 3], "excitation": [None, 1.5], "nperseg": [10**6]}
WRONG |= {"max_order": [0, 8]}
OF_FITS = {"method": "burst", "min_rows": -1, "window": "bell"}


@pytest.mark.parametrize(
    ("argument", "given"),
    [(name, {name: value}) for name, value in each_of(WRONG)]
    + [(name, {"fit": ar.FitOptions(**{name: value})}) for name, value in OF_FITS.items()],
)
def test_bad_arguments_are_named(argument, given):
    assert_refused(argument, zeros_of, **({"source": record(duration_s=40.0)} | given))


def test_data_that_cannot_answer_are_refused():
    rec = record(duration_s=40.0)
    unsuitable("single channel", zeros_of, ar.Recording(rec.responses[:1], FS))
    unsuitable("dof 2", zeros_of, ar.Recording(np.vstack([rec.responses[:2], np.zeros(rec.n_samples)]), FS))
    ones = np.ones((2, exact().n_freq))
    ratios = ar.FrequencyResponse(exact().freq_hz, ones, kind="transmissibility", reference=0)
    refused("Transmissibilities do not hold", zeros_of, ratios, route="frf")


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
    found = zeros_of(southampton(name), excitation=FLOORS.index(name), band_hz=(5.0, 32.0))
    for floor, ranges in enumerate(FRAME_ZEROS[name]):
        assert found[floor].size == len(ranges)
        for value, (low, high) in zip(found[floor], ranges, strict=True):
            assert low <= value <= high


def test_options_of_curves_are_named_for_records():
    said = r"min_depth_db and min_share have no effect on the sweep.*'numerators'"
    with pytest.warns(ar.AntiresWarning, match=said):
        zeros_of(record(duration_s=40.0), check="off", fit=ar.FitOptions(min_share=0.4, min_depth_db=2.0))


@pytest.mark.parametrize("preset", [None, *PRESETS])
def test_a_preset_is_a_set_of_options_over_which_what_is_given_wins(preset):
    held = ar.FitOptions(min_rows=3, persistent=False).under(preset)
    assert (held.min_rows, held.persistent) == (3, False)
    assert held.damping_tol == ar.FitOptions().under(preset).damping_tol
    assert held.given == {"min_rows", "persistent"}
    rule = options_of(CallOptions(preset=preset), ar.FitOptions()).rule
    assert rule == ar.FitOptions().under(preset).checked()


def test_unknown_names_are_told_and_presets_cannot_be_changed():
    with pytest.raises(ar.InvalidInputError, match="^preset: got 'loose'; wanted one of None, 'paper'"):
        options_of(CallOptions(preset="loose"), ar.FitOptions())
    with pytest.raises(TypeError, match="rows"):
        ar.FitOptions(rows=3)
    with pytest.raises(TypeError):
        PRESETS["paper"]["min_rows"] = 1

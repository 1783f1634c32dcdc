"""Resonances, damping and shapes, from FRFs and from responses alone."""

import numpy as np
import pytest
import scipy.linalg

import antires_rs as ar
from antires_rs.cases import exhaust
from antires_rs.cases.exhaust_truth import TestedStructure
from reference.virtual_records import accelerance, hit_record, random_record
from tests.support.checked_records import BAND, FS, MASS, STIFFNESS
from tests.support.measured_data import FLOORS, needs_southampton, southampton
from tests.support.refusals import assert_refused, each_of, unsuitable

LAMBDA, PHI = scipy.linalg.eigh(STIFFNESS, MASS)
TRUTH = ar.ModalSet(np.sqrt(LAMBDA[1:]) / (2 * np.pi), PHI[:, 1:].T)  # Without the rigid-body mode at 0 Hz.
FREQ = np.arange(3.0, 130.1, 1 / 16)


def record(noise=0.01, seed=13, duration_s=200.0):
    responses, force = random_record(STIFFNESS, MASS, noise=noise, seed=seed, duration_s=duration_s)
    return ar.Recording(responses, FS, force=force)


def assert_modes(found, freq_rel, damping_rel, mac=0.99, damping=0.01):
    assert len(found) == 7
    assert np.allclose(found.freq_hz, TRUTH.freq_hz, rtol=freq_rel, atol=0)
    assert np.allclose(found.damping_ratio, damping, rtol=damping_rel, atol=0)
    assert np.diag(found.mac(TRUTH)).min() > mac


@pytest.mark.parametrize("power", [0, 1, 2])
def test_exact_frfs_of_any_quantity(power):
    values = accelerance(STIFFNESS, MASS, 0, FREQ, 0.01) * (2j * np.pi * FREQ) ** (power - 2)
    found = ar.identify_modes(ar.FrequencyResponse(FREQ, values), band_hz=BAND)
    assert_modes(found, 1e-6, 1e-4, mac=1 - 1e-6)
    assert found.diagram.identified.tolist() == found.freq_hz.tolist()
    assert np.allclose(np.abs(found.shapes).max(axis=1), 1.0)
    none = ar.identify_modes(ar.FrequencyResponse(FREQ, values), band_hz=(5.0, 20.0))
    assert (len(none), none.shapes.shape, repr(none)) == (0, (0, 8), "ModalSet(0 modes x 8 dofs)")


def test_a_record_at_one_percent_noise_with_force_and_without():
    assert_modes(ar.identify_modes(record(), band_hz=BAND), 1e-4, 0.02, mac=0.9999)
    # Scatter about twice that which no method beats; four standard deviations of it.
    found = ar.identify_modes(record(seed=13, duration_s=400.0), band_hz=BAND, route="responses")
    assert len(found) == 7
    cycles = TRUTH.freq_hz * 400.0
    assert np.all(np.abs(found.freq_hz / TRUTH.freq_hz - 1.0) < 8 * np.sqrt(0.01 / (4 * np.pi * cycles)))
    assert np.all(np.abs(found.damping_ratio / 0.01 - 1.0) < 8 / np.sqrt(2 * np.pi * 0.01 * cycles))
    assert np.diag(found.mac(TRUTH)).min() > 0.99


def test_the_force_is_not_read_on_the_way_of_responses():
    rec = record(seed=15, duration_s=100.0)
    with_force = ar.identify_modes(rec, band_hz=BAND, route="responses")
    without = ar.identify_modes(ar.Recording(rec.responses, FS), band_hz=BAND)
    assert with_force.freq_hz.tolist() == without.freq_hz.tolist()
    assert with_force.shapes.tolist() == without.shapes.tolist()


@pytest.mark.parametrize("route", ["frf", "responses"])
def test_hammer_hits(route):
    responses, force = hit_record(STIFFNESS, MASS, duration_s=3.0, seed=13)  # still ringing at the end
    found = ar.identify_modes(ar.Recording(responses, FS, force=force), band_hz=BAND, route=route)
    assert_modes(found, 2e-4, 0.01, mac=0.999)


def test_a_selection_of_channels_and_their_labels():
    rec = record(0.0)
    some = ar.Recording(100.0 * rec.responses[[0, 3, 6]], FS, dofs=["a", "d", "g"], force=rec.force)
    found = ar.identify_modes(some, band_hz=(30.0, 100.0))
    inside = (TRUTH.freq_hz > 30) & (TRUTH.freq_hz < 100)
    assert np.allclose(found.freq_hz, TRUTH.freq_hz[inside], rtol=1e-4)
    assert found.dofs == ("a", "d", "g")
    few = ar.ModalSet(TRUTH.freq_hz[inside], TRUTH.shapes[inside][:, [0, 3, 6]], ["a", "d", "g"])
    assert np.diag(found.mac(few)).min() > 0.9999


def test_modes_just_outside_the_band_do_not_spoil_the_shapes():
    case, tested = exhaust(), TestedStructure(0)
    rec = case.experiment(0, duration_s=120.0, rng=0)
    inside = (tested.freq_hz > 8.0) & (tested.freq_hz < 260.0)
    true = ar.ModalSet(tested.freq_hz[inside], tested.shapes[inside][:, case.responses], case.responses)
    for route in ("frf", "responses"):
        found = ar.identify_modes(rec, band_hz=(8.0, 260.0), route=route)
        assert np.allclose(found.freq_hz, true.freq_hz, rtol=2e-3, atol=0)
        assert np.diag(found.mac(true)).min() > 0.998
    freq = np.arange(8.0, 260.1, 0.25)  # FRFs that end with the band leave nothing around it to fit.
    frfs = [tested.frf(dof, case.excitation, freq) for dof in case.responses]
    cut = ar.identify_modes(ar.FrequencyResponse(freq, frfs, case.responses), band_hz=(8.0, 260.0))
    assert np.allclose(cut.freq_hz, true.freq_hz, rtol=2e-3, atol=0)


def test_what_cannot_be_answered_is_refused():
    freq = np.arange(3.0, 130.1, 0.25)
    ratio = ar.FrequencyResponse(freq, np.ones((2, freq.size)), kind="transmissibility", reference=0)
    unsuitable("resonances cancel", ar.identify_modes, ratio, band_hz=BAND)
    rec = record(0.0, duration_s=64.0)
    unsuitable("broadband", ar.identify_modes, ar.Recording(rec.responses, FS), band_hz=BAND, route="frf")
    dead = np.vstack([rec.responses[:2], np.zeros(rec.n_samples)])
    for force in (None, rec.force):
        with pytest.raises(ar.UnsuitableDataError, match="dead channel|live channel"):
            ar.identify_modes(ar.Recording(dead, FS, force=force), band_hz=BAND)


REC = ar.Recording(np.random.default_rng(13).standard_normal((2, 8192)), FS)
FRF = ar.FrequencyResponse(np.linspace(1.0, 20.0, 400), np.ones((2, 400)))


OF_RECORDS = {"band_hz": [(3.0, 300.0), 5.0], "route": ["force"], "method": ["fast"], "estimator": ["rank1"]}
OF_RECORDS |= {"nperseg": [10000], "max_order": [10], "min_order": [0], "freq_tol": [-1.0]}


@pytest.mark.parametrize(
    ("source", "argument", "value"),
    [(REC, *each) for each in each_of(OF_RECORDS)]
    + [(FRF, "route", "responses"), (FRF, "band_hz", (5.0, 5.6)), (REC, "source", np.zeros((2, 100)))],
)
def test_bad_arguments_are_named(source, argument, value):
    assert_refused(argument, ar.identify_modes, **{"source": source, "band_hz": (3.0, 15.0), argument: value})


# ---- the modal set -----------------------------------------------------------------------------------
def test_mac_is_blind_to_complex_factors_and_to_real_takes_them_off():
    rng = np.random.default_rng(13)
    shapes = rng.standard_normal((3, 4)) + 1j * rng.standard_normal((3, 4))
    one = ar.ModalSet([1.0, 2.0, 3.0], shapes, dofs=["a", "b", "c", "d"])
    factors = np.array([[2j], [-1.0], [0.1 + 3j]])
    turned = ar.ModalSet([1.0, 2.0, 3.0], shapes[:, ::-1] * factors, dofs=["d", "c", "b", "a"])
    assert np.allclose(np.diag(one.mac(turned)), 1.0)
    assert np.allclose(one.mac(turned), turned.mac(one).T)
    fewer = ar.ModalSet([1.0], shapes[:1, 1:3], dofs=["b", "c"])
    assert fewer.mac(one).shape == (1, 3)
    assert fewer.mac(one)[0, 0] == pytest.approx(1.0)
    modes = ar.ModalSet([1.0, 2.0], [[2j, -4j], [1 + 1j, 1 + 1j]], damping_ratio=[0.01, 0.02]).to_real()
    assert np.allclose(modes.shapes, [[-2.0, 4.0], [2**0.5, 2**0.5]])
    assert modes.damping_ratio.tolist() == [0.01, 0.02]


@pytest.mark.parametrize(
    "other", [[1.0], ar.ModalSet([1.0], [[1.0]], dofs=["x"]), ar.ModalSet([1.0], [np.zeros(8)])], ids=str
)
def test_sets_that_cannot_be_compared_are_named(other):
    assert_refused("other", TRUTH.mac, other)


WRONG = {"shapes": [np.ones((1, 0)), [["a"]], [[np.nan]]], "damping_ratio": [[]], "freq_hz": [""]}


@pytest.mark.parametrize(("argument", "value"), each_of(WRONG))
def test_bad_sets_are_named(argument, value):
    usual = {"freq_hz": [1.0], "shapes": np.ones((0, 2)) if argument == "freq_hz" else [[1.0]]}
    assert_refused(argument, ar.ModalSet, **(usual | {argument: value}))


# ---- a measured structure ----------------------------------------------------------------------------
@needs_southampton
@pytest.mark.parametrize("name", FLOORS)
def test_southampton_frame(name):
    modes = ar.identify_modes(southampton(name), band_hz=(5.0, 32.0))
    # The three of the storeys; a weak one at 28.9 Hz, of the frame's own, is in all three tests.
    assert np.allclose(modes.freq_hz, [6.51, 17.46, 26.50, 28.92], rtol=2e-3)
    assert np.all((modes.damping_ratio[:3] > 0.0014) & (modes.damping_ratio[:3] < 0.0026))
    # Shapes of a three-storey shear frame have 0, 1 and 2 changes of sign.
    shapes = modes.to_real().shapes[:3]
    assert [int(np.sum(np.diff(np.sign(shape)) != 0)) for shape in shapes] == [0, 1, 2]

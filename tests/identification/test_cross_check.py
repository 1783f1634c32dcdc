"""The cross-check: its two methods on functions that are known, and its judgement on records."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.identification.cross_check import CONFIRMING_DOMINANCE, METHODS, cross_check, set_valued_aaa
from tests.support.refusals import assert_refused, each_of

CHAIN = ar.MassSpringChain(np.ones(4), [500.0, 450.0, 520.0])
BAND = (0.5, 9.0)


def rational(rng, freq, n_poles, n_outputs):
    """Curves with common poles, 1 % damped, spread over the band; and the poles."""
    at = np.linspace(freq[0], freq[-1], n_poles + 2)[1:-1]
    s = 2 * np.pi * at * (-0.01 + 1j * np.sqrt(1 - 1e-4))
    line = 2j * np.pi * freq
    residue = rng.standard_normal((n_outputs, n_poles)) + 1j * rng.standard_normal((n_outputs, n_poles))
    values = sum(
        residue[:, k, None] / (line - s[k]) + residue[:, k, None].conj() / (line - s[k].conj())
        for k in range(n_poles)
    )
    return values + rng.standard_normal((n_outputs, 1)), s


@pytest.fixture(scope="module")
def record():
    return CHAIN.simulate(excitation=0, fs_hz=25.0, duration_s=400.0, damping_ratio=0.01, noise=3e-3, rng=13)


@pytest.fixture(scope="module")
def truth():
    return dict(enumerate(CHAIN.antiresonances([0, 1, 2, 3], 0)))


@pytest.mark.parametrize("n_poles", [1, 4, 9])
@pytest.mark.parametrize("method", METHODS)
def test_exact_curves_give_back_their_poles(method, n_poles):
    freq = np.linspace(1.0, 40.0, 500)
    values, poles = rational(np.random.default_rng(14), freq, n_poles, 3)
    # AAA sees positive frequencies only and spends poles on the mirror images.
    most = 2 * n_poles + 2 if method == "aaa" else n_poles
    s, dominance = METHODS[method](freq, values, np.ones(500), most)
    off = np.abs(s[None, :] - poles[:, None]) / np.abs(poles)[:, None]
    assert off.min(axis=1).max() < 1e-8
    # Random residues make weak poles beside strong ones; even those own enough to confirm a value.
    assert np.all(dominance[off.argmin(axis=1)] > CONFIRMING_DOMINANCE)


def test_one_curve_with_equal_weights_is_scipys_aaa():
    interpolate = pytest.importorskip("scipy.interpolate")
    if not hasattr(interpolate, "AAA"):
        pytest.skip("scipy.interpolate.AAA came with SciPy 1.15")
    freq = np.linspace(1.0, 40.0, 300)
    rng = np.random.default_rng(16)
    values, _ = rational(rng, freq, 5, 1)
    values = values + 1e-3 * (rng.standard_normal(300) + 1j * rng.standard_normal(300))
    z = 1j * freq / freq[-1]
    with np.errstate(all="ignore"), pytest.warns(RuntimeWarning):  # noise: 9 supports do not reach its rtol
        theirs = interpolate.AAA(z, values[0], max_terms=9, rtol=1e-13, clean_up=False).poles()
    ours = set_valued_aaa(freq, values, np.ones(300), 8)[0] / (2 * np.pi * freq[-1])
    np.testing.assert_allclose(np.sort_complex(ours), np.sort_complex(theirs[theirs.imag > 0.0]), rtol=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_true_values_are_confirmed_and_others_are_flagged(record, truth, method):
    asked = {dof: np.sort(np.append(f, 3.0)) for dof, f in truth.items()}
    compared = cross_check(record, asked, band_hz=BAND, method=method)
    assert compared.flagged == [(dof, 3.0) for dof in truth]
    for dof, f in asked.items():
        np.testing.assert_allclose(compared.distance[dof], np.abs(compared.nearest_hz[dof] / f - 1.0))
        assert compared.is_confirmed(dof, 3.0) is False
    assert compared.is_confirmed(0, float(truth[0][0])) is True
    assert compared.is_confirmed(0, 1.234) is None
    assert compared.is_confirmed("no such dof", 1.234) is None


@pytest.mark.parametrize("method", METHODS)
def test_a_strong_antiresonance_that_is_missing_is_a_candidate(record, truth, method):
    fewer = {0: truth[0], 1: truth[1][1:], 2: truth[2], 3: truth[3]}
    compared = cross_check(record, fewer, band_hz=BAND, method=method)
    assert compared.candidates_hz[1][0] == pytest.approx(truth[1][0], rel=5e-3)
    assert compared.flagged == []
    complete = cross_check(record, truth, band_hz=BAND, method=method)
    others = complete.candidates_hz.values()
    assert not any(np.abs(f / truth[1][0] - 1.0).min(initial=1.0) < 0.02 for f in others)


def test_one_channel_goes_by_the_reciprocal_of_its_frf_and_has_no_quotient(record):
    freq = np.linspace(*BAND, 400)
    h = CHAIN.frf([0], 0, freq, damping_ratio=0.01)
    truth = CHAIN.antiresonances(0, 0)
    compared = cross_check(ar.FrequencyResponse(freq, h, [0]), {0: truth}, band_hz=BAND)
    assert compared.confirmed[0].all()
    alone = ar.Recording(record.responses[:1], record.fs_hz, [0])
    with pytest.raises(ar.UnsuitableDataError, match="single channel and no force"):
        cross_check(alone, {0: [1.0]}, band_hz=BAND)


def test_what_all_channels_share_is_no_candidate():
    freq = np.linspace(*BAND, 800)
    h = CHAIN.frf([0, 1, 2], 0, freq, damping_ratio=0.01)
    # A mode that the force hardly excites gives every response one zero beside one pole.
    shared = (6.0**2 - freq**2 + 0.12j * freq) / (6.3**2 - freq**2 + 0.126j * freq)
    source = ar.FrequencyResponse(freq, h * shared, [0, 1, 2])
    truth = dict(enumerate(CHAIN.antiresonances([0, 1, 2], 0)))
    for method in METHODS:
        compared = cross_check(source, truth, band_hz=BAND, method=method)
        assert not any(f.size for f in compared.candidates_hz.values())


def test_a_set_with_its_cross_check_says_so_in_the_table_and_in_words(record, truth):
    from antires_rs.io.data_frames import rows_of

    values = {dof: np.append(f, 3.0) for dof, f in truth.items()}
    compared = cross_check(record, values, band_hz=BAND)
    found = ar.AntiresonanceSet(0, values, cross_check=compared)
    assert found.second_opinion is found.cross_check is compared
    edited = found.add(3, 5.0)
    names, rows = rows_of(edited)
    assert names[-1] == "confirmed"
    said = {(r["dof"], r["freq_hz"]): r["confirmed"] for r in rows}
    assert said[0, float(truth[0][0])] is True
    assert said[0, 3.0] is False
    assert said[3, 5.0] is None  # added after the cross-check
    compared = cross_check(record, {0: [3.0], 1: truth[1]}, band_hz=BAND)
    lines = str(compared).splitlines()
    assert lines[0] == "cross-check by vector fitting: 2 of 3 values confirmed within 1 %"
    assert lines[1].startswith("  dof 0: 3.000 Hz not confirmed: its nearest pole is ")
    assert lines[2].startswith("  dof 0: candidates ")
    assert repr(compared).startswith("CrossCheck(method='vector_fitting', 2 of 3 values confirmed, ")


WRONG = {"method": ["guess"], "averaging": ["mean"], "tol": [0.0], "band_hz": [(5.0, 1.0)], "n_poles": [0]}
WRONG |= {"identified": [[1.0], {9: [1.0]}], "source": [3]}


@pytest.mark.parametrize(("argument", "value"), each_of(WRONG))
def test_bad_arguments_are_named(record, truth, argument, value):
    usual = {"source": record, "identified": truth, "band_hz": BAND}
    assert_refused(argument, cross_check, **(usual | {argument: value}))

"""Spectra against scipy, estimators against what is known of their bias."""

import tracemalloc
from functools import partial

import numpy as np
import pytest
import scipy.signal

import antires_rs as ar
from antires_rs.signals.averaging import choose_nperseg
from antires_rs.signals.spectra import cross_spectra, effective_averages, prominent_peaks
from reference.virtual_records import chain8_matrices, random_record
from tests.support.refusals import assert_refused, unsuitable
from tests.support.snapshots import refusals

RNG = np.random.default_rng(11)
WALK = RNG.standard_normal((3, 5000)).cumsum(axis=1) + 4.0
RECORD = ar.Recording(WALK, 200.0, force=RNG.standard_normal(5000))


@pytest.mark.parametrize("nperseg", [256, 301])
@pytest.mark.parametrize(("window", "noverlap"), [("hann", None), (("tukey", 0.3), 100)])
def test_spectra_are_those_of_scipy(nperseg, window, noverlap):
    ours = cross_spectra(RECORD, nperseg=nperseg, noverlap=noverlap, window=window, include_force=True)
    channels = np.vstack([RECORD.responses, RECORD.force])
    for a in range(4):
        for b in range(4):
            options = {"window": window, "nperseg": nperseg, "noverlap": noverlap}
            freq, theirs = scipy.signal.csd(channels[a], channels[b], 200.0, **options)
            assert np.array_equal(ours.freq_hz, freq)
            # Rounding of sums of some 40 segments; the means of a random walk cost digits at zero frequency.
            assert np.abs(ours.matrix[:, a, b] - theirs).max() <= 1e-12 * np.abs(theirs).max()


def noisy_pair(noise_in, noise_out):
    rng = np.random.default_rng(5)
    x = rng.standard_normal(200_000)
    measured = x + noise_in * rng.standard_normal(x.size)
    y = 3.0 * np.roll(x, 1) + 3.0 * noise_out * rng.standard_normal(x.size)  # one sample later
    rec = ar.Recording([y, measured], 100.0, force=measured)
    found = {e: ar.frf(rec, nperseg=256, estimator=e) for e in ("h1", "h2", "hv")}
    late = np.exp(-0.02j * np.pi * found["h1"].freq_hz[2:-2])
    return {e: np.mean(each.values[0, 2:-2] / late).real for e, each in found.items()}


def test_estimators_have_their_textbook_bias():
    # H1 is divided by 1 + noise-to-signal power of the input, H2 multiplied by that of the output.
    clean = noisy_pair(0.0, 0.5)
    assert clean["h1"] == pytest.approx(3.0, rel=5e-3)
    assert clean["h2"] == pytest.approx(3.0 * 1.25, rel=5e-3)
    loud = noisy_pair(0.5, 0.0)
    assert loud["h1"] == pytest.approx(3.0 / 1.25, rel=5e-3)
    assert loud["h2"] == pytest.approx(3.0, rel=5e-3)
    both = noisy_pair(0.5, 0.5)  # Equal relative noise on both sides: total least squares is unbiased.
    assert both["hv"] == pytest.approx(3.0, rel=5e-3)


def test_rank_one_keeps_the_peak_that_h1_flattens():
    stiffness, mass = chain8_matrices()
    clean, _ = random_record(stiffness, mass, seed=21)
    noisy, _ = random_record(stiffness, mass, seed=21, noise=0.02)
    truth = ar.transmissibility(ar.Recording(clean, 512.0), 3, nperseg=8192, estimator="rank1")
    line = int(np.argmin(np.abs(truth.freq_hz - 20.3235)))  # the lowest antiresonance of mass 3
    lines = slice(line - 2, line + 3)
    peak = np.abs(truth.values[7, lines]).max()
    h1 = np.abs(ar.transmissibility(ar.Recording(noisy, 512.0), 3, nperseg=8192).values[7, lines]).max()
    best = ar.transmissibility(ar.Recording(noisy, 512.0), 3, nperseg=8192, estimator="rank1")
    rank1 = np.abs(best.values[7, lines])
    assert h1 < 0.8 * peak
    assert abs(rank1.max() - peak) < abs(h1 - peak)


@pytest.mark.parametrize(
    ("window", "overlap"), [("hann", 0.5), ("hann", 0.75), ("hann", 0.0), ("boxcar", 0.5)]
)
def test_effective_averages_are_those_of_the_observed_scatter(window, overlap):
    nperseg = 64
    noverlap = round(overlap * nperseg)
    auto = []
    for seed in range(130, 155):
        rec = ar.Recording(np.random.default_rng(seed).standard_normal((16, 1024)), 1.0)
        spectra = cross_spectra(rec, nperseg=nperseg, noverlap=noverlap, window=window)
        auto.append(np.einsum("fii->fi", spectra.matrix).real[3:-3])
    auto = np.concatenate(auto, axis=1)
    # The relative variance of a mean of n independent exponentials is 1/n; 400 records of 27 lines leave it a
    # scatter of 2 %.
    observed = np.mean(auto.mean(axis=1) ** 2 / auto.var(axis=1))
    assert spectra.n_effective == pytest.approx(observed, rel=0.07)
    assert spectra.n_effective <= spectra.n_averages
    taper = scipy.signal.get_window(window, nperseg)
    assert spectra.n_effective == effective_averages(taper, nperseg - noverlap, spectra.n_averages)


def deviations(estimate, records=60):
    """Predicted and observed standard deviation of flat gains, root mean squares over lines and records."""
    gains, noise = np.array([1.0, 2.0, 0.5, 1.0])[:, None], 0.3
    predicted, values = [], []
    for seed in range(130, 130 + records):
        rng = np.random.default_rng(seed)
        force = rng.standard_normal(4096)
        x = gains * force + noise * rng.standard_normal((4, 4096))
        resp = estimate(ar.Recording(x, 100.0, force=force))
        predicted.append(resp.std[1:, 3:-3])
        values.append(resp.values[1:, 3:-3])
    values = np.array(values)
    error = np.abs(values - values.mean(axis=(0, 2), keepdims=True))
    return np.sqrt(np.mean(np.square(predicted), axis=(0, 2))), np.sqrt(0.5 * np.mean(error**2, axis=(0, 2)))


@pytest.mark.parametrize(
    ("estimate", "estimator"),
    [(ar.frf, one) for one in ("h1", "h2", "hv")]
    + [(partial(ar.transmissibility, reference=0), one) for one in ("h1", "h2", "hv", "rank1")],
)
def test_predicted_deviations_are_the_observed_ones(estimate, estimator):
    # 60 records of 58 lines, neighbours correlated: the observed deviation is good to about 2 %.
    predicted, observed = deviations(partial(estimate, nperseg=128, estimator=estimator))
    np.testing.assert_allclose(predicted, observed, rtol=0.04)


def test_a_single_average_has_no_deviation_and_the_sum_is_equation_10_as_printed():
    x = RNG.standard_normal((2, 1000))
    resp = ar.frf(ar.Recording(x, 100.0, force=x[0]), nperseg=1000)
    assert (resp.coherence, resp.std, resp.n_averages) == (None, None, 1.0)
    assert ar.transmissibility(ar.Recording(x, 100.0), 0, nperseg=1000, estimator="rank1").std is None
    values = [[1, 1], [1 - 2j, -3 + 1j], [-2 - 1j, 0.5j]]
    resp = ar.FrequencyResponse([1.0, 2.0], values, kind="transmissibility", reference=0)
    assert ar.transmissibility_sum(resp).tolist() == [3 + 3j, 3 + 1.5j]


DEAD = ar.Recording(np.vstack([RECORD.responses[:2], np.zeros(5000)]), 200.0)


def test_bad_arguments_are_named():
    refusals(__file__, "wrong_spectra.txt", globals())
    assert_refused(
        "window", cross_spectra, RECORD, nperseg=256, window="rectangle of mine"
    )  # in SciPy's words
    unsuitable("channel 2", ar.transmissibility, DEAD, 0, nperseg=256)


@pytest.mark.parametrize("digits", [0, 1, 6])
def test_the_peaks_are_those_of_scipy_also_on_flat_tops_and_among_equals(digits):
    from scipy.signal import find_peaks

    rng = np.random.default_rng(digits)
    for size in (*range(9), 50, 400):
        for _ in range(20):
            curve = np.round(rng.standard_normal(size).cumsum(), digits)
            for least in (0.0, 0.5, 1.0, 3.0):
                wanted = find_peaks(curve, prominence=least)[0]
                np.testing.assert_array_equal(prominent_peaks(curve, least), wanted)


# ---- Averages of a record are made once, and everything that follows looks at them
BAND = (3.0, 130.0)


@pytest.fixture(scope="module")
def record():
    return ar.cases.chain8().experiment(noise=0.01, duration_s=60.0, rng=7)


def test_the_check_within_an_identification_is_the_check_alone(record):
    for route, source in (
        ("frf", record),
        ("transmissibility", ar.Recording(record.responses, record.fs_hz)),
    ):
        within = ar.identify_antiresonances(record, excitation=0, band_hz=BAND, route=route).data_check
        alone = ar.check_data(source, excitation=0, band_hz=BAND)
        assert str(within) == str(alone)
        np.testing.assert_allclose(within.eigenvalues, alone.eigenvalues, rtol=1e-12)


def test_the_choice_follows_the_damping():
    case = ar.cases.chain8()
    records = (case.experiment(damping_ratio=ratio, duration_s=256.0, rng=1) for ratio in (0.01, 0.02))
    assert [choose_nperseg(record, BAND) for record in records] == [16384, 8192]


def test_averages_and_their_check_need_less_than_the_record_beside_it():
    masses = 1.0 + 0.1 * np.cos(np.arange(12.0))
    chain = ar.MassSpringChain(masses, np.full(11, 3e4), ground_first_n_per_m=4e4)
    short, long = (
        chain.simulate(excitation=0, fs_hz=256.0, duration_s=n / 256.0, damping_ratio=0.01, noise=0.01, rng=5)
        for n in (1 << 13, 1 << 18)
    )
    asked = {"excitation": 0, "band_hz": (5.0, 60.0), "nperseg": 2048}
    ar.check_data(short, **asked)  # imports
    tracemalloc.start()
    ar.check_data(long, **asked)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # Segments from 5 to 60 of 128 Hz, half overlapping, in single precision, take 0.43 of it.
    assert peak < long.responses.nbytes

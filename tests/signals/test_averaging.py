"""Averages of a record are made once, and everything that follows looks at them."""

import tracemalloc

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.signals import spectra
from antires_rs.signals.averaging import Autocorrelation, choose_nperseg
from antires_rs.signals.recording import Recording

BAND = (3.0, 130.0)


@pytest.fixture(scope="module")
def record():
    return ar.cases.chain8().experiment(noise=0.01, duration_s=60.0, rng=7)


@pytest.fixture
def passes(monkeypatch):
    """Shapes of the segments transformed, one entry for each pass over a record."""
    made = []
    transforms = spectra._transforms

    def counted(rows, unit, taper, step, lines):
        made.append((len(rows), taper.size))
        return transforms(rows, unit, taper, step, lines)

    monkeypatch.setattr(spectra, "_transforms", counted)
    return made


@pytest.mark.parametrize("options", [{"cross_check": "aaa"}, {"route": "frf", "nperseg": 2048}])
def test_an_identification_transforms_the_segments_once(record, passes, options):
    found = ar.identify_antiresonances(record, excitation=0, band_hz=BAND, **options)
    assert found.data_check is not None
    assert len(passes) == 1


def test_a_data_check_and_modes_transform_the_segments_once(record, passes):
    # Segments so short that the check asks for the longest ones' resolution, too.
    checked = ar.check_data(record, excitation=0, band_hz=BAND, nperseg=512)
    assert checked.named("resolution")
    assert len(passes) == 1
    ar.identify_modes(record, band_hz=BAND)
    assert len(passes) == 2


def test_the_check_within_an_identification_is_the_check_alone(record):
    for route, source in (
        ("frf", record),
        ("transmissibility", ar.Recording(record.responses, record.fs_hz)),
    ):
        within = ar.identify_antiresonances(record, excitation=0, band_hz=BAND, route=route).data_check
        alone = ar.check_data(source, excitation=0, band_hz=BAND)
        assert str(within) == str(alone)
        np.testing.assert_allclose(within.eigenvalues, alone.eigenvalues, rtol=1e-12)


def test_power_from_the_autocorrelation_is_that_of_many_segments():
    # Noise through a resonator: many segments at every place of a long record have the same mean.
    rng = np.random.default_rng(3)
    t = np.arange(2048) / 256.0
    ring = np.exp(-2.0 * t) * np.sin(2 * np.pi * 40.0 * t)
    x = np.convolve(rng.standard_normal(65536), ring)[:65536]
    rec = Recording(np.stack([x, -3.0 * x]), 256.0)
    n = 1024
    dense = spectra.cross_spectra(rec, nperseg=n, noverlap=n - 16, band_hz=(20.0, 60.0))
    welch = np.einsum("fii->f", dense.matrix.real / np.array([1.0, 9.0]))
    ours = Autocorrelation(rec).power(n, (20.0, 60.0))
    assert ours.shape == welch.shape
    np.testing.assert_allclose(ours / ours.sum(), welch / welch.sum(), rtol=0.02, atol=1e-5)


def test_the_choice_follows_the_damping():
    case = ar.cases.chain8()
    chosen = [
        choose_nperseg(case.experiment(damping_ratio=damping, duration_s=256.0, rng=1), BAND)
        for damping in (0.01, 0.02)
    ]
    assert chosen == [16384, 8192]


def test_averages_and_their_check_need_less_than_the_record_beside_it():
    """The fit's own memory depends on its lines and orders, not on the length of the record."""
    chain = ar.MassSpringChain(
        1.0 + 0.1 * np.cos(np.arange(12.0)), np.full(11, 3e4), ground_first_n_per_m=4e4
    )
    short, long = (
        chain.simulate(excitation=0, fs_hz=256.0, duration_s=n / 256.0, damping_ratio=0.01, noise=0.01, rng=5)
        for n in (1 << 13, 1 << 17)
    )
    asked = {"excitation": 0, "band_hz": (5.0, 60.0), "nperseg": 2048}
    ar.check_data(short, **asked)  # imports
    tracemalloc.start()
    ar.check_data(long, **asked)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # Segments from 5 to 60 of 128 Hz, half overlapping, in single precision, take 0.43 of it.
    assert peak < long.responses.nbytes

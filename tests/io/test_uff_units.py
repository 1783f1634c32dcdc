"""Units of universal files: of each ordinate, of the whole file, of time and of frequency."""

import numpy as np
import pytest

import antires_rs as ar
from tests.support.uff_files import FORCE, LINES, NOISE, dataset, written

# pyuff leaves files open that it writes in binary form.
pytestmark = [
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]


def test_units(tmp_path):
    path = written(tmp_path / "a.uff", dataset(NOISE[0], unit="V"))
    with pytest.warns(ar.AntiresWarning, match="responses in 'V', which is no unit known"):
        np.testing.assert_array_equal(ar.read_uff(path).responses[0], NOISE[0])
    np.testing.assert_allclose(ar.read_uff(path, unit="mm/s^2").responses[0], 1e-3 * NOISE[0], rtol=1e-15)
    with pytest.raises(ar.InvalidInputError, match="^unit: got 'V'; wanted a unit such as 'm/s2'"):
        ar.read_uff(path, unit="V")
    mixed = written(tmp_path / "b.uff", dataset(NOISE[0]), dataset(NOISE[1], node=2, unit="mm"))
    with pytest.raises(ar.UnsuitableDataError, match="responses of several kinds"):
        ar.read_uff(mixed)


@pytest.mark.parametrize(
    ("unit", "per", "factor"),
    [
        ("g", "N", 9.80665),
        ("m/s^2/N", "NONE", 1.0),
        ("mm/s^2", "kN", 1e-6),
        ("g/N", "N", 9.80665),
        ("NONE", "NONE", 1.0),
    ],
)
def test_units_of_frfs(tmp_path, unit, per, factor):
    path = written(tmp_path / "a.uff", dataset(LINES[0], kind=4, reference=(1, 3), unit=unit, per=per))
    np.testing.assert_allclose(ar.read_uff(path).values[0], factor * LINES[0], rtol=1e-15)


def test_spectra_in_other_units(tmp_path):
    power = np.linspace(1.0, 2.0, 100)
    path = written(
        tmp_path / "a.uff",
        dataset(power, kind=9, node=5, reference=(5, 3), unit="kN", data_type=FORCE),
        dataset(LINES[0] * power, kind=3, reference=(5, 3), unit="g", per="kN"),
    )
    np.testing.assert_allclose(ar.read_uff(path).values[0], 9.80665e-3 * LINES[0], rtol=1e-14)
    np.testing.assert_allclose(ar.read_uff(path, unit="m/s2/N").values[0], LINES[0], rtol=1e-14)


def units_of_the_file(length, force):
    return {
        "type": 164,
        "units_code": 5,
        "units_description": "mm (milli-newton)",
        "temp_mode": 1,
        "length": length,
        "force": force,
        "temp": 1.0,
        "temp_offset": 273.15,
    }


def test_units_of_the_whole_file(tmp_path):
    """Dataset 164 holds for functions without a label: SI times its factors is the file's unit."""
    path = written(
        tmp_path / "a.uff",
        units_of_the_file(1000.0, 1000.0),
        dataset(NOISE[0], unit="NONE"),
        dataset(NOISE[1], node=2, unit="g"),
        dataset(NOISE[2], unit="NONE", data_type=FORCE),
    )
    rec = ar.read_uff(path)
    np.testing.assert_allclose(rec.responses, [1e-3 * NOISE[0], 9.80665 * NOISE[1]], rtol=1e-15)
    np.testing.assert_allclose(rec.force, 1e-3 * NOISE[2], rtol=1e-15)
    np.testing.assert_array_equal(ar.read_uff(path, unit="m/s2").responses, NOISE[:2])
    frf = dataset(LINES[0], kind=4, reference=(1, 3), unit="NONE")
    path = written(
        tmp_path / "b.uff", units_of_the_file(1000.0, 1.0), {**frf, "orddenom_spec_data_type": FORCE}
    )
    np.testing.assert_allclose(ar.read_uff(path).values[0], 1e-3 * LINES[0], rtol=1e-15)
    path = written(tmp_path / "c.uff", units_of_the_file(0.0, 1.0), dataset(NOISE[0]))
    with pytest.raises(ar.UnsuitableDataError, match="units .dataset 164. have the factors 0 and 1"):
        ar.read_uff(path)


def test_time_and_frequency_in_the_unit_of_their_label(tmp_path):
    path = written(tmp_path / "a.uff", dataset(NOISE[0], step=0.5) | {"abscissa_axis_units_lab": "ms"})
    assert ar.read_uff(path).fs_hz == 2000.0
    frf = dataset(LINES[0], kind=4, reference=(1, 3), step=0.25, x=0.25 * np.arange(100))
    path = written(tmp_path / "b.uff", frf | {"abscissa_axis_units_lab": "kHz"})
    np.testing.assert_allclose(ar.read_uff(path).freq_hz, 250.0 * np.arange(100), rtol=1e-14)


@pytest.mark.parametrize("step", [0.1, 0.25, 1 / 3, 1.0])
@pytest.mark.parametrize("label", ["rad/s", "RAD/SEC"])
def test_frequencies_in_radians(tmp_path, step, label):
    """Read as Hz they would be 6.28 times too high."""
    frf = dataset(LINES[0], kind=4, reference=(1, 3), step=2 * np.pi * step, per="N")
    path = written(tmp_path / "a.uff", frf | {"abscissa_axis_units_lab": label})
    # The simplest step in Hz behind six digits in rad/s.
    np.testing.assert_allclose(ar.read_uff(path).freq_hz, np.arange(100) * step, rtol=1e-12)
    uneven = dataset(
        LINES[0],
        kind=4,
        reference=(1, 3),
        even=0,
        binary=0,
        per="N",
        x=2 * np.pi * step * np.arange(100) ** 1.5,
    )
    path = written(tmp_path / "b.uff", uneven | {"abscissa_axis_units_lab": label})
    np.testing.assert_allclose(ar.read_uff(path).freq_hz, step * np.arange(100) ** 1.5, rtol=1e-5)

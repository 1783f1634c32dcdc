"""No false alarm on measured plates, and faults that were put into them; the whole table is a benchmark."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.signals.one_force import Finding, one_of_a_kind
from reference import faults
from tests.support.campaign import some_of
from tests.support.measured_data import DATA, needs_plates

COLUMNS = [9 * row + column for row in (0, 2, 4, 6) for column in (0, 2, 4, 6, 8)]
BAND = (100.0, 480.0)


def plate(state, columns=None):
    read = ar.read_mat(DATA / "iqs_plates" / f"{state}.MAT", df_hz=0.5, dofs=range(81))
    rows = list(range(81)) if columns is None else columns
    return ar.FrequencyResponse(read.freq_hz[1:], read.values[rows, 1:], rows)


def over(response, reference):
    values = response.values / response.values[response.dofs.index(reference)]
    return ar.FrequencyResponse(response.freq_hz, values, response.dofs, "transmissibility", reference)


@needs_plates
@pytest.mark.parametrize(
    ("state", "columns", "band"),
    some_of(
        [
            ("00A_Ref_2", COLUMNS, BAND),
            ("29A_C140", None, BAND),
            ("00A_Ref_1", None, (250.0, 330.0)),
            ("36A_S3", COLUMNS, (20.0, 480.0)),
            ("27A_C60", None, BAND),
            ("00A_Ref_3", None, (100.0, 1500.0)),
        ]
    ),
)
def test_measured_plates_raise_no_alarm(state, columns, band):
    """Beside the clamp phases mean nothing; up to 28 channels of 81 were called late or a velocity."""
    response = plate(state, columns)
    for source in (response, over(response, 40 if columns is None else 22)):
        assert ar.check_data(source, band_hz=band).ok


@needs_plates
@pytest.mark.parametrize(
    ("name", "change", "least"),
    [
        ("time_shift", lambda x, f: faults.late(x, f, 0.5 / BAND[1]), 7),
        ("quadrature", faults.integrated, 7),
        ("dead_channel", lambda x, f: faults.noise_only(x, np.random.default_rng(3)), 10),
    ],
)
def test_faults_in_a_measured_plate_are_found(name, change, least):
    """In each second of 20 channels in turn; those that keep no common phase themselves cannot be told."""
    response = plate("27A_C60", COLUMNS)
    found = 0
    for row, dof in list(enumerate(response.dofs))[::2]:
        values = response.values.copy()
        values[row] = change(values[row], response.freq_hz)
        checked = ar.check_data(ar.FrequencyResponse(response.freq_hz, values, response.dofs), band_hz=BAND)
        assert all(f.where == (dof,) for f in checked.findings)
        found += any(f.name == name for f in checked.findings)
    assert found >= least


def test_findings_of_one_kind_are_one_line():
    def late(dof, ms):
        return Finding(
            "time_shift", "warning", (dof,), ms, 1.0, f"{dof} is late.", "Check.", f"late by {ms} ms"
        )

    [one] = one_of_a_kind([late(3, 2.0), late(7, 5.0)])
    assert (one.where, one.value, one.advice) == ((3, 7), 5.0, "Check.")
    assert one.text == "Dofs 3, 7: 3 late by 2.0 ms; 7 late by 5.0 ms."
    [many] = one_of_a_kind([late(i, float(i)) for i in range(2, 9)])
    assert many.text.endswith("; and 3 more.")
    assert "\n" not in str(many)
    general = [Finding("resolution", "warning", (), 1.0, 2.0, "Coarse.", "Finer."), late(1, 2.0)]
    assert one_of_a_kind(general) == tuple(general)


@pytest.mark.filterwarnings("ignore:identify_antiresonances. no antiresonance")
def test_the_warning_has_a_line_for_each_finding():
    rng = np.random.default_rng(5)
    noise = rng.standard_normal((3, 8192))
    noise[1] = np.clip(noise[0], -1.0, 1.0)
    with pytest.warns(ar.AntiresWarning, match="data check") as caught:
        ar.identify_antiresonances(ar.Recording(noise, 256.0), excitation=0, band_hz=(3, 100))
    [said] = [str(w.message) for w in caught if "data check" in str(w.message)]
    lines = said.splitlines()
    assert len(lines) > 1
    assert all(line.startswith("data check: ") for line in lines)
    assert len({line.split(":")[1] for line in lines}) == len(lines)

"""No false alarm on measured plates, and faults that were put into them; the whole table is a benchmark."""

import numpy as np
import pytest

import antires_rs as ar
from reference import faults
from reference.virtual_records import accelerance
from tests.support.campaign import some_of
from tests.support.checked_records import MASS, STIFFNESS, seen
from tests.support.measured_data import (
    BRAKE_REUSS,
    DATA,
    FLOORS,
    needs_brake_reuss,
    needs_plates,
    needs_southampton,
    southampton,
)

COLUMNS = [9 * row + column for row in (0, 2, 4, 6) for column in (0, 2, 4, 6, 8)]
BAND = (100.0, 480.0)


QUIET = [("00A_Ref_2", COLUMNS, BAND), ("29A_C140", None, BAND), ("00A_Ref_1", None, (250.0, 330.0))]
QUIET += [("36A_S3", COLUMNS, (20.0, 480.0)), ("27A_C60", None, BAND), ("00A_Ref_3", None, (100.0, 1500.0))]


def plate(state, columns=None):
    read = ar.read_mat(DATA / "iqs_plates" / f"{state}.MAT", df_hz=0.5, dofs=range(81))
    rows = list(range(81)) if columns is None else columns
    return ar.FrequencyResponse(read.freq_hz[1:], read.values[rows, 1:], rows)


def over(response, reference):
    values = response.values / response.values[response.dofs.index(reference)]
    return ar.FrequencyResponse(response.freq_hz, values, response.dofs, "transmissibility", reference)


@needs_plates
@pytest.mark.parametrize(("state", "columns", "band"), some_of(QUIET))
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


# ---- Measured responses, simulated and real
def check(resp, excitation=0):
    return ar.check_data(resp, excitation=excitation, band_hz=(3.0, 130.0))


def frfs(df=1 / 16, excitation=0, noise=1e-4):
    freq = np.arange(2.0, 140.0, df)
    h = accelerance(STIFFNESS, MASS, excitation, freq, 0.01)
    rng = np.random.default_rng(65)
    rough = rng.standard_normal((2, *h.shape))
    return freq, h + noise * np.abs(h).max() * (rough[0] + 1j * rough[1])


def test_measured_responses_get_the_tests_that_they_allow():
    freq, h = frfs()
    result = check(ar.FrequencyResponse(freq, h))
    assert result.findings == ()
    assert set(result.not_tested) == {"clipped_channel", "dropouts", "spikes", "signal_to_noise", "one_force"}
    for wrong in (1, 4, 7):
        assert check(ar.FrequencyResponse(freq, h), wrong).findings[0].advice.startswith("Dof 0 ")
    # Mobility instead of accelerance: the residues are real.
    assert check(ar.FrequencyResponse(freq, h / (2j * np.pi * freq))).ok
    t = ar.FrequencyResponse(freq, h / h[3], kind="transmissibility", reference=3)
    assert "do not show the resonances" in check(t, 5).not_tested["force_location"]


def test_dead_coarse_and_incoherent_responses_are_named():
    freq, h = frfs()
    h[2] = 0.0
    h[5] = np.random.default_rng(66).standard_normal((2, freq.size)).T @ [1.0, 1.0j]
    assert seen(check(ar.FrequencyResponse(freq, h))) == [("dead_channel", (2, 5))]
    # Lines 4 Hz apart for resonances 0.44 Hz wide; its own noise must not hide what is left.
    assert ("resolution", ()) in seen(check(ar.FrequencyResponse(*frfs(4.0, noise=0.0))))
    freq, h = frfs()
    coherence = np.ones(h.shape)
    coherence[1, ::2] = 0.2
    result = check(ar.FrequencyResponse(freq, h, coherence=coherence))
    assert [(f.name, f.where) for f in result.findings] == [("signal_to_noise", (1,))]


@needs_southampton
@pytest.mark.parametrize("floor", range(3))
def test_the_excited_floor_of_the_southampton_frame(floor):
    resp = southampton(FLOORS[floor])
    for band in ((5.0, 32.0), (4.0, 60.0)):
        for stated in range(3):
            result = ar.check_data(resp, excitation=stated, band_hz=band)
            if stated == floor:
                assert result.ok
            else:
                assert result.fatal
                assert result.findings[0].advice.startswith(f"Dof {floor} would fit")


@needs_brake_reuss
def test_the_single_hit_on_the_brake_reuss_beam():
    from scipy.io import loadmat

    held = loadmat(BRAKE_REUSS / "HammerImpact.mat", squeeze_me=True, struct_as_record=False)["HIdata"]
    rec = ar.Recording([held.acc1, held.acc2, held.acc3], 12800.0, dofs=["acc1", "acc2", "acc3"])
    result = ar.check_data(rec, excitation="hammer", band_hz=(50.0, 1200.0))
    assert result.ok
    assert [f.name for f in result.findings] == ["single_hit"]

"""The data check on measured responses, simulated and real."""

import numpy as np
import pytest

from antires_rs.signals.data_check import check_data
from antires_rs.signals.frequency_response import FrequencyResponse
from antires_rs.signals.recording import Recording
from reference.virtual_records import accelerance
from tests.support.checked_records import MASS, STIFFNESS, seen
from tests.support.measured_data import BRAKE_REUSS, FLOORS, needs_brake_reuss, needs_southampton, southampton


def check(resp, excitation=0):
    return check_data(resp, excitation=excitation, band_hz=(3.0, 130.0))


def frfs(df=1 / 16, excitation=0, noise=1e-4):
    freq = np.arange(2.0, 140.0, df)
    h = accelerance(STIFFNESS, MASS, excitation, freq, 0.01)
    rng = np.random.default_rng(65)
    rough = rng.standard_normal((2, *h.shape))
    return freq, h + noise * np.abs(h).max() * (rough[0] + 1j * rough[1])


def test_measured_responses_get_the_tests_that_they_allow():
    freq, h = frfs()
    result = check(FrequencyResponse(freq, h))
    assert result.findings == ()
    assert set(result.not_tested) == {"clipped_channel", "dropouts", "spikes", "signal_to_noise", "one_force"}
    for wrong in (1, 4, 7):
        assert check(FrequencyResponse(freq, h), wrong).findings[0].advice.startswith("Dof 0 ")
    # Mobility instead of accelerance: the residues are real.
    assert check(FrequencyResponse(freq, h / (2j * np.pi * freq))).ok
    t = FrequencyResponse(freq, h / h[3], kind="transmissibility", reference=3)
    assert "do not show the resonances" in check(t, 5).not_tested["force_location"]


def test_dead_coarse_and_incoherent_responses_are_named():
    freq, h = frfs()
    h[2] = 0.0
    h[5] = np.random.default_rng(66).standard_normal((2, freq.size)).T @ [1.0, 1.0j]
    assert seen(check(FrequencyResponse(freq, h))) == [("dead_channel", (2, 5))]
    # Lines 4 Hz apart for resonances 0.44 Hz wide; its own noise must not hide what is left.
    assert ("resolution", ()) in seen(check(FrequencyResponse(*frfs(4.0, noise=0.0))))
    freq, h = frfs()
    coherence = np.ones(h.shape)
    coherence[1, ::2] = 0.2
    result = check(FrequencyResponse(freq, h, coherence=coherence))
    assert [(f.name, f.where) for f in result.findings] == [("signal_to_noise", (1,))]


@needs_southampton
@pytest.mark.parametrize("floor", range(3))
def test_the_excited_floor_of_the_southampton_frame(floor):
    resp = southampton(FLOORS[floor])
    for band in ((5.0, 32.0), (4.0, 60.0)):
        for stated in range(3):
            result = check_data(resp, excitation=stated, band_hz=band)
            if stated == floor:
                assert result.ok
            else:
                assert result.fatal
                assert result.findings[0].advice.startswith(f"Dof {floor} would fit")


@needs_brake_reuss
def test_the_single_hit_on_the_brake_reuss_beam():
    from scipy.io import loadmat

    path = BRAKE_REUSS / "HammerImpact.mat"
    held = loadmat(path, squeeze_me=True, struct_as_record=False)["HIdata"]
    rec = Recording([held.acc1, held.acc2, held.acc3], 12800.0, dofs=["acc1", "acc2", "acc3"])
    result = check_data(rec, excitation="hammer", band_hz=(50.0, 1200.0))
    assert result.ok
    assert [f.name for f in result.findings] == ["single_hit"]

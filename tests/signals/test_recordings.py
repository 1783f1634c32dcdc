"""Recording and FrequencyResponse: what they hold, and what they refuse."""

from pathlib import Path

import numpy as np
import pytest

import antires_rs as ar
from tests.support.refusals import refused
from tests.support.snapshots import refusal, replay

DATA = np.arange(20.0).reshape(2, 10)
FREQ = np.array([1.0, 2.0, 3.0])


def test_recording_holds_copies_that_cannot_change():
    source = DATA.copy()
    rec = ar.Recording(source, 5.0, dofs=["a", 3], force=np.ones(10))
    source[:] = -1.0
    assert (rec.n_channels, rec.n_samples, rec.duration_s) == (2, 10, 2.0)
    assert rec.dofs == ("a", 3)
    assert np.array_equal(rec.responses, DATA)
    with pytest.raises(ValueError, match="read-only"):
        rec.responses[0, 0] = 1.0
    with pytest.raises(AttributeError):
        rec.fs_hz = 7.0
    assert np.shares_memory(rec.responses, ar.Recording(rec.responses, 5.0).responses)


def test_what_cannot_be_is_refused():
    def recording(**given):
        return lambda: ar.Recording(**({"responses": DATA, "fs_hz": 5.0} | given))

    def response(**given):
        return lambda: ar.FrequencyResponse(**({"freq_hz": FREQ, "values": np.ones(3)} | given))

    names = globals() | {"recording": recording, "response": response}
    replay(Path(__file__).with_name("wrong_recordings.txt"), lambda call: refusal(eval(call, names)))


def test_a_time_step_in_place_of_the_rate_is_warned_of():
    with pytest.warns(ar.AntiresWarning, match=r"lasts 2 years\. If that .* the rate is 640 Hz"):
        ar.Recording(np.ones((1, 100_000)), 1.0 / 640.0)
    ar.Recording(np.ones((1, 8760)), 1.0 / 3600.0)  # a year of hours is none


def test_transmissibilities_hold_a_row_of_ones():
    refused("^reference: got .*row of ones", ar.FrequencyResponse, FREQ, np.ones(3), kind="transmissibility")
    with pytest.raises(ar.InvalidInputError, match="^values: got .*Divide"):
        ar.FrequencyResponse(FREQ, [[2, 2, 2], [1, 1, 1]], kind="transmissibility", reference=0)


def test_response_accepts_a_vector_as_one_output():
    resp = ar.FrequencyResponse(FREQ, [1, 2j, 3])
    assert resp.values.shape == (1, 3)
    assert (resp.kind, resp.n_outputs, resp.n_freq, resp.dofs) == ("frf", 1, 3, (0,))


def test_the_deviation_follows_from_coherence_and_averages_unless_given():
    values, coherence = [1.0, 2j, 3.0], [0.5, 0.8, 0.0]
    derived = ar.FrequencyResponse(FREQ, values, coherence=coherence, n_averages=11)
    # abs(H) sqrt((1 - g2) / (2 g2 (n - 1))); without coherence a value says nothing.
    assert np.allclose(derived.std[0, :2], [np.sqrt(0.05), 2 * np.sqrt(0.0125)])
    assert derived.std[0, 2] > 1e5
    assert derived.n_averages == 11.0
    given = ar.FrequencyResponse(FREQ, values, coherence=coherence, n_averages=11, std=[0.1, 0.2, 0.3])
    assert given.std.tolist() == [[0.1, 0.2, 0.3]]
    with pytest.raises(ValueError, match="read-only"):
        given.std[0, 0] = 1.0
    alone = {"coherence": coherence}
    for unknown in ({}, alone, {"n_averages": 5}, alone | {"n_averages": 1}):
        assert ar.FrequencyResponse(FREQ, values, **unknown).std is None

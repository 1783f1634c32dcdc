"""Recording and FrequencyResponse: what they hold, and what they refuse."""

import numpy as np
import pytest

import antires_rs as ar
from tests.support.refusals import each_of, refused

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


OF_RECORDING = {  #: Values that an argument cannot have, and words of the error.
    "responses": [(DATA[0], "n_channels"), (DATA.T, "Transpose"), (np.where(DATA == 3, np.nan, DATA), "NaN")]
    + [(np.empty((0, 4)), "empty"), (DATA + 1j, "complex")]
}
OF_RECORDING |= {"fs_hz": [(0.0, "finite"), ("fast", "finite")]}
OF_RECORDING |= {"dofs": [([1], "1 labels"), ([1, 1], "more than once")]}
OF_RECORDING |= {"force": [(np.ones(9), "9 samples"), (np.full(10, np.inf), "infinite")]}
UNSORTED = [([1.0, 3.0, 2.0], "Sort"), ([1.0, 1.0, 2.0], "repeated"), ([-1.0, 1.0, 2.0], "not negative")]
OF_RESPONSE = {"freq_hz": UNSORTED, "n_averages": [(0.5, "finite number"), ("many", "finite number")]}
OF_RESPONSE |= {"values": [(np.ones((2, 4)), "n_outputs"), ([1.0, np.nan, 2.0], "NaN")]}
OF_RESPONSE |= {"kind": [("mobility", "transmissibility")], "reference": [(0, "Only transmissibilities")]}
OF_RESPONSE |= {"coherence": [([0.5, 1.2, 0.5], "from 0 to 1"), ([0.5, 0.5], "shape")]}
STDS = [([0.1, 0.1], "shape"), ([0.1, -0.1, 0.1], "not negative"), ([0.1, np.inf, 0.1], "infinite")]
OF_RESPONSE |= {"std": STDS}


@pytest.mark.parametrize(
    ("make", "argument", "case"),
    [(ar.Recording, *each) for each in each_of(OF_RECORDING)]
    + [(ar.FrequencyResponse, *each) for each in each_of(OF_RESPONSE)],
)
def test_what_cannot_be_is_refused(make, argument, case):
    value, hint = case
    of_curves = {"freq_hz": FREQ, "values": np.ones(3)}
    usual = {"responses": DATA, "fs_hz": 5.0} if make is ar.Recording else of_curves
    refused(f"(?s)^{argument}: got .*{hint}", make, **(usual | {argument: value}))


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

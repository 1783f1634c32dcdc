"""Recording and FrequencyResponse: what they hold, and what they refuse."""

import numpy as np
import pytest

from antires_rs.exceptions import InvalidInputError
from antires_rs.signals.frequency_response import FrequencyResponse
from antires_rs.signals.recording import Recording

DATA = np.arange(20.0).reshape(2, 10)
FREQ = np.array([1.0, 2.0, 3.0])


def test_recording_holds_copies_that_cannot_change():
    source = DATA.copy()
    rec = Recording(source, 5.0, dofs=["a", 3], force=np.ones(10))
    source[:] = -1.0
    assert (rec.n_channels, rec.n_samples, rec.duration_s) == (2, 10, 2.0)
    assert rec.dofs == ("a", 3)
    assert np.array_equal(rec.responses, DATA)
    with pytest.raises(ValueError, match="read-only"):
        rec.responses[0, 0] = 1.0
    with pytest.raises(AttributeError):
        rec.fs_hz = 7.0


@pytest.mark.parametrize(
    ("kwargs", "name", "hint"),
    [
        ({"responses": DATA[0]}, "responses", "n_channels"),
        ({"responses": DATA.T}, "responses", "Transpose"),
        ({"responses": np.where(DATA == 3, np.nan, DATA)}, "responses", "NaN"),
        ({"responses": np.empty((0, 4))}, "responses", "empty"),
        ({"responses": DATA + 1j}, "responses", "complex"),
        ({"fs_hz": 0.0}, "fs_hz", "finite"),
        ({"fs_hz": "fast"}, "fs_hz", "finite"),
        ({"dofs": [1]}, "dofs", "1 labels"),
        ({"dofs": [1, 1]}, "dofs", "more than once"),
        ({"force": np.ones(9)}, "force", "9 samples"),
        ({"force": np.full(10, np.inf)}, "force", "infinite"),
    ],
)
def test_recording_refuses(kwargs, name, hint):
    arguments = {"responses": DATA, "fs_hz": 5.0} | kwargs
    with pytest.raises(InvalidInputError, match=hint) as caught:
        Recording(**arguments)
    assert str(caught.value).startswith(f"{name}: got ")


def test_response_accepts_a_vector_as_one_output():
    resp = FrequencyResponse(FREQ, [1, 2j, 3])
    assert resp.values.shape == (1, 3)
    assert (resp.kind, resp.n_outputs, resp.n_freq, resp.dofs) == ("frf", 1, 3, (0,))


@pytest.mark.parametrize(
    ("kwargs", "name", "hint"),
    [
        ({"freq_hz": [1.0, 3.0, 2.0]}, "freq_hz", "Sort"),
        ({"freq_hz": [1.0, 1.0, 2.0]}, "freq_hz", "repeated"),
        ({"freq_hz": [-1.0, 1.0, 2.0]}, "freq_hz", "not negative"),
        ({"values": np.ones((2, 4))}, "values", "n_outputs"),
        ({"values": [1.0, np.nan, 2.0]}, "values", "NaN"),
        ({"kind": "mobility"}, "kind", "transmissibility"),
        ({"kind": "transmissibility"}, "reference", "row of ones"),
        ({"reference": 0}, "reference", "Only transmissibilities"),
        ({"values": [[2, 2, 2], [1, 1, 1]], "kind": "transmissibility", "reference": 0}, "values", "Divide"),
        ({"coherence": [0.5, 1.2, 0.5]}, "coherence", "from 0 to 1"),
        ({"coherence": [0.5, 0.5]}, "coherence", "shape"),
        ({"n_averages": 0.5}, "n_averages", "finite number"),
        ({"n_averages": "many"}, "n_averages", "finite number"),
        ({"std": [0.1, 0.1]}, "std", "shape"),
        ({"std": [0.1, -0.1, 0.1]}, "std", "not negative"),
        ({"std": [0.1, np.inf, 0.1]}, "std", "infinite"),
    ],
)
def test_response_refuses(kwargs, name, hint):
    arguments = {"freq_hz": FREQ, "values": np.ones(3)} | kwargs
    with pytest.raises(InvalidInputError, match=hint) as caught:
        FrequencyResponse(**arguments)
    assert str(caught.value).startswith(f"{name}: got ")


def test_the_deviation_follows_from_coherence_and_averages_unless_given():
    values, coherence = [1.0, 2j, 3.0], [0.5, 0.8, 0.0]
    derived = FrequencyResponse(FREQ, values, coherence=coherence, n_averages=11)
    # abs(H) sqrt((1 - g2) / (2 g2 (n - 1))); without coherence a value says nothing.
    assert np.allclose(derived.std[0, :2], [np.sqrt(0.05), 2 * np.sqrt(0.0125)])
    assert derived.std[0, 2] > 1e5
    assert derived.n_averages == 11.0
    given = FrequencyResponse(FREQ, values, coherence=coherence, n_averages=11, std=[0.1, 0.2, 0.3])
    assert given.std.tolist() == [[0.1, 0.2, 0.3]]
    with pytest.raises(ValueError, match="read-only"):
        given.std[0, 0] = 1.0
    for unknown in (
        {},
        {"coherence": coherence},
        {"n_averages": 5},
        {"coherence": coherence, "n_averages": 1},
    ):
        assert FrequencyResponse(FREQ, values, **unknown).std is None


def test_a_read_only_array_of_ones_own_is_not_copied():
    first = Recording(DATA, 5.0)
    assert np.shares_memory(first.responses, Recording(first.responses, 5.0).responses)

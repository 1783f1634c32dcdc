"""pandas and xarray: values, coordinates, and what to install without them."""

import sys

import numpy as np
import pytest

import antires_rs as ar
from reference.io_signals import recording, response

ZEROS = ar.AntiresonanceSet(0, {0: [8.0, 3.0], "tip": [5.0], 2: []}, std_hz={0: [0.2, 0.1]})
SIGNALS = [recording(), response(), response(kind="transmissibility", std=True), ZEROS]


@pytest.mark.parametrize("signal", SIGNALS)
@pytest.mark.parametrize(("method", "package"), [("to_dataframe", "pandas"), ("to_xarray", "xarray")])
def test_what_to_install(monkeypatch, signal, method, package):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ar.MissingDependencyError, match=rf'needs {package}; .*"antires-rs\[tables\]"'):
        getattr(signal, method)()


def test_frames_of_pandas():
    pytest.importorskip("pandas", reason="pandas is optional and not installed")
    rec, resp = recording(), response()
    frame = rec.to_dataframe()
    assert list(frame.columns) == [0, "tip", "12+Z", "force"]
    assert frame.index.name == "time_s"
    np.testing.assert_array_equal(frame["tip"], rec.responses[1])
    np.testing.assert_array_equal(frame.index, np.arange(rec.n_samples) / rec.fs_hz)
    frame = resp.to_dataframe()
    assert list(frame.columns) == list(resp.dofs)
    np.testing.assert_array_equal(frame.to_numpy().T, resp.values)
    assert list(ZEROS.to_dataframe()["freq_hz"]) == [3.0, 8.0, 5.0]


def test_datasets_of_xarray():
    pytest.importorskip("xarray", reason="xarray is optional and not installed")
    rec, resp = recording(), response(kind="transmissibility")
    data = rec.to_xarray()
    np.testing.assert_array_equal(data["responses"].sel(dof="tip"), rec.responses[1])
    assert data.attrs == {"fs_hz": 512.0}
    assert data["force"].dims == ("time_s",)
    data = resp.to_xarray()
    np.testing.assert_array_equal(data["values"].sel(dof=0), resp.values[0])
    np.testing.assert_array_equal(data["coherence"], resp.coherence)
    assert data.attrs == {"kind": "transmissibility", "reference": "tip", "n_averages": 25.5}
    data = ZEROS.to_xarray()
    assert data.sizes == {"dof": 3, "rank": 2}
    np.testing.assert_array_equal(data["freq_hz"], [[3.0, 8.0], [5.0, np.nan], [np.nan, np.nan]])
    np.testing.assert_array_equal(data["std_hz"].sel(dof=0), [0.1, 0.2])

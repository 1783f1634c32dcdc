"""Prominent peaks against SciPy's."""

import subprocess
import sys

import numpy as np
import pytest

from antires_rs.signals.spectra import prominent_peaks


@pytest.mark.parametrize("digits", [0, 1, 6])
def test_the_peaks_are_those_of_scipy_also_on_flat_tops_and_among_equals(digits):
    from scipy.signal import find_peaks

    rng = np.random.default_rng(digits)
    for size in (*range(9), 50, 400):
        for _ in range(40):
            curve = np.round(rng.standard_normal(size).cumsum(), digits)
            for least in (0.0, 0.5, 1.0, 3.0):
                wanted = find_peaks(curve, prominence=least)[0]
                np.testing.assert_array_equal(prominent_peaks(curve, least), wanted)


def test_identifying_a_record_does_not_import_scipy_signal():
    code = (
        "import sys, warnings, antires_rs as ar\nwarnings.simplefilter('ignore')\n"
        "record = ar.cases.chain8().experiment(noise=0.01, duration_s=32.0, rng=0)\n"
        "assert ar.identify_antiresonances(record, excitation=0, band_hz=(3, 130))[0].size\n"
        "assert 'scipy.signal' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)

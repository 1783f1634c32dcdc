"""Several FRFs or transmissibilities of one test: averaged, with the scatter between them."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.exceptions import InvalidInputError
from antires_rs.signals.repeats import averaged
from reference.virtual_records import chain8_matrices, random_record

STIFFNESS, MASS = chain8_matrices()
BAND = (3.0, 130.0)
FS = 512.0


def identified(source):
    return ar.identify_antiresonances(source, excitation=0, band_hz=BAND)


def curves(seed, kind):
    responses, force = random_record(STIFFNESS, MASS, seed=seed, duration_s=64.0, noise=0.01)
    rec = ar.Recording(responses, FS, force=force)
    if kind == "frf":
        return ar.frf(rec, nperseg=4096)
    return ar.transmissibility(rec, 2, nperseg=4096, estimator="rank1")


@pytest.mark.parametrize("kind", ["frf", "transmissibility"])
def test_curves_of_one_test_are_averaged_with_their_scatter(kind):
    runs = [curves(seed, kind) for seed in range(6)]
    mean = averaged(runs)
    inside = (mean.freq_hz > 5) & (mean.freq_hz < 120)
    # The mean over another six tests, as far off as the scatter says.
    other = averaged([curves(seed, kind) for seed in range(6, 12)])
    rows = [dof for dof in range(8) if kind == "frf" or dof != 2]
    off = np.abs(mean.values - other.values)[rows][:, inside] / np.sqrt(
        2 * (mean.std**2 + other.std**2)[rows][:, inside]
    )
    assert 0.5 < np.median(off) < 1.2  # 0.83 for the modulus of a complex Gaussian
    found = identified(runs)
    assert sum(found[dof].size for dof in found) >= 26


def test_curves_that_do_not_belong_together_are_named():
    one = curves(0, "transmissibility")
    other = ar.FrequencyResponse(one.freq_hz + 0.01, one.values, one.dofs, one.kind, one.reference)
    with pytest.raises(InvalidInputError, match=r"^source\[1\].*lines of the first"):
        identified([one, other])

"""Records of the chain for the data check, and what it says of them."""

from antires_rs.signals.data_check import check_data
from antires_rs.signals.recording import Recording
from reference.virtual_records import chain8_matrices, random_record, true_antiresonances

STIFFNESS, MASS = chain8_matrices()
TRUTH = [true_antiresonances(STIFFNESS, MASS, dof, 0) for dof in range(8)]
BAND = (3.0, 130.0)
FS = 512.0


def data(noise=0.01, seed=30, duration_s=128.0, **kwargs):
    return random_record(STIFFNESS, MASS, noise=noise, seed=seed, duration_s=duration_s, **kwargs)


def record(*args, with_force=True, **kwargs):
    responses, force = data(*args, **kwargs)
    return Recording(responses, FS, force=force if with_force else None)


def check(rec, excitation=0, **kwargs):
    return check_data(rec, excitation=excitation, band_hz=BAND, **kwargs)


def seen(result):
    """Names and dofs of all that is worse than a note."""
    return [(f.name, f.where) for f in result.findings if f.severity != "note"]


def changed(good, channel, change):
    responses = good[0].copy()
    responses[channel] = change(responses[channel])
    return Recording(responses, FS)

"""Records as they come: hits that bounce, of one sample, before minutes of noise; resonances that drift."""

from itertools import product

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import antires_rs as ar
from reference import nothing_to_find, structures
from reference.measured_reality import MEASURED, hit
from reference.modal_structures import STRUCTURES
from tests.support.campaign import some_of

FS, BAND = structures.FS_HZ, (3.0, 130.0)


def found(source):
    return ar.identify_antiresonances(source, excitation=0, band_hz=BAND)


@pytest.mark.parametrize("seed", some_of(range(1, 5), 2))
def test_a_hammer_that_bounces_is_told(seed):
    one = structures.random_chain(seed)
    single, double = (
        ar.check_data(ar.Recording(nothing_to_find.hit(one, seed, more=more), FS), band_hz=BAND)
        for more in ((), ((0.4, 0.6),))
    )
    assert not single.named("double_hit")
    (told,) = double.named("double_hit")
    assert told.value == pytest.approx(400.0, abs=20.0)
    assert double.ok


def test_values_of_a_double_hit_are_right():
    one = structures.random_chain(1)
    zeros = found(ar.Recording(nothing_to_find.hit(one, 1, more=((0.15, 0.6),)), FS))
    truth = one.truth()
    assert sum(map(len, zeros.values())) >= 24
    assert all(np.abs(truth[dof] / value - 1.0).min() < 0.01 for dof in zeros for value in zeros[dof])


@pytest.mark.filterwarnings("ignore::antires_rs.AntiresWarning")
def test_rest_minutes_of_noise_and_offsets_change_little():
    one = structures.random_chain(1)
    x = nothing_to_find.hit(one, 1, width_s=0.5 / FS)
    rng = np.random.default_rng(8)
    level = x[:, -512:].std(axis=1).max()
    before, after = (level * rng.standard_normal((len(x), round(s * FS))) for s in (5.0, 60.0))
    long = np.hstack([before, x, after])
    creep = np.linspace(0.0, 1.0, long.shape[1]) * rng.uniform(-3.0, 3.0, (len(x), 1))
    long = long + level * (creep + rng.uniform(-50.0, 50.0, (len(x), 1)))
    truth, short = one.truth(), found(ar.Recording(x, FS))
    zeros = found(ar.Recording(long, FS))
    assert all(np.abs(truth[dof] / value - 1.0).min() < 0.01 for dof in zeros for value in zeros[dof])
    assert sum(map(len, zeros.values())) >= 0.5 * sum(map(len, short.values()))


def asked_of_too_short(x, fs_hz, band_hz):
    told = ar.check_data(ar.Recording(x, fs_hz), band_hz=band_hz).named("record_length")
    return [one.advice.split()[0] for one in told]


def test_a_weak_hit_is_to_be_harder_not_longer():
    asked = []
    for name, seed in product(("frame", "tower"), range(11, 13)):
        one = STRUCTURES[name]()
        made = hit(one, MEASURED, seed)
        level = made.samples.std(axis=1).mean()
        noise = np.random.default_rng(seed).standard_normal(made.samples.shape)
        for times in (2.0, 2.5, 3.0):
            asked += asked_of_too_short(made.samples + times * level * noise, made.fs_hz, one.band_hz)
    assert len(asked) >= 4
    assert set(asked) == {"If"}  # "If its one rise is a hit, ..."


def test_short_steady_records_are_to_be_longer():
    asked = []
    for seed in range(60, 66):
        short = structures.random_chain(seed).record(noise=0.3, seed=seed, duration_s=8.0)
        asked += asked_of_too_short(short.responses, FS, BAND)
    assert len(asked) >= 4
    assert set(asked) == {"Record"}


def drifting(one, seed, change, duration_s=60.0):
    """A record in which all frequencies rise by a share from one end to the other: its time is stretched."""
    x = one.record(noise=0.01, seed=seed, duration_s=1.1 * duration_s).responses
    t = np.arange(round(duration_s * FS)) / FS
    at = t + 0.5 * change * (t**2 / duration_s - t)
    known = np.arange(x.shape[1]) / FS
    return ar.Recording(np.stack([CubicSpline(known, row)(at - at.min()) for row in x]), FS, one.responses)


FAMILIES = ("portal_frame", "random_chain", "full_stiffness")


@pytest.mark.parametrize(("seed", "family"), some_of(product((1, 2, 3, 5), FAMILIES), 1))
def test_frequencies_that_drift_are_told_and_held_by_the_errors(family, seed):
    one = getattr(structures, family)(seed)
    assert not ar.check_data(drifting(one, seed, 0.0), band_hz=one.band_hz).named("drift")
    source = drifting(one, seed, 0.02)
    with pytest.warns(ar.AntiresWarning, match="drift: The resonances move by at least"):
        zeros = ar.identify_antiresonances(source, excitation=one.excitation, band_hz=one.band_hz)
    truth = one.truth()
    off = [np.abs(truth[d] - f).min(initial=np.inf) for d in zeros for f in zeros[d]]
    assert np.mean(np.array(off) < 2.0 * np.concatenate([zeros.std_hz[d] for d in zeros])) >= 0.9


@pytest.mark.filterwarnings("ignore::antires_rs.exceptions.AntiresWarning")
@pytest.mark.parametrize("seed", some_of([0, 1]))
def test_a_band_between_resonances_empties_no_channel(seed):
    """Where the hit moves little in the band it may still move much beyond it."""
    made = hit(STRUCTURES["frame"](), MEASURED, seed)
    given = {"source": ar.Recording(made.samples, made.fs_hz), "excitation": 0, "band_hz": (80, 120)}
    checked, unchecked = (ar.identify_antiresonances(**given, check=check) for check in ("warn", "off"))
    assert sum(map(len, unchecked.values())) >= 5
    assert all(np.array_equal(checked[dof], unchecked[dof]) for dof in unchecked)


@pytest.mark.filterwarnings("ignore::antires_rs.exceptions.AntiresWarning")
def test_the_check_finds_hits_that_drift():
    made = hit(STRUCTURES["frame"](), MEASURED, 1)
    x = made.samples
    peak = np.abs(x).max(axis=1, keepdims=True)
    slow = ar.Recording(x + 2.0 * peak * np.exp(-3.0 * np.linspace(0.0, 1.0, x.shape[1])), made.fs_hz)
    checked = ar.check_data(slow, excitation=0, band_hz=(3, 120))
    assert "missed_hit" not in {finding.name for finding in checked.findings}
    assert ar.identify_antiresonances(slow, excitation=0, band_hz=(3, 120)).options["fitted"] == "directions"


@pytest.mark.filterwarnings("ignore::antires_rs.exceptions.AntiresWarning")
def test_a_band_may_begin_at_zero():
    made = hit(STRUCTURES["frame"](), MEASURED, 1)
    rec, fit = ar.Recording(made.samples, made.fs_hz), ar.FitOptions(formulation="directions")
    zeros = ar.identify_antiresonances(rec, excitation=0, band_hz=(0.0, 120), fit=fit)
    for low in (0.0, 1e-6):
        followed = ar.identify_antiresonances(rec, excitation=0, band_hz=(low, 120), near=zeros)
        assert sum(map(len, followed.values())) >= 1

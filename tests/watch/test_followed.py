"""Series whose tests are followed, and a monitor that adds up what is gone and says what it cannot judge."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.exceptions import InvalidInputError
from tests.identification.test_following import BAND, EXCITATION, chain, curves, hit
from tests.support.campaign import some_of
from tests.support.refusals import refused

OPTIONS = {"excitation": EXCITATION, "band_hz": BAND}


@pytest.fixture(scope="module")
def tests():
    return [hit(chain(), seed) for seed in range(6)] + [hit(chain(0.85, at=2), seed) for seed in (8, 9)]


@pytest.fixture(scope="module")
def series(tests):
    return ar.identify_series(tests, **OPTIONS)


def test_hits_are_followed_from_what_the_first_have_together(series):
    tracks = series.tracks()
    assert all(one.options["fitted"] == "followed" for one in series)
    assert np.mean(~np.isnan(tracks.freq_hz)) >= 0.95
    assert not [event for event in tracks.events if event.kind == "new"]
    moved = np.abs(tracks.change_percent[6:]) > 8.0 * np.nanstd(tracks.change_percent[:6], axis=0)
    assert moved.any(axis=1).all()


def test_values_followed_from_one_are_compared_however_far_they_moved():
    known = {EXCITATION: {"known_hz": [40.0, 43.0]}}
    a, b = (ar.AntiresonanceSet(1, {1: f}, scores=known) for f in ([40.0, 43.0], [37.0, 40.1]))
    np.testing.assert_array_equal(ar.compare(a, b).b_hz, [37.0, 40.1])
    np.testing.assert_array_equal(ar.track([a, b]).freq_hz, [[40.0, 43.0], [37.0, 40.1]])


def test_a_store_goes_on_with_the_same_values(tests, series, tmp_path):
    store = tmp_path / "hits.sqlite"
    assert ar.identify_series(tests[:4], **OPTIONS, store=store)[0].options["fitted"] == "followed"
    # Four together have other values than eight: what was kept is followed again.
    assert ar.identify_series(tests, **OPTIONS, store=store) == series
    assert ar.identify_series(tests, **OPTIONS, store=store) == series


def test_what_is_followed_can_be_given(tests, series):
    known = ar.AntiresonanceSet(EXCITATION, {0: [42.9], 1: [42.9]})
    given = ar.identify_series(tests[:2], **OPTIONS, near=known)
    assert all(one[0].size == one[1].size == 1 for one in given)
    assert not any(one.followed for one in ar.identify_series(tests[:2], **OPTIONS, near=0))
    first = ar.identify_series([curves(chain(), seed=i) for i in range(3)], **OPTIONS, near=2)
    assert first[2].options["fitted"] == "followed"
    with pytest.raises(InvalidInputError):
        ar.identify_series(tests[:2], **OPTIONS, near=-1)


UNFIT = {  #: Records that do not suit the others: of the responses (4, n), their rate and dofs.
    "other dofs": lambda x, fs, dofs: (x, fs, ["a", "b", "c", "d"]),
    "fewer channels": lambda x, fs, dofs: (x[:3], fs, dofs[:3]),
    "one channel": lambda x, fs, dofs: (x[:1], fs, dofs[:1]),
    "too short": lambda x, fs, dofs: (x[:, :40], fs, dofs),
    "another rate": lambda x, fs, dofs: (x, 2.0 * fs, dofs),
    "dead": lambda x, fs, dofs: (x * (np.arange(4) != 3)[:, None], fs, dofs),
    "missed hit": lambda x, fs, dofs: (x[:, int(np.argmax(np.max(np.abs(x), axis=0))) + 20 :], fs, dofs),
}


def unfit(rec, how):
    return ar.Recording(*UNFIT[how](rec.responses, rec.fs_hz, rec.dofs))


@pytest.mark.parametrize(("place", "how"), some_of(enumerate(UNFIT), [(0, "other dofs"), (6, "missed hit")]))
def test_one_record_that_does_not_suit_is_left_out_of_what_is_followed(tests, place, how):
    some, place = list(tests[:5]), place % 5
    some[place] = unfit(some[place], how)
    series = ar.identify_series(some, **OPTIONS)
    fit = [i for i in range(5) if i != place]
    assert all(series[i].options["fitted"] == "followed" for i in fit)
    assert all(tuple(series[i]) == (0, 1, 2, 3) and sum(map(len, series[i].values())) >= 4 for i in fit)


def test_records_of_which_nothing_can_be_followed_are_refused(tests):
    pair = {"first": tests[0], "other": unfit(tests[1], "other dofs")}
    refused("near: got the first 2, with no two records", ar.identify_series, pair, **OPTIONS, near=2)
    assert not any(one.followed for one in ar.identify_series(pair, **OPTIONS))


@pytest.mark.parametrize(
    ("near", "words"),
    [("all", "wanted a set.*or an integer"), (ar.AntiresonanceSet(0, {0: [42.9]}), "force at 0")],
)
def test_what_no_test_can_follow_is_refused_once(tests, near, words):
    refused(f"near: .*{words}", ar.identify_series, tests[:2], **OPTIONS, near=near)


def many(count, rng, rates):
    places = 10.0 * np.arange(1, len(rates) + 1)
    scattered = (places * (1 + 1e-4 * rng.standard_normal(places.size)) for _ in range(count))
    return [ar.AntiresonanceSet(0, {0: hz[rng.random(len(rates)) < rates]}) for hz in scattered]


def test_what_stays_away_alarms_in_the_end():
    rng = np.random.default_rng(3)
    usual = np.array([1.0, 1.0, 1.0, 0.8])
    gone = usual * [1, 1, 1, 0]
    watched = ar.monitor(many(200, rng, usual) + many(25, rng, gone) + many(10, rng, usual), baseline=100)
    assert watched.alarm[100:200].mean() <= 0.02
    assert not watched.alarm[200:203].any()
    assert watched.alarm[215:225].all()
    assert watched.why(224) == ("events",)
    assert not watched.alarm[225:][~np.isnan(watched.freq_hz[225:, 3])].any()

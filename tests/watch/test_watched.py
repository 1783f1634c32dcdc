"""The answer of the watch: its assessments, text, table, picture and page."""

import numpy as np
import pytest

import antires_rs as ar
from tests.support.refusals import refused
from tests.watch.drawn_tests import MASSES, SPRINGS, chain, exact, many


@pytest.fixture(scope="module")
def watched():
    """60 intact tests, ten more, twelve with 2 % damage of spring 1; all springs of the model are off."""
    rng = np.random.default_rng(51)
    sets = many(exact(chain()), 70, rng) + many(exact(chain(0.02)), 12, rng) + [None]
    sets[3] = None
    weather = {"temperature_c": rng.uniform(0, 20, 83)}
    weather["time"] = np.datetime64("2026-01-01") + np.arange(83)
    series = ar.Series.from_sets(sets, conditions=weather)
    model = ar.MassSpringChain(MASSES, SPRINGS * rng.uniform(0.97, 1.03, 5))
    return ar.monitor(series, baseline=60, model=model)


def test_the_damage_is_assessed_once_a_run_and_the_summary_states_the_rate_and_its_check(watched):
    assert [run for run in watched.runs if run[0] >= 60] == [(70, 81)]
    assert list(watched.assessments) == [70]
    found = watched.assessments[70]
    assert list(found.damaged) == [2]
    assert found.severity[2] == pytest.approx(0.02, abs=0.004)
    wanted = "83 tests watched, 59 of them the baseline|false alarms: 1 % of intact tests stated|spring 2"
    wanted += "|alarm when left out|alarm: tests 70 to 81, 12 alarms|failed, not judged: 2 tests"
    assert all(said in str(watched) for said in wanted.split("|"))


def test_one_row_a_test(watched):
    pytest.importorskip("pandas")
    frame = watched.to_dataframe()
    assert not watched.alarm[list(watched.failed)].any()
    assert frame["alarm"].tolist() == watched.alarm.tolist()
    assert frame["baseline"].sum() == 59
    assert frame.loc[[3, 82], "failed"].tolist() == ["no set was given"] * 2
    assert {"T2", "T2_limit", "EWMA", "events", "temperature_c", "time"} <= set(frame)


def test_the_picture_has_all_charts(watched):
    pyplot = pytest.importorskip("matplotlib.pyplot")
    top = watched.plot()
    labels = ["Single tests / limit", "Mean of tests / limit", "temperature_c"]
    assert [ax.get_ylabel() for ax in top.figure.axes] == labels
    pyplot.close(top.figure)


def test_the_page_grows(watched, tmp_path, quick_pictures):
    pytest.importorskip("matplotlib")
    page = tmp_path / "watch.html"
    watched.report(page)
    text = page.read_text()
    for said in ("12 of 22 tests outside the baseline alarm", "spring 2", "test 81, the latest: ALARM"):
        assert said in text
    assert 'src="http' not in text
    watched.report(page)
    assert [path.name for path in tmp_path.iterdir()] == ["watch.html"]
    refused("path: got 3", watched.report, 3)


@pytest.mark.parametrize("wrong", ["a", 99, -84, True, 1.5])
def test_a_test_that_is_not_there_is_refused(watched, wrong):
    assert watched.why(-2) == watched.why(81)
    refused("test: got", watched.why, wrong)


def test_an_assessor_tells_the_damage_of_a_run():
    rng = np.random.default_rng(77)
    sets = many(exact(chain()), 70, rng) + many(exact(chain(0.03)), 8, rng)
    model = ar.MassSpringChain(MASSES, SPRINGS * rng.uniform(0.97, 1.03, 5))
    watched = ar.monitor(sets, baseline=60, assessor=ar.Assessor(model, baseline=sets[:5], workers=1))
    (first,) = [first for first, _ in watched.runs if first >= 60]
    found = watched.assessments[first]
    assert isinstance(found, ar.AssessedTest)
    assert found.damaged == [2]
    assert found.severity[2] == pytest.approx(0.03, abs=0.006)
    assert "spring 2" in str(watched)


LONGER = ar.MassSpringChain([*MASSES, 1.0, 1.0], [*SPRINGS, 5e4, 5e4])


@pytest.mark.parametrize(
    ("force", "dofs", "options", "said"),
    [
        (0, range(6), {"assessor": "plan.npz"}, "assessor"),
        (0, range(6), {"elements": [1]}, "elements: got it without a model, or beside an assessor"),
        (0, range(6), {"model": chain()}, "model: got it without a model, or beside an assessor"),
        (5, [0, 1, 2], {}, "^assessor: got one for the force at 5"),
        (0, [6], {}, "^assessor: .*dofs of these tests"),
    ],
)
def test_an_assessor_of_other_tests_is_refused_before_the_first_alarm(force, dofs, options, said):
    sets = many(exact(chain()), 12, np.random.default_rng(79))
    exact_hz = LONGER.antiresonances(list(dofs), force)
    before = ar.AntiresonanceSet(force, dict(zip(dofs, exact_hz, strict=True)))
    assessor = ar.Assessor(LONGER, baseline=before, workers=1)
    refused(said, ar.monitor, sets, baseline=10, **({"assessor": assessor} | options))

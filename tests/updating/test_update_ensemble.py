"""Many updatings by any workers: the bits of single ones, in order, and what fails is told."""

import os
import signal
import threading

import numpy as np
import pytest

import antires_rs as ar
from tests.support.refusals import assert_refused

SHORT = ar.IslandGA(max_evaluations=400)


def problem(stiffness=550.0, measured=None):
    """A chain on the ground with one storey that is unknown; ``measured`` in place of its own values."""
    true = ar.MassSpringChain([2.0, 1.0, 1.5], [stiffness, 480.0], ground_first_n_per_m=300.0)
    nominal = ar.MassSpringChain([2.0, 1.0, 1.5], [500.0, 500.0], ground_first_n_per_m=300.0)
    values = dict(enumerate(true.antiresonances([0, 1, 2], 0))) if measured is None else measured
    springs = ar.stiffness_factor([0, 1], bounds=(0.7, 1.3))
    return ar.UpdatingProblem(nominal, springs, ar.AntiresonanceSet(0, values))


def bits(found):
    return found.x.tobytes(), found.fun.tobytes(), found.seeds


@pytest.mark.parametrize("workers", ["threads", 2])
def test_the_bits_do_not_depend_on_the_workers(workers):
    several = [problem(k) for k in (520.0, 550.0, 580.0)]
    alone = ar.update_ensemble(iter(several), optimizer=SHORT, rng=3)
    assert bits(ar.update_ensemble(several, optimizer=SHORT, rng=3, workers=workers)) == bits(alone)
    one = [ar.update_ensemble(problem(), count=3, optimizer=SHORT, rng=0, workers=w) for w in (None, workers)]
    assert bits(one[0]) == bits(one[1])
    assert one[0].x.shape == (3, 2)
    assert "3 updatings, 3 with a result" in str(one[0])
    assert alone.failed == {}
    assert not alone.interrupted


def test_each_is_what_update_gives_with_its_seed():
    several = [problem(k) for k in (520.0, 580.0)]
    found = ar.update_ensemble(several, optimizer=SHORT, rng=7)
    for k, one in enumerate(found):
        again = ar.update(several[k], optimizer=SHORT, rng=found.seeds[k], workers=1)
        assert one.x.tobytes() == again.x.tobytes()
        assert one.problem is several[k]
    assert len(set(found.seeds)) == len(found) == 2
    fewer = ar.UpdatingProblem(problem().model, several[0].parameters[:1], problem().measured)
    with pytest.raises(ar.InvalidInputError, match="problems of 1, 2 parameters"):
        _ = ar.update_ensemble([several[0], fewer], optimizer=SHORT, rng=0).x
    np.testing.assert_allclose(found.x[:, 0], [1.04, 1.16], atol=0.01)


def test_what_fails_is_told_and_the_others_stand(monkeypatch):
    from antires_rs.updating import update as room

    real = room.update

    def brittle(given, **options):
        if given is several[1]:
            raise ar.NumericalError("the modes", "this one only")
        return real(given, **options)

    several = [problem(k) for k in (520.0, 550.0, 580.0)]
    monkeypatch.setattr(room, "update", brittle)
    found = ar.update_ensemble(several, optimizer=SHORT, rng=0)
    assert found.failed == {1: "NumericalError: the modes failed: this one only"}
    assert found[1] is None
    assert np.isnan(found.x[1]).all()
    assert np.isfinite(found.x[[0, 2]]).all()
    assert "updating 1 failed" in str(found)


def test_ctrl_c_keeps_what_is_there():
    def stopped():
        yield problem(520.0)
        threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
        for _ in range(10_000):
            yield problem(550.0)

    found = ar.update_ensemble(stopped(), optimizer=SHORT, rng=0)
    assert found.interrupted
    assert 1 <= len(found) < 10_000
    assert found.x[0, 0] == pytest.approx(1.04, abs=0.01)


@pytest.mark.parametrize(
    ("argument", "given", "count"),
    [("count", problem(), None), ("count", [problem()], 3), ("count", problem(), 0)]
    + [("problems[1]", [problem(), "no problem"], None), ("problems", 5, None)],
)
def test_wrong_arguments_are_refused(argument, given, count):
    assert_refused(argument, ar.update_ensemble, given, optimizer=SHORT, rng=0, count=count)

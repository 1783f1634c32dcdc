"""Checkpoints, whatever is in them: the search as it was, or an error of ours; never another search."""

from __future__ import annotations

import hashlib
import warnings

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

import antires_rs as ar
from antires_rs.optimize.checkpoint import Checkpoint
from tests.support.campaign import examples
from tests.support.mutations import any_bytes, mutated

ONE_FILE = settings(
    deadline=20_000, max_examples=examples(150), suppress_health_check=[HealthCheck.function_scoped_fixture]
)
SEARCH = ar.IslandGA(islands=2, population=8, max_evaluations=400, polish=False)
NAME = "run.ckpt"


def problem():
    true = ar.MassSpringChain([1.0, 1.0, 2.0], [430.0, 420.0])
    zeros = ar.AntiresonanceSet(0, dict(enumerate(true.antiresonances([0, 1], 0))))
    nominal = ar.MassSpringChain([1.0, 1.0, 2.0], [500.0, 400.0])
    return ar.UpdatingProblem(nominal, ar.stiffness_factor([0, 1], bounds=(0.8, 1.2)), zeros)


def search(path):
    return ar.update(problem(), optimizer=SEARCH, rng=5, workers=1, checkpoint=path)


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """A file of a search that was stopped, what it holds, and the end of that search."""
    path = tmp_path_factory.mktemp("good") / NAME
    ar.update(
        problem(),
        optimizer=SEARCH,
        rng=5,
        workers=1,
        checkpoint=path,
        callback=lambda state: state["nit"] >= 5,
    )
    return path.read_bytes(), Checkpoint(path), search(None)


def read(path, content):
    path.write_bytes(content)
    path.with_name(NAME + ".previous").unlink(missing_ok=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return Checkpoint(path)
        except ar.UnsuitableDataError:
            return None


def test_what_was_written_is_read(tmp_path, good):
    content, whole, _ = good
    again = read(tmp_path / NAME, content)
    assert (again.seed, again.resume) == (whole.seed, whole.resume)
    again.begin(whole._problem, whole.seed)
    again.store(whole.resume)
    assert (tmp_path / NAME).read_bytes() == content


@ONE_FILE
@given(content=any_bytes)
def test_any_bytes(tmp_path, content):
    assert read(tmp_path / NAME, content) is None


@ONE_FILE
@given(data=st.data())
def test_a_good_file_gone_wrong(tmp_path, good, data):
    """The state of the search has a checksum; a changed seed or problem is refused when the search begins."""
    content, whole, end = good
    changed = data.draw(mutated(content))
    path = tmp_path / NAME
    kept = read(path, changed)
    if kept is None:
        return
    assert kept.resume == whole.resume
    if (kept.seed, kept._problem) == (whole.seed, whole._problem):
        assert search(path).search.x.tobytes() == end.search.x.tobytes()
    else:
        with pytest.raises(ar.InvalidInputError, match="the file of this very search"):
            search(path)


@ONE_FILE
@given(data=st.data())
def test_a_state_gone_wrong_under_a_right_checksum(tmp_path, good, data):
    """As of a program that writes such files itself: the core takes nothing on trust, and always ends."""
    content, whole, _ = good
    payload = data.draw(mutated(whole.resume))
    head = content[: len(content) - len(whole.resume) - 40]
    digest = hashlib.sha256(payload).digest() + len(payload).to_bytes(8, "little")
    path = tmp_path / NAME
    path.write_bytes(head + digest + payload)
    path.with_name(NAME + ".previous").unlink(missing_ok=True)
    try:
        result = search(path)
    except ar.AntiresError:
        return
    low, high = result.problem.bounds.T
    assert ((low <= result.x) & (result.x <= high)).all()

"""Checkpoints: whole or not there, a search taken up again ends in the same bytes, and nothing is trusted."""

import hashlib
import os
import warnings

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

import antires_rs as ar
from antires_rs.optimize.checkpoint import Checkpoint
from tests.support.campaign import examples
from tests.support.mutations import any_bytes, mutated
from tests.support.refusals import refused, unsuitable

NAME = "run.ckpt"
#: Some two hundred generations with migrations, about a second.
SEARCH = {"max_evaluations": 30_000, "patience": 5, "improvement_tolerance": 0.02, "polish": False}


def problem():
    return ar.cases.chain8(perturbation=0.08, rng=1).updating_problem()


def bytes_of(result):
    search, history = result.search, result.search.history
    arrays = (search.x, history.cost, history.nfev, history.migrations, search.populations)
    return [a.tobytes() for a in arrays] + [search.fun.hex(), search.nfev, search.nit, search.status]


def searched(path=None, **options):
    given = {"optimizer": ar.IslandGA(**SEARCH), "rng": 3, "workers": 1, "checkpoint": path, **options}
    return ar.update(problem(), **given)


def part(path, generations):
    return searched(path, callback=lambda state: state["nit"] >= generations)


@pytest.fixture(scope="module")
def whole():
    return bytes_of(searched())


def test_a_stopped_search_goes_on_to_the_same_bytes(tmp_path, whole):
    path = tmp_path / NAME
    for generations in (7, 40, 41):
        assert part(path, generations).status == "callback"
    assert bytes_of(searched(path, workers=2)) == whole
    again = searched(path, rng=None)
    assert bytes_of(again) == whole
    assert again.seed == 3
    assert sorted(p.name for p in tmp_path.iterdir()) == [NAME]


def test_a_polished_damage_search_goes_on_to_the_same_bytes(tmp_path):
    case = ar.cases.chain8()
    measured = ar.AntiresonanceSet(case.excitation, case.truth(1)["freq_hz"])
    # Islands that never agree to the last digit go on until the budget.
    ga = ar.IslandGA(max_evaluations=4000, gene_tolerance=0.0, agreement="genes", patience=6)
    given = {"optimizer": ga, "rng": 1}
    complete = ar.assess_damage(case.model, measured, **given)
    given["checkpoint"] = tmp_path / NAME
    for last in (3, 11):
        ar.assess_damage(case.model, measured, **given, callback=lambda state, at=last: state["nit"] >= at)
    assert bytes_of(ar.assess_damage(case.model, measured, **given)) == bytes_of(complete)


def test_a_damaged_file_is_refused(tmp_path):
    path = tmp_path / NAME
    part(path, 5)
    good = path.read_bytes()
    for bad in (good[:100], good[:-1], good[:200] + bytes([good[200] ^ 1]) + good[201:], b"", b"text"):
        path.write_bytes(bad)
        unsuitable("wanted one that is whole", Checkpoint, path)


def test_another_search_is_refused_and_the_file_left_alone(tmp_path):
    path = tmp_path / NAME
    part(path, 5)
    before = path.read_bytes()
    other = ar.cases.chain8(perturbation=0.08, rng=2).updating_problem()
    for change in ({"rng": 4}, {"optimizer": ar.IslandGA(**SEARCH, islands=3)}, {"x0": problem().nominal}):
        refused(r"^checkpoint: got run\.ckpt, the search of", searched, path, **change)
    refused("another problem", ar.update, other, optimizer=ar.IslandGA(**SEARCH), rng=3, checkpoint=path)
    for wrong, words in ((tmp_path / "no" / "x", ""), (tmp_path, ".*a file, not a folder"), (3, " 3")):
        refused(f"checkpoint: got{words}", ar.update, other, checkpoint=wrong)
    assert path.read_bytes() == before


def test_a_search_of_another_layout_is_refused_by_name(tmp_path):
    path = tmp_path / NAME
    part(path, 5)
    whole = path.read_bytes()
    for layout, maker in ((b"1", "an older"), (b"9", "a newer")):
        path.write_bytes(whole.replace(b"search 2", b"search " + layout, 1))
        with pytest.raises(ar.UnsuitableDataError, match=rf"the search of {maker} .*layout") as told:
            searched(path)
        assert (told.value.argument, path.exists()) == ("checkpoint", True)
        assert told.value.remedy


def test_a_disk_that_fails_is_warned_of_and_the_search_goes_on(tmp_path, monkeypatch, whole):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.warns(ar.AntiresWarning, match="cannot be written") as caught:
        result = searched(tmp_path / NAME)
    assert bytes_of(result) == whole
    assert len(caught) == 1
    assert list(tmp_path.iterdir()) == []


# ---- whatever is in a file: the search as it was, or an error of ours; never another search -------------
#: Another search, short.
FEW = ar.IslandGA(islands=2, population=8, max_evaluations=400, polish=False)
ONE_FILE = settings(
    deadline=20_000, max_examples=examples(80), suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def search(path, **options):
    true = ar.MassSpringChain([1.0, 1.0, 2.0], [430.0, 420.0])
    zeros = ar.AntiresonanceSet(0, dict(enumerate(true.antiresonances([0, 1], 0))))
    nominal = ar.MassSpringChain([1.0, 1.0, 2.0], [500.0, 400.0])
    springs = ar.UpdatingProblem(nominal, ar.stiffness_factor([0, 1], bounds=(0.8, 1.2)), zeros)
    return ar.update(springs, optimizer=FEW, rng=5, workers=1, checkpoint=path, **options)


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    path = tmp_path_factory.mktemp("good") / NAME
    search(path, callback=lambda state: state["nit"] >= 5)
    return path.read_bytes(), Checkpoint(path), search(None)


def read(path, content):
    path.write_bytes(content)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return Checkpoint(path)
        except ar.UnsuitableDataError:
            return None


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
        refused("the file of this very search", search, path)


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
    try:
        result = search(path)
    except ar.AntiresError:
        return
    low, high = result.problem.bounds.T
    assert ((low <= result.x) & (result.x <= high)).all()

"""Checkpoints: whole or not there, and a search taken up again ends in the same bytes."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.optimize.checkpoint import Checkpoint
from antires_rs.updating.problem import fingerprint
from tests.support.paths import ROOT

#: Some two hundred generations with migrations, about a second.
SEARCH = {"max_evaluations": 30_000, "patience": 5, "improvement_tolerance": 0.02, "polish": False}


def problem():
    return ar.cases.chain8(perturbation=0.08, rng=1).updating_problem()


def bytes_of(result):
    search, history = result.search, result.search.history
    arrays = (search.x, history.cost, history.nfev, history.migrations, search.populations)
    return [a.tobytes() for a in arrays] + [search.fun.hex(), search.nfev, search.nit, search.status]


def part(path, generations, **options):
    """A search stopped after some generations."""
    return ar.update(
        problem(),
        optimizer=ar.IslandGA(**SEARCH),
        rng=3,
        checkpoint=path,
        workers=1,
        callback=lambda state: state["nit"] >= generations,
        **options,
    )


@pytest.fixture(scope="module")
def whole():
    return bytes_of(ar.update(problem(), optimizer=ar.IslandGA(**SEARCH), rng=3, workers=1))


@pytest.mark.parametrize("workers", [1, 2])
def test_a_stopped_search_goes_on_to_the_same_bytes(tmp_path, whole, workers):
    path = tmp_path / "run.ckpt"
    for generations in (7, 40, 41):
        assert part(path, generations).status == "callback"
    resumed = ar.update(problem(), optimizer=ar.IslandGA(**SEARCH), rng=3, checkpoint=path, workers=workers)
    assert bytes_of(resumed) == whole
    # A finished search says again what it found, and needs no seed.
    again = ar.update(problem(), optimizer=ar.IslandGA(**SEARCH), checkpoint=path)
    assert bytes_of(again) == whole
    assert again.seed == 3
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.ckpt", "run.ckpt.previous"]


def test_a_polished_damage_search_goes_on_to_the_same_bytes(tmp_path):
    case = ar.cases.chain8()
    measured = ar.AntiresonanceSet(case.excitation, case.truth(1)["freq_hz"])
    # Islands that never agree to the last digit go on until the budget.
    ga = ar.IslandGA(max_evaluations=4000, gene_tolerance=0.0, agreement="genes", patience=6)
    complete = ar.assess_damage(case.model, measured, optimizer=ga, rng=1)
    path = tmp_path / "run.ckpt"
    for generations in (3, 11):
        ar.assess_damage(
            case.model,
            measured,
            optimizer=ga,
            rng=1,
            checkpoint=path,
            callback=lambda state, last=generations: state["nit"] >= last,
        )
    assert bytes_of(ar.assess_damage(case.model, measured, optimizer=ga, rng=1, checkpoint=path)) == bytes_of(
        complete
    )


KILLED = """
import sys, antires_rs as ar
import antires_rs.optimize.checkpoint, tests.optimize.test_checkpoint as t
write = antires_rs.optimize.checkpoint.Checkpoint.__init__
def often(self, path, every_s=0.0):
    write(self, path, every_s)
antires_rs.optimize.checkpoint.Checkpoint.__init__ = often
told = []
def tell(state):  # once, at the first generation: before it there is nothing to write
    told or print("begun", flush=True)
    told.append(state)
optimizer = ar.IslandGA(**t.SEARCH)
ar.update(t.problem(), optimizer=optimizer, rng=3, workers=1, checkpoint=sys.argv[1], callback=tell)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this system has no SIGKILL")
def test_killed_at_any_moment_it_goes_on_to_the_same_bytes(tmp_path, whole):
    """Every generation is written, so that many kills fall into the writing."""
    rng = np.random.default_rng(0)
    for delay in rng.uniform(0.02, 0.6, 6):
        path = tmp_path / "run.ckpt"
        with subprocess.Popen(
            [sys.executable, "-c", KILLED, str(path)], stdout=subprocess.PIPE, cwd=ROOT
        ) as process:
            process.stdout.readline()
            time.sleep(delay)
            process.kill()
    resumed = ar.update(problem(), optimizer=ar.IslandGA(**SEARCH), rng=3, workers=1, checkpoint=path)
    assert bytes_of(resumed) == whole
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.ckpt", "run.ckpt.previous"]


def test_a_damaged_file_gives_way_to_the_one_before(tmp_path, whole):
    path = tmp_path / "run.ckpt"
    part(path, 5)
    part(path, 9)
    assert (tmp_path / "run.ckpt.previous").exists()
    good = path.read_bytes()
    for bad in (good[:100], good[:-1], good[:200] + bytes([good[200] ^ 1]) + good[201:], b"", b"text"):
        path.write_bytes(bad)
        with pytest.warns(ar.AntiresWarning, match=r"damaged; going on from run\.ckpt\.previous"):
            kept = Checkpoint(path)
        assert kept.resume is not None
    path.unlink()
    assert Checkpoint(path).resume is not None
    path.write_bytes(b"text")
    with pytest.warns(ar.AntiresWarning, match="damaged"):
        resumed = ar.update(problem(), optimizer=ar.IslandGA(**SEARCH), rng=3, workers=1, checkpoint=path)
    assert bytes_of(resumed) == whole
    path.write_bytes(b"text")
    (tmp_path / "run.ckpt.previous").write_bytes(good[:50])
    with pytest.raises(ar.UnsuitableDataError, match="wanted one that is whole"):
        Checkpoint(path)


def test_another_search_is_refused_and_the_file_left_alone(tmp_path):
    path = tmp_path / "run.ckpt"
    part(path, 5)
    before = path.read_bytes()
    other = ar.cases.chain8(perturbation=0.08, rng=2).updating_problem()
    for change in ({"rng": 4}, {"optimizer": ar.IslandGA(**SEARCH, islands=3)}, {"x0": problem().nominal}):
        with pytest.raises(ar.InvalidInputError, match=r"^checkpoint: got run\.ckpt, the search of"):
            ar.update(problem(), checkpoint=path, **{"optimizer": ar.IslandGA(**SEARCH), "rng": 3, **change})
    with pytest.raises(ar.InvalidInputError, match="another problem"):
        ar.update(other, optimizer=ar.IslandGA(**SEARCH), rng=3, checkpoint=path)
    with pytest.raises(ar.InvalidInputError, match="checkpoint: got"):
        ar.update(other, checkpoint=tmp_path / "no" / "folder.ckpt")
    with pytest.raises(ar.InvalidInputError, match="a file, not a folder"):
        ar.update(other, checkpoint=tmp_path)
    with pytest.raises(ar.InvalidInputError, match="checkpoint: got 3"):
        ar.update(other, checkpoint=3)
    assert path.read_bytes() == before


def test_what_a_parameter_acts_on_belongs_to_the_fingerprint():
    pipe = ar.Tube(0.038, 0.0015, 2.1e11, 7850.0)
    nodes, elements = [(0.3 * i, 0.05 * (i % 2)) for i in range(8)], [(i, i + 1) for i in range(7)]
    prints = set()
    for parameter in (
        ar.angle([3], 3, bounds_deg=(-5, 5)),
        ar.angle([3], 4, bounds_deg=(-5, 5)),
        ar.thickness("a", bounds=(0.9, 1.1), relative=True),
    ):
        for names in ("aaabbbb", "aabbbbb"):
            model = ar.FrameModel(
                nodes,
                [(*e, n) for e, n in zip(elements, names, strict=True)],
                {"a": pipe, "b": pipe},
                fixed=[0],
            )
            zeros = ar.AntiresonanceSet(4, {4: [30.0], 10: [50.0]})
            prints.add(fingerprint(ar.UpdatingProblem(model, parameter, zeros), {}, []))
    assert len(prints) == 4  # for an angle the two assignments are one model


def test_a_disk_that_fails_is_warned_of_and_the_search_goes_on(tmp_path, monkeypatch, whole):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.warns(ar.AntiresWarning, match="cannot be written") as caught:
        result = ar.update(
            problem(), optimizer=ar.IslandGA(**SEARCH), rng=3, workers=1, checkpoint=tmp_path / "run.ckpt"
        )
    assert bytes_of(result) == whole
    assert len(caught) == 1
    assert list(tmp_path.iterdir()) == []

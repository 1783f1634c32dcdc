"""The main results are those kept from the version before, and its public names are there."""

import json
import shutil

import pytest

import antires_rs as ar
from tests.main_results import files
from tests.main_results.cases import KINDS
from tests.main_results.replay import ANSWERS, ELSEWHERE, LIMITS, compared, differences, names
from tests.support.campaign import campaign

KEPT = json.loads(ANSWERS.read_text(encoding="utf-8"))
#: The longest of those that differ from another in seed, state or number of damages alone: for the
#: campaign and for the replay, which has all.
AGAIN = {"exhaust 1 noisy", "exhaust 2 wrong", "exhaust 3 exact", "tower 1 noisy"}
AGAIN |= {"published plate 36A_S3", "published shake table stiff", "chain8 records 870", "chain8 records 871"}
AGAIN |= {"published Southampton frame 1", "published Southampton frame 2", "baseline {0: 0.1} 831"}
AGAIN |= {"baseline {0: 0.5, 2: 0.2, 4: 0.3} 835", "baseline {1: 0.2, 3: 0.35} 834"}
AGAIN |= {"baseline {2: 0.3} 832", "baseline {4: 0.6} 833"}
AGAIN |= {"simulated random chain, force at 4"}


@pytest.mark.parametrize(
    ("kind", "name", "case"),
    [
        pytest.param(kind, name, case, id=f"{kind} {name}", marks=campaign if name in AGAIN else ())
        for kind, make in KINDS.items()
        for name, case in make()
    ],
)
def test_a_result_is_as_before(kind, name, case):
    assert compared(kind, KEPT[kind][name], case, here=False) == []


#: These take their less common arguments in one value; the old ones still work, and warn.
GATHERED = {"identify_antiresonances", "assess_damage"}


def test_every_public_name_is_there():
    now = names()
    assert set(KEPT["names"]) <= set(now)
    for name, parts in KEPT["names"].items():
        assert name in GATHERED or set(parts) <= set(now[name]), name


def test_every_key_of_a_job_is_there():
    assert len(KEPT["job_keys"]) > 100
    assert set(KEPT["job_keys"]) <= set(files.job_keys())


def test_files_of_the_version_before_are_read():
    pytest.importorskip("pyarrow")
    assert differences(KEPT["files"], json.loads(json.dumps(files.read(files.FOLDER))), 1e-9) == []


def test_a_search_of_the_version_before_goes_on(tmp_path):
    case = ar.cases.chain8()
    problem = case.damage_problem(case.exact(1))
    copy = tmp_path / "search.ckpt"
    shutil.copy(files.FOLDER / "search.ckpt", copy)
    ga = ar.IslandGA(max_evaluations=600)
    resumed = ar.update(problem, optimizer=ga, rng=5, checkpoint=copy)
    assert resumed.x.tolist() == ar.update(problem, optimizer=ga, rng=5).x.tolist()


def test_what_is_compared_can_differ():
    assert differences({"a": [1.0]}, {"a": [1.0 + 1e-8]}, 1e-9) == ["/a/0: 1.0 was, 1.00000001 is"]
    assert differences([1.0], [1.0, 2.0], 1.0)
    assert differences("0x1p0", "0x1p1", 1.0)
    assert differences([0.5], [0.5 + 1e-7], LIMITS["assessments"]) == []
    was, now = {"freq_hz": [5.0], "std_hz": [0.1]}, {"freq_hz": [5.001], "std_hz": [0.11]}
    assert differences(was, now, 0.0, by_name=ELSEWHERE) == ["/freq_hz/0: 5.0 was, 5.001 is"]

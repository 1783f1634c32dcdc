"""Files that the version before wrote: read to the same bits, or refused by name.

``tests/data/before_issue_11`` was written by version 1 of the layouts of results and searches, in which an
updated model stands as the problem it came from.
"""

import json
from pathlib import Path

import numpy as np
import pytest

import antires_rs as ar

FOLDER = Path(__file__).parents[1] / "data" / "before_issue_11"
EXPECTED = json.loads((FOLDER / "expected.json").read_text())


def hexes(matrix):
    dense = np.asarray(matrix.todense() if hasattr(matrix, "todense") else matrix)
    return [value.hex() for value in dense.diagonal().tolist()]


@pytest.mark.parametrize("name", EXPECTED)
def test_results_are_read_to_the_same_bits(tmp_path, name):
    wanted = EXPECTED[name]
    back = ar.UpdateResult.load(FOLDER / f"{name}.npz")
    assert type(back).__name__ == wanted["cls"]
    assert [value.hex() for value in back.x.tolist()] == wanted["x"]
    assert (back.fun.hex(), back.nfev, back.status) == (wanted["fun"], wanted["nfev"], wanted["status"])
    assert back.njev is None  # version 1 did not count them
    assert back.problem.cost(back.x).hex() == wanted["fun"]
    assert back.problem.names == wanted["names"]
    assert hexes(back.model.stiffness()) == wanted["stiffness"]
    assert hexes(back.model.mass()) == wanted["mass"]
    # Written again, it is a file of this version, and the same.
    back.save(tmp_path / "again.npz")
    again = ar.UpdateResult.load(tmp_path / "again.npz")
    assert again.model.description == back.model.description
    assert hexes(again.model.stiffness()) == wanted["stiffness"]


def test_a_model_updated_twice_has_both_sets_of_parameters():
    back = ar.DamageResult.load(FOLDER / "damage_of_a_chain_updated_twice.npz")
    quantities = [[p.quantity for p in one.parameters] for one in back.model.description.applied]
    assert quantities == [["stiffness_factor"] * 2, ["mass_factor"], ["stiffness_reduction"] * 2]


def test_springs_between_nodes_are_those_of_the_state():
    back = ar.UpdateResult.load(FOLDER / "update_of_an_updated_frame.npz")
    once, twice = back.problem.model.node_springs[0], back.model.node_springs[0]
    assert once.stiffness_n_per_m == 2e3 * 1.1
    assert twice.stiffness_n_per_m == once.stiffness_n_per_m * back.x[1]


def test_matrices_are_read():
    model = ar.read_matrices(FOLDER / "matrices.npz")
    assert model.n_dof == 3
    np.testing.assert_array_equal(model.stiffness().toarray()[0], [600.0, -500.0, 0.0])


def test_a_search_under_way_is_refused_by_name(tmp_path):
    path = tmp_path / "run.ckpt"
    path.write_bytes((FOLDER / "search.ckpt").read_bytes())
    (tmp_path / "run.ckpt.previous").write_bytes(path.read_bytes())
    chain = ar.MassSpringChain([1.0, 2.0, 1.5], [500.0, 400.0], ground_first_n_per_m=100.0)
    measured = ar.AntiresonanceSet(0, {0: [2.0]})
    problem = ar.UpdatingProblem(chain, ar.stiffness_factor(0, bounds=(0.8, 1.2)), measured)
    with pytest.raises(
        ar.UnsuitableDataError, match=r"run\.ckpt, the search of an older .*layout 1"
    ) as raised:
        ar.update(problem, checkpoint=path)
    assert raised.value.argument == "checkpoint"
    assert raised.value.remedy
    assert path.exists()
    newer = path.read_bytes().replace(b"search 1", b"search 9", 1)
    path.write_bytes(newer)
    with pytest.raises(ar.UnsuitableDataError, match="a newer antires_rs .layout 9"):
        ar.update(problem, checkpoint=path)

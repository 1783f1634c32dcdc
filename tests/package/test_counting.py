"""One number for one thing: what is printed, drawn or saved is the index that arguments take."""

import json
import re

import numpy as np
import pytest

import antires_rs as ar
from antires_rs import figures as plotting
from antires_rs.app.main import main
from antires_rs.figures.report import write_report
from tests.support.four_masses import exact

#: The damaged element of both structures, and its loss.
HIT, LOSS = 2, 0.4


@pytest.fixture(scope="module")
def chain():
    """A free chain, its third spring softened."""
    springs = np.full(5, 500.0)
    weaker = springs.copy()
    weaker[HIT] *= 1.0 - LOSS
    model, damaged = (ar.MassSpringChain(np.ones(6), each) for each in (springs, weaker))
    return model, exact(damaged), ar.assess_damage(model, exact(damaged), baseline=exact(model))


@pytest.fixture(scope="module")
def frame():
    """A clamped beam of five elements, its third softened, with a mass at the tip."""
    pipe, nodes = ar.Tube(0.04, 0.002, 2.1e11, 7850.0), [(0.3 * i, 0.0) for i in range(6)]
    pairs = [(i, i + 1) for i in range(5)]
    model = ar.FrameModel(nodes, pairs, pipe, fixed=[0], point_masses=[ar.PointMass(5, 0.5)])
    damaged = model.with_parameters(ar.stiffness_reduction([HIT]), [LOSS])
    force = model.dof(5, "v")
    dofs = [model.dof(node, "v") for node in range(1, 6)]
    zeros = [one.antiresonances(dofs, force, f_max_hz=900.0) for one in (model, damaged)]
    before, now = (ar.AntiresonanceSet(force, dict(zip(dofs, each, strict=True))) for each in zeros)
    return model, ar.assess_damage(model, now, baseline=before)


def named(text, what):
    """Numbers that a text gives to things of this kind."""
    return {int(number) for number in re.findall(rf"\b{what}s? (\d+)", text, re.IGNORECASE)}


def test_a_spring_has_one_number_in_all_that_is_said_and_drawn(chain, tmp_path):
    model, _, found = chain
    name = f"spring {HIT}"
    assert found.damaged == [HIT]
    assert named(found.headline, "spring") == {HIT}
    assert found.hypotheses[0].elements == (HIT,)
    assert str(found.hypotheses).splitlines()[1].split(maxsplit=1)[1].startswith(name)
    assert name in found.summary()
    assert found.problem.names[HIT] == f"stiffness loss of {name}"
    first = found.hypotheses.to_dataframe().iloc[0]
    assert tuple(first["elements"]) == (HIT,)
    bars = plotting.data_of(found.plot())["bars"]
    assert bars["name"][bars["element"] == HIT].tolist() == [name]
    drawn = plotting.plot_chain(model, {HIT: 100.0 * LOSS})
    springs = plotting.data_of(drawn)["springs"]
    assert springs["name"][springs["element"] == HIT].tolist() == [name]
    assert [text.get_text() for text in drawn.texts] == [str(e) for e in range(5)]
    assert [text.get_text() for text in drawn.get_xticklabels()] == [str(dof) for dof in range(6)]
    html = write_report(found, tmp_path / "r.html").read_text(encoding="utf-8")
    answer = re.search(r'<p class="answer">(.*?)</p>', html)[1]
    assert named(answer, "spring") == {HIT}
    assert re.search(rf'<tr class="hit">.*?<th [^>]*>(<span[^>]*>)?{name}<', html, re.DOTALL)


def test_a_spring_keeps_its_number_in_files_and_on_the_command_line(chain, tmp_path, capsys):
    model, now, found = chain
    found.save(tmp_path / "found.npz")
    assert ar.DamageResult.load(tmp_path / "found.npz").headline == found.headline
    now.save(tmp_path / "now.json")
    exact(model).save(tmp_path / "intact.json")
    (tmp_path / "job.toml").write_text(
        "[data]\nfile = 'now.json'\n[damage]\nbaseline = 'intact.json'\n[output]\nreport = false\n"
        "pictures = false\n[model]\nkind = 'chain'\nmasses_kg = [1, 1, 1, 1, 1, 1]\n"
        "springs_n_per_m = [500, 500, 500, 500, 500]\n"
    )
    assert main(["damage", str(tmp_path / "job.toml"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["damaged"] == [HIT]
    (row,) = [row for row in told["elements"] if row["stiffness_loss"]]
    assert (row["element"], row["name"]) == (HIT, f"spring {HIT}")
    assert named(told["headline"], "spring") == {HIT}
    assert {(row["dof"], row["name"]) for row in told["antiresonances"] if "name" in row} <= {
        (dof, f"mass {dof}") for dof in range(6)
    }


def test_names_lead_back_to_what_they_name(chain, frame):
    model = chain[0]
    for dof in range(model.n_dof):
        assert model.dof_label(dof) == f"mass {dof}"
        np.testing.assert_array_equal(
            model.antiresonances(model.dof_label(dof), 0), model.antiresonances(dof, 0)
        )
    factors = [make(3, bounds=(0.5, 2.0)) for make in (ar.stiffness_factor, ar.mass_factor)]
    assert ar.UpdatingProblem(model, factors, chain[1]).names == ["stiffness of spring 3", "mass 3"]
    beam = frame[0]
    assert [beam.element_label(e) for e in range(5)] == [f"element {e}" for e in range(5)]
    assert beam.mass_label(5) == "mass 0 (node 5)"  # the term of its beams come first; point_mass([0])
    assert beam.section_label(0) == "section 0"


def test_a_beam_has_one_number_and_its_nodes_theirs(frame):
    model, found = frame
    assert found.damaged == [HIT]
    assert named(found.headline, "element") == {HIT}
    assert found.hypotheses.called(found.hypotheses[0]) == f"element {HIT}"
    drawn = model.plot({HIT: 40.0})
    elements = plotting.data_of(drawn)["elements"]
    assert elements["element"].tolist() == list(range(5))
    assert elements["start_node"][HIT] == HIT
    assert {str(e) for e in range(5)} <= {text.get_text() for text in drawn.texts}


def test_errors_count_as_arguments_do(frame):
    with pytest.raises(ar.InvalidInputError, match="got element 5|stiffness term 5"):
        frame[0].with_parameters(ar.stiffness_reduction([5]), [0.1])


def test_islands_and_setups_count_as_their_arrays(chain):
    problem = ar.UpdatingProblem(chain[0], ar.stiffness_factor([0, 1], bounds=(0.5, 1.5)), chain[1])
    result = ar.update(problem, optimizer=ar.IslandGA(max_evaluations=600), rng=0)
    drawn = plotting.plot_convergence(result)
    table = plotting.data_of(drawn)["islands"]
    for island in range(result.history.cost.shape[1]):
        np.testing.assert_array_equal(table[f"island_{island}"], result.history.cost[:, island])
        assert f"island {island}" in drawn.get_legend_handles_labels()[1]
    odd = ar.AntiresonanceSet(0, {0: [10.0, 20.0, 31.0]}, std_hz={0: [0.01] * 3})
    sets = [ar.AntiresonanceSet(0, {0: [10.0 + d, 20.0, 30.0]}, std_hz={0: [0.01] * 3}) for d in (0.0, 0.005)]
    with pytest.warns(ar.AntiresWarning, match="Setup 2 disagrees"):
        ar.merge_setups([*sets, odd])

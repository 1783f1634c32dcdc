"""What is no loss of a whole element: cracks, masses, supports, sensors, a structure that warms."""

from __future__ import annotations

from functools import cache
from unittest.mock import Mock

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import antires_rs as ar
from antires_rs.damage import shape_search
from antires_rs.damage.assessor_plan import LEVELS
from antires_rs.damage.likelihood import surroundings
from antires_rs.damage.shapes import structure_of
from antires_rs.models.matrices import as_sparse

BAR = ar.Rectangle(0.04, 0.008, 7.0e10, 2700.0)
PLACES = [(0.1 * i, 0.0) for i in range(11)]
LINES = [(i, i + 1) for i in range(10)]
STD = 3e-4


def beam(**parts):
    return ar.FrameModel(PLACES, LINES, BAR, **{"fixed": [0], "ground_springs": [(7, "v", 2e4)], **parts})


def off(model, rng):
    """The same with every element's stiffness and mass a few per cent off."""
    parameters = [kind(range(10), bounds=(0.5, 2.0)) for kind in (ar.stiffness_factor, ar.mass_factor)]
    return model.with_parameters(sum(parameters, []), 1.0 + 0.02 * rng.standard_normal(20))


def measured(model, rng, nodes=(2, 4, 5, 6, 8, 9, 10), last=10):
    """Antiresonances with scatter as stated; the sensor of the last node may stand elsewhere."""
    hammer, found = model.dof(10, "v"), {}
    for node in nodes:
        label = PLAIN.dof(node, "v")
        roots = model.antiresonances(model.dof(last if node == 10 else node, "v"), hammer, f_max_hz=400.0)
        found[label] = np.sort(roots * (1.0 + STD * rng.standard_normal(roots.size)))
    return ar.AntiresonanceSet(PLAIN.dof(10, "v"), found, std_hz={dof: STD * f for dof, f in found.items()})


PLAIN = beam()


def assessed(now, before, rng, **options):
    return ar.assess_damage(PLAIN, measured(now, rng), baseline=measured(before, rng), **options)


def cracked(element, share, loss):
    """A beam with a hinge between two nodes, as flexible as a loss of the whole element."""
    stiffness = 7.0e10 * 0.04 * 0.008**3 / 12.0 / 0.1 * (1.0 - loss) / loss
    at = (PLACES[element][0] + 0.1 * share, 0.0)
    lines = [*LINES[:element], *LINES[element + 1 :], (element, 11), (12, element + 1)]
    tied = [ar.NodeSpring(11, 12, 1e8, name) for name in ("u", "v")]
    turning = ar.NodeSpring(11, 12, stiffness, "theta")
    options = {"fixed": [0], "ground_springs": [(7, "v", 2e4)], "node_springs": [*tied, turning]}
    return ar.FrameModel([*PLACES, at, at], lines, BAR, **options)


CRACK = (0, 3, 0.2, 0.3)  #: Seed, element, place as a share of it, loss.


@cache
def of_crack(seed, element, share, loss):
    """What is measured before and after, and what is found."""
    rng = np.random.default_rng(seed)
    now, before = measured(cracked(element, share, loss), rng), measured(PLAIN, rng)
    return before, now, ar.assess_damage(PLAIN, now, baseline=before)


@pytest.mark.parametrize("share", [0.2, 0.5, 0.85])
def test_a_hinge_in_the_matrices_is_one_between_two_nodes(share):
    """Against a beam that is cut in two and joined by a rotational spring."""
    loss, element = 0.35, 4
    (shape,) = structure_of(PLAIN).cracks(element, [share], {})
    flexible = loss / (1.0 - loss) / shape.size
    beta = flexible / (1.0 + flexible)
    assert shape.loss(beta) == pytest.approx(loss)
    whole = ar.MatrixModel(PLAIN.stiffness(), PLAIN.mass(), stiffness_terms=[shape.term.sparse(PLAIN.n_dof)])
    by_term = whole.with_parameters(ar.stiffness_reduction(0), beta)
    by_nodes = cracked(element, share, loss)
    # The cut changes how the mass moves: the higher the mode, the more.
    assert by_term.modes(3).freq_hz == pytest.approx(by_nodes.modes(3).freq_hz, rel=2e-3)
    assert PLAIN.modes(3).freq_hz != pytest.approx(by_nodes.modes(3).freq_hz, rel=5e-3)


@pytest.mark.parametrize(("seed", "element", "share", "loss"), [CRACK, (1, 6, 0.8, 0.2)])
def test_a_crack_is_found_in_its_element_with_its_place(seed, element, share, loss):
    *_, result = of_crack(seed, element, share, loss)
    best = result.hypotheses[0]
    assert best.elements == (element,)
    assert best.kind == "crack"
    assert best.severities[0] == pytest.approx(loss, abs=0.03)
    metres = float(best.place.split()[1])
    assert metres == pytest.approx(0.1 * share, abs=0.015)
    assert f"crack {metres:g} m" in result.headline


def test_a_mass_a_support_and_a_moved_sensor_are_named():
    rng = np.random.default_rng(5)
    before = off(PLAIN, rng)
    rng_of = np.random.default_rng
    best = assessed(off(beam(point_masses=[(4, 0.03)]), rng_of(5)), before, rng).hypotheses[0]
    assert (best.kind, best.elements) == ("mass", (-1,))
    assert "added at node 4" in best.place
    best = assessed(off(beam(ground_springs=[(7, "v", 1.4e4)]), rng_of(5)), before, rng).hypotheses[0]
    assert best.kind == "support"
    assert best.place.startswith("ground spring 0 (node 7 v) has lost")
    moved = ar.assess_damage(PLAIN, measured(before, rng, last=9), baseline=measured(before, rng))
    assert moved.hypotheses[0].kind == "sensor"
    assert "node 10 v moved" in moved.headline
    assert not moved.damaged
    more = beam(ground_springs=[(7, "v", 1.4e4)]).with_parameters(ar.stiffness_reduction(2), 0.25)
    result = ar.assess_damage(PLAIN, measured(more, rng_of(4)), baseline=measured(PLAIN, rng_of(2)))
    assert (result.hypotheses[0].kind, "temperature" in result.headline) == ("support", False)


def test_temperature_beside_damage():
    rng = np.random.default_rng(7)
    before = off(PLAIN, rng)
    hurt = before.with_parameters(ar.stiffness_reduction(4), 0.2)
    result = assessed(warmer(hurt, -0.025), before, rng, environment=("temperature",))
    assert result.damaged == [4]
    low, high = result.interval[4]
    assert low < 0.2 < high
    warm = warmer(before, -0.02)  # and no damage
    assert not assessed(warm, before, rng, environment=("temperature",)).damaged
    how = {"baseline": measured(before, rng), "search": ar.SearchOptions(environment=("temperature",))}
    assert not ar.Assessor(PLAIN, **how).assess(measured(warm, rng)).damaged
    with pytest.raises(ar.InvalidInputError, match=r"environment: got .*wind.*wanted a list of some of"):
        assessed(before, before, rng, environment=("wind",))


def warmer(model, by):
    """With another modulus of all elements."""
    return model.with_parameters(ar.stiffness_factor(range(10), bounds=(0.1, 2.0)), np.full(10, 1.0 + by))


@pytest.mark.parametrize(("seed", "by", "said"), [(2, 0.025, ("temperature",)), (1, -0.05, None)])
def test_a_loss_beside_temperature_is_where_the_values_are_most_probable(seed, by, said):
    """Two roots of the beam nearly meet, and are not linear in what moves all of them."""
    rng = np.random.default_rng(seed)
    before = off(PLAIN, rng)
    now = warmer(before, by).with_parameters(ar.stiffness_reduction(4), 0.2)
    result = assessed(now, before, rng, environment=said)
    assert (result.damaged, result.severity[4]) == ([4], pytest.approx(0.2, abs=0.005))


def test_supports_that_may_differ_are_no_damage_be_they_right_in_the_model():
    rng = np.random.default_rng
    before, now = (off(beam(ground_springs=[(7, "v", k)]), rng(3)) for k in (2e4, 1.85e4))
    best = assessed(now, before, rng(103), environment=("supports",)).hypotheses[0]
    assert (best.elements, best.probability > 0.99) == ((), True)
    hurt = now.with_parameters(ar.stiffness_reduction(4), 0.2)
    assert assessed(hurt, before, rng(104), environment=("supports",)).damaged == [4]


def test_what_warms_and_by_how_much():
    """A joint of constant flexibility in series with a beam; elements of matrices by their order."""
    one = ar.stiffness_factor([0, 1, 2], bounds=(0.1, 5.0))
    step = 1e-5
    warmth = [np.log(1.0 - by + by / (1.0 + 0.4 * by)) for by in (1.0, 1.0 + step)]
    columns = surroundings({0}, 2, [2], one, np.array([1.0, 1.0, np.exp(warmth[0])]), ("temperature",), None)
    of_joint = (warmth[1] - warmth[0]) / step
    assert columns[:, 0] / columns[0, 0] == pytest.approx([1.0, 0.0, of_joint], rel=1e-3)
    chain = ar.MassSpringChain(np.ones(7), np.full(6, 1e4), ground_first_n_per_m=8e3)
    gone = (chain.with_parameters(ar.stiffness_reduction(e), 1.0) for e in (0, 2, 4, 5, 3, 1))
    terms = [chain.stiffness() - each.stiffness() for each in gone]
    places = structure_of(ar.MatrixModel(chain.stiffness(), chain.mass(), stiffness_terms=terms)).along
    assert np.argsort(places).tolist() in ([0, 5, 1, 4, 2, 3], [3, 2, 4, 1, 5, 0])


def test_supports_of_bars_rollers_and_a_base_are_seen_in_the_models():
    """Bars on the ground are those of its ground springs; a pin yields by what its beams hold it with; a base
    on a spring is as a softer lowest storey."""
    chain = ar.MassSpringChain(np.ones(7), np.full(6, 1e4), ground_first_n_per_m=8e3)
    assert structure_of(chain).grounded == [6]
    held = [(0, "u"), (0, "v"), (4, "v")]
    places, lines = [(0.2 * i, 0.0) for i in range(5)], [(i, i + 1) for i in range(4)]
    beam = structure_of(ar.FrameModel(places, lines, BAR, fixed=held))
    pins = [shape for shape in beam.shapes({}) if shape.kind == "support"]
    assert [shape.name for shape in pins] == [f"support at node {n}" for n in ("0 (u)", "0 (v)", "4 (v)")]
    loose = ar.FrameModel(beam.nodes, beam.ends, BAR, fixed=held[:2])
    whole, at = loose.stiffness().toarray(), loose.dof(4, "v")
    rest = np.delete(np.arange(loose.n_dof), at)
    free = whole[np.ix_(rest, rest)] - np.outer(whole[rest, at], whole[at, rest]) / whole[at, at]
    yielded = beam.model.stiffness().toarray()
    rows, columns, values = pins[2].term
    np.subtract.at(yielded, (rows, columns), values)
    np.testing.assert_allclose(yielded, free, atol=1e-9 * np.abs(free).max())
    based = structure_of(chain).based(lambda structure: 0.0)
    k, m = (as_sparse(each).toarray() for each in (based.finer._core.stiffness(), based.finer._core.mass()))
    assert m[7, 7] == 1.0
    assert k[7, 7] == pytest.approx(8e3 * 31.0)
    folded = k[:7, :7] - np.outer(k[:7, 7], k[7, :7]) / k[7, 7]
    assert folded[0, 0] == pytest.approx(1e4 + 8e3 / (1.0 + 1.0 / 30.0))
    named = [shape.name for shape in based.shapes({})[-2:]]
    assert named == ["spring under the base", "base against tilting"]


def bars(places, lines, free):
    """A pin-jointed plane truss as matrices, masses of bars coupled as they are."""
    mass, terms = 2.0 * np.eye(len(free)), []
    for line in lines:
        along = np.subtract(*(places[node] for node in line[::-1]))
        rows = np.array([[float(each == (node, name)) for each in free] for node in line for name in "uv"])
        stretch = rows.T @ [*-along, *along] / np.linalg.norm(along)
        terms.append(1e6 * np.outer(stretch, stretch))
        mass += rows.T @ np.kron([[0.2, 0.1], [0.1, 0.2]], np.eye(2)) @ rows
    return ar.MatrixModel(sum(terms), mass, stiffness_terms=terms)


def test_trusses_by_matrices_have_nodes_and_a_ground():
    """Two dofs of a node get a mass together; a bar on the ground is seen at any angle."""
    places = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0), (2.0, 0.0), (2.0, 1.0), (3.0, 0.0), (3.0, 1.0)]
    lines = [(0, 2), (1, 2), (1, 3), (2, 3), (2, 4), (3, 5), (2, 5), (4, 5), (4, 6), (5, 7), (4, 7), (6, 7)]
    free = [(node, name) for node in range(2, 8) for name in "uv"]
    truss = structure_of(bars(places, lines, free))
    assert truss.grounded == [0, 1, 2]  # the second at -45 degrees
    names = [shape.name for shape in truss.shapes({})]
    assert {f"dof {k} and dof {k + 1}" for k in range(0, 12, 2)} <= {*names}


def test_what_moves_all_values_of_an_intact_test_is_no_scatter_of_each():
    rng = np.random.default_rng(7)
    before = off(PLAIN, rng)
    cold = [measured(warmer(before, k * 0.01), rng) for k in (-1, 0, 1)]
    now = warmer(before, 0.006).with_parameters(ar.stiffness_reduction(4), 0.1)
    result = ar.assess_damage(PLAIN, measured(now, rng), baseline=cold)
    assert (result.damaged, result.assessment.scatter) == ([4], pytest.approx(1.0, abs=0.3))
    assert result.interval[4][0] < 0.1 < result.interval[4][1]
    assert max(result.detectable[e] for e in range(9)) < 0.03
    assert "differ by the stiffness of all elements together" in result.summary()
    none = ar.assess_damage(PLAIN, measured(warmer(before, 0.006), rng), baseline=cold)
    assert (none.damaged, none.hypotheses[0].elements) == ([], ())


def test_what_springs_yield_is_learned_from_the_baseline():
    """A support of the model that is off by a third makes no element wrong."""
    rng = np.random.default_rng(11)
    truth = beam(ground_springs=[(7, "v", 1.3e4)])
    damaged = truth.with_parameters(ar.stiffness_reduction(2), 0.25)
    result = assessed(damaged, truth, rng)
    assert result.damaged == [2]
    assert result.assessment.factor_std < 0.02
    assert result.severity[2] == pytest.approx(0.25, abs=0.02)


def test_an_assessor_finds_the_crack_from_its_tables():
    before, now, result = of_crack(*CRACK)
    assessor = ar.Assessor(PLAIN, baseline=before)
    best, full = (one.hypotheses[0] for one in (assessor.assess(now), result))
    assert best.kind == full.kind == "crack"
    assert best.elements == full.elements == (3,)
    assert abs(best.severities[0] - full.severities[0]) < 0.05
    plan = assessor._plan
    likelihood = shape_search.with_shapes(plan.prepared, plan.question, plan.cracks[3])
    (roots,) = likelihood.roots(np.pad([0.0] * 4 + [0.5], (10, 6))[None], slopes=False)
    row, loss = plan.tables.place[10 + 3 * 11 + 4] - plan.tables.beside[3], plan.cracks[3][4].loss(0.5)
    shown = plan.tables.there[3].all(axis=0) & plan.tables.there[10 + 3 * 11 + 4].all(axis=0)
    expected = CubicSpline(LEVELS, row[:, shown])(-np.log1p(-loss))
    apart = np.abs(roots.log_f[:, None] - expected).min(axis=0)
    assert shown.sum() > 5
    assert apart.max() < 1e-4


def test_cracks_have_the_same_intervals_by_either_method_and_no_profile():
    *_, result = of_crack(*CRACK)
    sure = result.intervals("ensemble", rng=0)
    assert (sure[3], "Cracks are not sampled" in str(sure)) == (result.interval[3], True)
    with pytest.raises(ar.InvalidInputError, match="wanted a loss of a whole element"):
        result.profile("stiffness loss of element 3")


def test_candidates_alone_are_declared_springs_among_them():
    rng = np.random.default_rng(1)
    soft = assessed(beam(ground_springs=[(7, "v", 1e4)]), PLAIN, rng, elements=[10, 3, 5])
    assert (soft.damaged, "support" in {row.kind for row in soft.hypotheses}) == ([10], False)
    two = cracked(3, 0.2, 0.3).with_parameters(ar.stiffness_reduction(7), 0.3)
    rows = assessed(two, PLAIN, rng, elements=[1, 2]).hypotheses
    assert all({*row.elements} <= {1, 2} for row in rows if row.candidate)


def test_a_sensor_that_moved_may_leave_some_of_its_values():
    rng = np.random.default_rng(3)
    before, now = measured(PLAIN, rng), measured(PLAIN, rng)
    shifted = {dof: np.array(now[dof]) for dof in now}
    label = max(now, key=lambda dof: now[dof].size)
    shifted[label][:2] *= [1.04, 0.97]
    std = {dof: STD * f for dof, f in shifted.items()}
    now = ar.AntiresonanceSet(now.excitation, shifted, std_hz=std)
    moved = f"sensor at {PLAIN.dof_label(label)} moved"
    assert moved in ar.assess_damage(PLAIN, now, baseline=before).headline


def test_what_was_found_before_ctrl_c_stays(monkeypatch):
    monkeypatch.setattr(shape_search, "_refined", Mock(side_effect=KeyboardInterrupt))
    assert "was stopped" in assessed(cracked(3, 0.2, 0.3), PLAIN, np.random.default_rng(0)).headline


def test_a_sensor_that_moved_is_one_for_all_forces():
    chain = ar.MassSpringChain(np.ones(6), np.full(5, 1e4), ground_first_n_per_m=8e3)
    rng, sets = np.random.default_rng(3), []
    for moved, force in ((0.0, 0), (0.0, 2), (0.03, 0), (0.03, 2)):
        found = {dof: chain.antiresonances(dof, force) * (1.0 + STD * rng.normal()) for dof in range(4)}
        found[2] = found[2] * (1.0 + moved * np.sin(7.0 * found[2]))
        sets.append(ar.AntiresonanceSet(force, found, std_hz={dof: STD * f for dof, f in found.items()}))
    assert "sensor at mass 2 moved" in ar.assess_damage(chain, sets[2:], baseline=sets[:2]).headline


def test_long_elements_move_between_their_nodes_as_a_finer_mesh_does():
    """And an end that turns on a spring is one on a spring to ground."""

    def modes(joined):
        matrices = (as_sparse(columns) for columns in (joined._core.stiffness(), joined._core.mass()))
        return ar.MatrixModel(*matrices).modes(7).freq_hz

    coarse = ar.FrameModel(PLACES[::2], LINES[:5], BAR, fixed=[0])
    places = [(0.025 * i, 0.0) for i in range(41)]
    fine = ar.FrameModel(places, [(i, i + 1) for i in range(40)], BAR, fixed=[0]).modes(7).freq_hz
    frame = structure_of(coarse, 600.0)
    assert np.abs(coarse.modes(7).freq_hz / fine - 1.0).max() > 5e-3
    assert modes(frame.finer) == pytest.approx(fine, rel=1e-3)
    spring = ar.GroundSpring(0, "theta", 12.0 * 7.0e10 * 0.04 * 0.008**3 / 12.0 / 0.1)
    held = ar.GroundSpring(7, "v", 2e4)
    turning = beam(fixed=[(0, ("u", "v"))], ground_springs=[held, spring]).modes(7).freq_hz
    hinged = structure_of(PLAIN).hinged(lambda one: abs(modes(one.finer or PLAIN)[0] - turning[0]))
    assert hinged.hinge_nodes
    assert modes(hinged.finer) == pytest.approx(turning, rel=1e-6)

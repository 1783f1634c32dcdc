"""What pictures offer: their numbers, legends that fit, and axes that cut nothing."""

import numpy as np
import pytest
from matplotlib.figure import Figure

import antires_rs as ar
from antires_rs import figures as plotting
from antires_rs.figures.canvas import below, picture
from antires_rs.signals.data_check import check_data
from tests.support.four_masses import BAND, chain, exact


@pytest.fixture
def ax():
    return Figure(figsize=(9.0, 4.5), layout="constrained").subplots()


@pytest.fixture(scope="module")
def damage():
    return ar.assess_damage(chain(), exact(chain([500.0, 270.0, 520.0])), rng=0, workers=1)


@pytest.fixture(scope="module")
def diagram(identified):
    return identified.diagrams[1]


def drawn(record, damage, diagram):
    """Every picture by the names of its tables."""
    two = {"one": damage, "other": damage}
    sets = [ar.AntiresonanceSet(0, {0: [f]}, std_hz={0: [0.1]}) for f in (8.7, 8.6)]
    frame = ar.FrameModel(
        [(0, 0), (1, 0), (1, 1)], [(0, 1), (1, 2)], ar.Tube(0.038, 0.0015, 2.1e11, 7850.0), fixed=[0]
    )
    known = ar.identifiability(ar.cases.chain8().updating_problem(), points=4, forces=[], sensors=[])
    plan = ar.plan_test(chain(), n_sensors=2, excitations=0)
    curves = ar.detectability(chain(), excitation=0, std=5e-4, n_tests=1, rng=0)
    h = ar.frf(record, nperseg=512)
    t, check = ar.transmissibility(record, 0, nperseg=512), check_data(record, band_hz=BAND)
    scattered = 1.0 + 1e-3 * np.random.default_rng(0).standard_normal(60)
    watched = ar.monitor([ar.AntiresonanceSet(0, {0: [8.7 * one]}) for one in scattered], baseline=50)
    return [
        (["poles", "values", "curve"], lambda ax: plotting.plot_stabilization(diagram, ax=ax)),
        (["poles", "values"], lambda ax: plotting.plot_damping_clusters(diagram, ax=ax)),
        (["coherence"], lambda ax: plotting.plot_coherence(ar.frf(record, nperseg=512), ax=ax)),
        (["singular_values"], lambda ax: plotting.plot_singular_values(check, ax=ax)),
        (
            ["transmissibility"],
            lambda ax: plotting.plot_transmissibility(t, chain(), dof=2, excitation=0, ax=ax),
        ),
        (["responses"], lambda ax: plotting.plot_responses(h, chain(), excitation=0, ax=ax)),
        (["bars"], lambda ax: plotting.plot_differences(damage.table, ax=ax)),
        (["bars"], lambda ax: plotting.plot_damage(damage, ax=ax, truth={1: 0.4})),
        (["bars"], lambda ax: plotting.plot_damages(two, ax=ax)),
        (["hypotheses"], lambda ax: plotting.plot_hypotheses(damage.hypotheses, ax=ax)),
        (["elements"], lambda ax: plotting.plot_frame(frame, {1: 0.4}, ax=ax)),
        (["springs"], lambda ax: plotting.plot_chain(chain(), damage.severity, ax=ax)),
        (["islands", "migrations"], lambda ax: plotting.plot_convergence(damage, ax=ax)),
        (["pairs"], lambda ax: plotting.plot_comparison(ar.compare(*sets), ax=ax)),
        (["parameters"], lambda ax: plotting.plot_identifiability(known, ax=ax)),
        (["elements"], lambda ax: plotting.plot_plan(plan, ax=ax)),
        (["curves"], lambda ax: plotting.plot_detectability(curves, ax=ax)),
        (["T2"], lambda ax: plotting.plot_monitor(watched, ax=ax)),
        (["tracks"], lambda ax: plotting.plot_tracks(ar.track(sets), ax=ax)),
    ]


def test_every_public_picture_offers_its_numbers_in_whole_tables(record, damage, diagram):
    pictures = drawn(record, damage, diagram)
    assert len(pictures) == sum(name.startswith("plot_") for name in plotting.__all__)
    for tables, draw in pictures:
        data = plotting.data_of(draw(Figure().subplots()))
        assert list(data) == tables
        for table in data.values():
            lengths = {len(column) for column in table.values()}
            assert len(lengths) == 1
            for column in table.values():
                assert isinstance(column, np.ndarray)
                assert not column.flags.writeable


def test_the_numbers_are_those_drawn(damage, diagram, record, ax):
    bars = plotting.data_of(damage.plot(ax=ax, truth={1: 0.4}))["bars"]
    np.testing.assert_array_equal(bars["loss_percent"], [bar.get_height() for bar in ax.containers[0]])
    np.testing.assert_allclose(bars["smallest_seen_percent"], [100 * v for v in damage.detectable.values()])
    np.testing.assert_array_equal(bars["truth_percent"], [np.nan, 40.0, np.nan])
    poles = plotting.data_of(diagram.plot(ax=Figure().subplots()))["poles"]
    assert poles["stable"].sum() == sum(int(s.sum()) for s in diagram.stable)
    resp = ar.frf(record, nperseg=512)
    seen = plotting.plot_coherence(resp, band_hz=BAND, ax=Figure().subplots())
    coherence = plotting.data_of(seen)["coherence"]
    shown = (resp.freq_hz >= BAND[0]) & (resp.freq_hz <= BAND[1])
    np.testing.assert_array_equal(coherence["2"], resp.coherence[2, shown])


def test_the_numbers_are_copies(ax):
    chain_of_two = ar.MassSpringChain([1.0, 1.0, 1.0], [500.0, 500.0])
    values = np.array([1.0, 2.0])
    plotting.plot_chain(chain_of_two, values, ax=ax)
    values[:] = 0.0
    assert plotting.data_of(ax)["springs"]["value"].tolist() == [1.0, 2.0]


def test_axes_of_others_have_none(ax):
    with pytest.raises(ar.InvalidInputError, match="plot_ function"):
        plotting.data_of(ax)
    with pytest.raises(ar.InvalidInputError, match="plot_ function"):
        plotting.data_of(None)


@pytest.mark.parametrize("letters", [4, 20, 60])
def test_a_legend_never_outgrows_its_picture(ax, letters):
    for i in range(6):
        ax.plot([0, 1], [0, i], label=f"{i}" * letters)
    below(ax)
    ax.figure.draw_without_rendering()
    box = ax.get_legend().get_window_extent()
    assert box.x0 >= 0.0
    assert box.x1 <= ax.figure.bbox.width


def test_what_is_seen_only_above_the_axis_is_named_at_its_edge(damage, ax, monkeypatch):
    monkeypatch.setitem(damage.__dict__, "_detectable", (0.05, 0.02, 0.96))
    monkeypatch.setitem(damage.__dict__, "x", np.array([0.0, 0.03, 0.0]))
    damage.plot(ax=ax)
    top = ax.get_ylim()[1]
    assert 25.0 < top < 40.0  # a loss of 3 % stays a bar
    ticks = [segment[0, 1] for line in ax.collections for segment in line.get_segments()]
    assert max(ticks) <= top
    assert "96" in [text.get_text() for text in ax.texts]
    assert "seen only from this loss on, in %" in [text.get_text() for text in ax.get_legend().get_texts()]


@pytest.mark.parametrize(("names", "upright"), [(7, False), (30, True)])
def test_names_stand_upright_where_they_would_run_into_each_other(names, upright):
    springs = np.full(names, 500.0)
    model = ar.MassSpringChain(np.ones(names + 1), springs)
    result = ar.assess_damage(
        model, exact(model, [0, 1]), rng=0, workers=1, optimizer=ar.IslandGA(max_evaluations=500)
    )
    ax = Figure(figsize=(8.0, 4.0)).subplots()
    result.plot(ax=ax)
    ax.figure.draw_without_rendering()
    ticks = ax.get_xticklabels()
    assert {tick.get_rotation() for tick in ticks} == {90.0 if upright else 0.0}
    boxes = [tick.get_window_extent() for tick in ticks]
    assert all(left.x1 <= right.x0 for left, right in zip(boxes, boxes[1:], strict=False))


def test_many_differences_keep_room_between_the_names_of_responses(ax):
    model = ar.MassSpringChain(np.ones(31), np.full(30, 500.0))
    problem = ar.UpdatingProblem(
        ar.MassSpringChain(np.ones(31), np.full(30, 520.0)),
        ar.stiffness_factor([0], bounds=(0.8, 1.2)),
        exact(model, range(31)),
    )
    table = ar.update(problem, rng=0, workers=1, optimizer=ar.IslandGA(max_evaluations=200)).table
    plotting.plot_differences(table, ax=ax)
    ax.figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in ax.texts]
    assert len(boxes) > 5
    assert all(left.x1 <= right.x0 for left, right in zip(boxes, boxes[1:], strict=False))
    assert list(ax.get_xticks()) == []
    before, after = (container[0].get_facecolor() for container in ax.containers)
    assert abs(np.dot(before[:3], [0.3, 0.6, 0.1]) - np.dot(after[:3], [0.3, 0.6, 0.1])) > 0.3  # in grey too


@pytest.mark.parametrize("ground", [{}, {"ground_first_n_per_m": 80.0, "ground_last_n_per_m": 90.0}])
def test_a_chain_shows_the_springs_it_has(ax, ground):
    model = ar.MassSpringChain([1.0, 1.0, 1.0], [500.0, 400.0], **ground)
    plotting.plot_chain(model, {1: 0.3}, ax=ax, sensors=[0, 2], excitation=1)
    springs = plotting.data_of(ax)["springs"]
    assert springs["element"].tolist() == ([0, 1, 2, 3] if ground else [0, 1])
    assert springs["name"][1] == "spring 1"
    assert np.isfinite(springs["value"]).tolist() == [False, True, False, False][: len(springs["value"])]
    names = [text.get_text() for text in ax.get_legend().get_texts()]
    assert set(names) == {"without a value", "accelerometer", "force"}
    assert [text.get_text() for text in ax.texts].count("ground") == len(ground)


def test_a_chain_refuses_what_it_does_not_have(ax):
    with pytest.raises(ar.InvalidInputError, match=r"an array \(3,\)"):
        plotting.plot_chain(chain(), [1.0, 2.0], ax=ax)
    with pytest.raises(ar.InvalidInputError, match="excitation"):
        plotting.plot_chain(chain(), ax=ax, excitation=9)


def test_no_loss_at_all_has_no_scale_that_pretends(ax):
    plotting.plot_chain(chain(), {0: 0.0, 1: 0.0, 2: 0.0}, ax=ax, label="Stiffness loss (%)")
    assert ax.get_title() == "Stiffness loss (%): 0 in every element"
    assert len(ax.figure.axes) == 1  # no colour bar


def test_sections_are_told_apart_without_colour(ax):
    pipe = {name: ar.Tube(0.03, 0.001 + 0.0001 * i, 2.1e11, 7850.0) for i, name in enumerate("abcde")}
    nodes = [(float(i), 0.0) for i in range(11)]
    model = ar.FrameModel(nodes, [(i, i + 1, "abcde"[i // 2]) for i in range(10)], pipe, fixed=[0])
    model.plot(ax=ax)
    named = [line for line in ax.lines if line.get_label() in pipe]
    assert len({(line.get_linestyle(), str(line._dash_pattern)) for line in named}) == 5


def test_the_last_step_of_a_search_is_inside_the_axes(damage, ax):
    plotting.plot_convergence(damage, ax=ax)
    assert ax.get_xlim()[1] > damage.history.nfev[-1]


@pytest.mark.parametrize("size", [(9.0, 4.5), (4.0, 3.0)])
def test_pictures_render_at_any_size(damage, size):
    assert picture(lambda ax: damage.plot(ax=ax), size, dpi=40).startswith(b"\x89PNG")

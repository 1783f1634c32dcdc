"""Pictures: what is drawn, with which units, into which axes."""

import sys

import numpy as np
import pytest
from matplotlib.figure import Figure

import antires_rs as ar
from antires_rs import figures as plotting
from antires_rs.figures.canvas import picture
from antires_rs.figures.marks import spread
from tests.support.four_masses import DOFS, SPRINGS, chain, exact


@pytest.fixture
def ax():
    return Figure().subplots()


@pytest.fixture(scope="module")
def updated():
    nominal = ar.MassSpringChain(np.ones(4), np.full(3, 500.0))
    problem = ar.UpdatingProblem(nominal, ar.stiffness_factor(range(3), bounds=(0.8, 1.2)), exact(chain()))
    return ar.update(problem, rng=0, workers=1)


@pytest.fixture(scope="module")
def damage():
    return ar.assess_damage(chain(), exact(chain(SPRINGS * [1.0, 0.6, 1.0])), rng=0, workers=1)


def labels(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def texts(ax):
    return [text.get_text() for text in ax.texts]


@pytest.fixture
def draw(identified, record, updated, damage):
    t = ar.transmissibility(record, 0, nperseg=512)
    return {
        "stabilization": lambda ax: plotting.plot_stabilization(identified.diagrams[0], ax=ax),
        "transmissibility": lambda ax: plotting.plot_transmissibility(t, chain(), dof=2, excitation=0, ax=ax),
        "differences": lambda ax: plotting.plot_differences(updated.table, ax=ax),
        "damage": lambda ax: plotting.plot_damage(damage, ax=ax),
        "convergence": lambda ax: plotting.plot_convergence(updated, ax=ax),
    }


NAMES = ["stabilization", "transmissibility", "differences", "damage", "convergence"]


@pytest.mark.parametrize("name", NAMES)
def test_every_picture_draws_into_the_axes_given_and_labels_units(draw, ax, name):
    assert draw[name](ax) is ax
    for text in (ax.get_ylabel(), *([] if name == "damage" else [ax.get_xlabel()])):
        assert any(unit in text for unit in ("(Hz)", "(%)", "(-)", "(dB re 1)")), text
    ax.figure.canvas.draw()  # nothing that only fails when it is rendered


@pytest.mark.parametrize("name", NAMES)
def test_without_axes_a_pyplot_figure_is_made_and_no_setting_changed(draw, name):
    import matplotlib
    from matplotlib import pyplot

    before = dict(matplotlib.rcParams)
    made = draw[name](None)
    try:
        assert pyplot.fignum_exists(made.figure.number)
        assert dict(matplotlib.rcParams) == before
    finally:
        pyplot.close(made.figure)


def test_with_axes_pyplot_learns_of_nothing(draw):
    from matplotlib import pyplot

    for function in draw.values():
        picture(function, (6.0, 4.0), dpi=50)
    assert pyplot.get_fignums() == []


def test_the_same_picture_has_the_same_bytes(draw):
    first, second = (picture(draw["damage"], (6.0, 4.0), dpi=50) for _ in range(2))
    assert first == second
    assert first.startswith(b"\x89PNG")


@pytest.mark.parametrize("name", NAMES)
def test_matplotlib_missing_names_the_extra(draw, monkeypatch, name):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(ar.MissingDependencyError, match=r'pip install "antires-rs\[plot\]"'):
        draw[name](None)


def test_stabilization_counts_poles_and_names_the_accepted(identified, ax):
    diagram = identified.diagrams[0]
    plotting.plot_stabilization(diagram, ax=ax)
    unstable, stable = ax.lines[:2]
    assert len(stable.get_xdata()) == sum(int(s.sum()) for s in diagram.stable)
    assert len(unstable.get_xdata()) + len(stable.get_xdata()) == sum(map(len, diagram.freq_hz))
    assert texts(ax) == [f"{f:.2f} Hz" for f in diagram.identified]
    assert len(diagram.identified) == 3
    assert ax.get_xlim() == diagram.band_hz


def test_stabilization_without_an_antiresonance_says_so(identified, ax):
    assert identified.diagrams[3].identified.size == 0
    plotting.plot_stabilization(identified.diagrams[3], ax=ax)
    assert ax.get_title() == "no antiresonance accepted in this band"
    assert texts(ax) == []


def test_transmissibility_of_the_very_model_lies_on_the_measurement(ax):
    freq = np.linspace(0.5, 9.0, 300)
    h = chain().frf(DOFS, 0, freq, damping_ratio=0.01)
    t = ar.FrequencyResponse(freq, h / h[1], DOFS, "transmissibility", 1)
    other = chain(1.1 * SPRINGS)
    plotting.plot_transmissibility(t, other, chain(), dof=3, excitation=0, ax=ax)
    measured, before, after = (line.get_ydata() for line in ax.lines)
    np.testing.assert_allclose(after, measured, atol=1e-9)
    assert np.abs(before - measured).max() > 1.0
    assert measured[0] == pytest.approx(20 * np.log10(abs(h[3, 0] / h[1, 0])))


def test_transmissibility_sum_peaks_at_the_antiresonances_and_leaves_out_0_hz(ax):
    freq = np.linspace(0.0, 9.0, 9001)
    h = chain().frf(DOFS, 0, freq[1:], damping_ratio=0.002)
    values = np.hstack([np.ones((4, 1)), h / h[0]])
    t = ar.FrequencyResponse(freq, values, DOFS, "transmissibility", 0)
    plotting.plot_transmissibility(t, chain(), dof=None, excitation=0, damping_ratio=0.002, ax=ax)
    x, y = ax.lines[0].get_data()
    assert x[0] > 0.0
    peaks = x[1:-1][(y[1:-1] > y[:-2]) & (y[1:-1] > y[2:])]
    np.testing.assert_allclose(peaks, chain().antiresonances(0, 0), rtol=1e-3)


@pytest.mark.parametrize(("dof", "said"), [(0, "reference"), (9, r"\[1, 2, 3\]")])
def test_transmissibility_refuses_a_dof_it_cannot_draw(record, dof, said):
    t = ar.transmissibility(record, 0, nperseg=512)
    with pytest.raises(ar.InvalidInputError, match=said):
        plotting.plot_transmissibility(t, chain(), dof=dof, excitation=0)


def test_transmissibility_refuses_frfs(record):
    with pytest.raises(ar.InvalidInputError, match="transmissibility"):
        plotting.plot_transmissibility(ar.frf(record, nperseg=512), chain(), dof=1, excitation=0)


def test_differences_are_the_tables_and_grouped_by_response(updated, ax):
    table = updated.table
    plotting.plot_differences(table, ax=ax)
    before, after = ax.containers
    np.testing.assert_allclose([bar.get_height() for bar in before], table.before_percent)
    np.testing.assert_allclose([bar.get_height() for bar in after], table.after_percent, atol=1e-12)
    assert texts(ax) == ["mass 0", "1", "2"]  # mass 3 has none
    assert f"{table.largest_before_percent:.2f} %" in labels(ax)[0]
    assert before[0].get_hatch()
    assert not after[0].get_hatch()  # told apart without colour


def test_differences_mark_what_has_no_partner(ax):
    columns = ([0, 0, 1], [0, 0, 0], [10.0, 20.0, 15.0], [10.4, np.nan, 15.3], [np.nan, np.nan, np.nan])
    plotting.plot_differences(ar.FrequencyTable(*map(np.array, columns)), ax=ax)
    assert len(ax.containers[0]) == 2
    assert "before updating: no partner (1)" in labels(ax)
    assert "after updating, no partner at all" in labels(ax)


def test_differences_of_several_forces_name_both_dofs(ax):
    columns = ([0, 1, 1], [0, 0, 2], [10.0, 20.0, 15.0], [10.4, 20.0, 15.3], [10.0, 20.0, 15.0])
    plotting.plot_differences(ar.FrequencyTable(*map(np.array, columns)), ax=ax)
    assert texts(ax) == ["0, 0", "1, 0", "1, 2"]
    assert "response and force dof" in ax.get_xlabel()


def test_damage_has_one_bar_an_element_and_prints_the_severity(damage, ax):
    plotting.plot_damage(damage, ax=ax, truth={0: 0.0, 1: 0.4, 2: 0.0})
    heights = [bar.get_height() for bar in ax.containers[0]]
    np.testing.assert_allclose(heights, 100 * damage.x)
    assert heights == pytest.approx([0.0, 40.0, 0.0], abs=0.5)
    assert texts(ax) == [f"{100 * damage.x[1]:.1f} %"]
    assert [tick.get_text() for tick in ax.get_xticklabels()] == ["spring 0", "spring 1", "spring 2"]
    assert labels(ax) == ["found", "truth", "smallest damage that would be seen"]


def test_no_damage_is_no_picture_of_damage(ax):
    result = ar.assess_damage(chain(), exact(chain()), rng=0, workers=1)
    result.plot(ax=ax)
    assert ax.get_title() == "no damage found"
    assert texts(ax) == []
    assert ax.get_ylim()[1] >= 10.0


def test_an_element_that_nothing_shows_is_marked(ax):
    result = ar.assess_damage(chain(), exact(chain(), [2]), elements=[0, 1, 2], rng=0, workers=1)
    assert not np.isfinite(result.detectable[0])  # H_31 does not depend on it
    result.plot(ax=ax)
    assert "no damage could be seen" in labels(ax)


def test_many_elements_stay_legible(ax):
    springs = np.full(24, 500.0)
    springs[7] *= 0.6
    result = ar.assess_damage(
        ar.MassSpringChain(np.ones(25), np.full(24, 500.0)),
        exact(ar.MassSpringChain(np.ones(25), springs), [0, 6, 12]),
        rng=0,
        workers=1,
        optimizer=ar.IslandGA(max_evaluations=2000),
    )
    plotting.plot_damage(result, ax=ax)
    assert len(ax.containers[0]) == 24
    assert {tick.get_rotation() for tick in ax.get_xticklabels()} == {90.0}


def test_convergence_shows_each_island_and_the_migrations(damage, ax):
    damage = ar.update(damage.problem, optimizer=ar.IslandGA(polish=False, patience=5), rng=0, workers=1)
    plotting.plot_convergence(damage, ax=ax)
    history = damage.history
    assert len(history.migrations) > 0
    assert len([name for name in labels(ax) if name.startswith("island")]) == history.cost.shape[1]
    assert f"migration ({len(history.migrations)} in all)" in labels(ax)
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), history.cost[:, 0])
    assert damage.message in ax.get_title()


def test_convergence_of_any_search_down_to_zero(ax):
    ga = ar.IslandGA(islands=9, max_evaluations=3000)
    found = ga.minimize(lambda x: float(np.abs(x).sum()), [(0, 1)] * 2, rng=0)
    plotting.plot_convergence(found, ax=ax)
    assert found.fun == 0.0
    assert ax.get_yscale() == "linear"  # zero has no place on a logarithmic axis
    assert len(ax.lines) >= 9


@pytest.mark.parametrize("n", [1, 2, 7, 30])
def test_spread_keeps_order_distance_and_limits(n):
    rng = np.random.default_rng(n)
    where = np.sort(rng.uniform(0.0, 10.0, n))
    moved = spread(where, 0.2, 0.0, 10.0)
    assert np.all(np.diff(moved) >= 0.2 - 1e-12)
    assert moved.min() >= 0.0
    assert moved.max() <= 10.0
    far = np.arange(n) * 0.3
    np.testing.assert_allclose(spread(far, 0.2, 0.0, 10.0), far)  # nothing moves without need

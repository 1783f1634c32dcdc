"""Pictures: what is drawn, with which units, and into which axes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot, rcParams
from matplotlib.figure import Figure

import antires_rs as ar
from antires_rs import figures
from antires_rs.figures.canvas import dash_of, picture
from antires_rs.figures.damage import probabilities
from antires_rs.figures.identification import LOOKS
from antires_rs.figures.marks import COLOURS
from antires_rs.signals.data_check import check_data
from tests.support import every_picture, four_masses
from tests.support.four_masses import BAND, DOFS, SPRINGS, chain, exact
from tests.support.refusals import refused
from tests.support.snapshots import refusal, replay

PICTURES = {  #: Every public picture: the units in its labels.
    **{"stabilization": ("(Hz)", "(-)"), "singular_values": ("(Hz)", "(dB re noise power)")},
    **{"responses": ("(Hz)", "(dB)"), "differences": ("(Hz)", "(%)"), "damage": ("", "(%)")},
    **{"hypotheses": ("Probability", ""), "frame": ("(m)", "(m)"), "chain": ("", ""), "mesh": ("view", "")},
    **{"convergence": ("(-)", "(-)"), "comparison": ("(Hz)", "(%)"), "identifiability": ("%", "")},
    **{"plan": ("", "(%)"), "detectability": ("(%)", "(%)"), "monitor": ("Test", "limit")},
    "tracks": ("Test", "(%)"),
}


def labels(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def texts(ax):
    return [text.get_text() for text in ax.texts]


def line_of(ax, label):
    return next(line for line in ax.lines if line.get_label() == label)


def distinct(boxes):
    return all(left.x1 <= right.x0 for left, right in zip(boxes, boxes[1:], strict=False))


def draw(name, ax):
    *given, more = every_picture.given()[name]
    return getattr(figures, f"plot_{name}")(*given, ax=ax, **more)


@pytest.mark.parametrize("name", [name[5:] for name in figures.__all__ if name.startswith("plot_")])
def test_a_picture_draws_into_the_axes_given(ax, name):
    x, y = PICTURES[name]
    before = dict(rcParams)
    assert draw(name, ax) is ax
    assert (x in ax.get_xlabel(), y in ax.get_ylabel()) == (True, True)
    ax.figure.canvas.draw()  # nothing that only fails when it is rendered
    assert (pyplot.get_fignums(), dict(rcParams)) == ([], before)


@pytest.mark.parametrize("name", ["stabilization", "monitor", "frame"])
def test_without_axes_a_pyplot_figure_is_made(name):
    made = draw(name, None)
    assert pyplot.fignum_exists(made.figure.number)
    pyplot.close(made.figure)


def test_the_same_picture_has_the_same_bytes_at_any_size():
    sizes = [(6.0, 4.0), (6.0, 4.0), (4.0, 3.0)]
    first, second, small = (picture(lambda ax: draw("damage", ax), size, dpi=50) for size in sizes)
    assert first == second
    assert small.startswith(b"\x89PNG")
    assert pyplot.get_fignums() == []


# -- Identification: poles, values, what a person changed, and what stands behind them
@pytest.fixture(scope="module")
def unsteady():
    return four_masses.identified(13)


def verticals(ax, kind):
    colour, dash = LOOKS[kind]
    sample = ax.axvline(0.0, ls=dash_of(dash), lw=1.1, color=colour)
    sample.remove()

    def look(line):
        return line.get_color(), line.get_linestyle(), tuple(line._dash_pattern[1] or ())

    lines = [line for line in ax.lines if len(line.get_xdata()) == 2]
    return [line.get_xdata()[0] for line in lines if look(line) == look(sample)]


def test_without_a_value_it_says_so(unsteady, ax):
    assert unsteady.diagrams[3].identified.size == 0
    figures.plot_stabilization(unsteady.diagrams[3], ax=ax)
    assert ax.get_title() == "no antiresonance accepted in this band"
    assert texts(ax) == []


def test_values_that_do_not_stand_still_have_a_dash_of_their_own(unsteady, ax):
    diagram, how = unsteady.diagrams[0], np.array(["chain", "persistent", "chain"])
    replace(diagram, accepted=diagram.accepted.with_scores(how=how)).plot(ax=ax)
    resting, moving = list(LOOKS)[:2]
    assert verticals(ax, resting) == [diagram.identified[0], diagram.identified[2]]
    assert verticals(ax, moving) == [diagram.identified[1]]
    assert {resting, moving} <= set(labels(ax))
    markers = {line.get_label(): line.get_marker() for line in ax.lines if line.get_marker() != "None"}
    assert len(set(markers.values())) == len(markers)
    assert len({str(dash) for _, dash in LOOKS.values()}) == len(LOOKS)
    assert {colour for colour, _ in LOOKS.values()} <= set(COLOURS.values())


def test_a_set_draws_what_was_edited_by_hand(unsteady, ax):
    first, second, third = unsteady[0]
    assert unsteady.drop(0, second).add(0, [3.3, 8.0]).drop(0, 8.0).plot(0, ax=ax) is ax
    assert verticals(ax, "dropped by hand") == [second]
    assert verticals(ax, "added by hand") == [3.3]
    assert verticals(ax, "accepted") == [first, third]
    assert sorted(texts(ax)) == sorted([f"{first:.2f}", "3.30", f"({second:.2f})", f"{third:.2f}"])


def test_singular_values_are_in_decibels_over_the_noise(record, ax):
    check = check_data(record, excitation=0, band_hz=BAND)
    assert check.plot(ax=ax) is ax
    columns = {"first": check.eigenvalues[:, 0], "second": check.eigenvalues[:, 1]}
    columns["second expected under one force"] = check.second_expected
    for label, values in columns.items():
        np.testing.assert_allclose(line_of(ax, label).get_ydata(), 10 * np.log10(values))
    assert len({line_of(ax, label).get_linestyle() for label in columns}) == 3
    assert ax.get_title() == ""
    assert ax.get_xlim() == BAND
    other = chain().simulate(excitation=2, fs_hz=25.0, duration_s=400.0, damping_ratio=0.01, rng=1)
    check_data(ar.Recording(record.responses + other.responses, 25.0), band_hz=BAND).plot(ax=ax)
    assert ax.get_title() == "more than one force (fatal)"


def test_what_cannot_be_drawn_is_refused(record, judged):
    """Each line of the file is a call and what is said of it."""
    alone = ar.FrequencyResponse(np.linspace(0.5, 9.0, 300), np.ones((2, 300)))
    t, plot = ar.transmissibility(record, 0, nperseg=512), figures
    here = globals() | locals()
    replay(Path(__file__).with_name("wrong_pictures.txt"), lambda call: refusal(lambda: eval(call, here)))


# -- Measured curves beside those of the model
def test_transmissibility_of_the_very_model_lies_on_the_measurement(ax):
    freq = np.linspace(0.5, 9.0, 300)
    h = chain().frf(DOFS, 0, freq, damping_ratio=0.01)
    t = ar.FrequencyResponse(freq, h / h[1], DOFS, "transmissibility", 1)
    figures.plot_responses(t, chain(1.1 * SPRINGS), chain(), dofs=[3], excitation=0, ax=ax)
    measured, before, after = (line.get_ydata() for line in ax.lines)
    np.testing.assert_allclose(after, measured, atol=1e-9)
    assert np.abs(before - measured).max() > 1.0
    assert measured[0] == pytest.approx(20 * np.log10(abs(h[3, 0] / h[1, 0])))


def test_transmissibility_sum_peaks_at_the_antiresonances_and_leaves_out_0_hz(ax):
    freq = np.linspace(0.0, 9.0, 9001)
    h = chain().frf(DOFS, 0, freq[1:], damping_ratio=0.002)
    t = ar.FrequencyResponse(freq, np.hstack([np.ones((4, 1)), h / h[0]]), DOFS, "transmissibility", 0)
    figures.plot_responses(t, chain(), excitation=0, damping_ratio=0.002, ax=ax)
    x, y = ax.lines[0].get_data()
    assert x[0] > 0.0
    peaks = x[1:-1][(y[1:-1] > y[:-2]) & (y[1:-1] > y[2:])]
    np.testing.assert_allclose(peaks, chain().antiresonances(0, 0), rtol=1e-3)


# -- Updating: differences and the search
def test_differences_are_the_tables_and_grouped_by_response(updated, ax):
    table = updated.table
    figures.plot_differences(table, ax=ax)
    before, after = ax.containers
    np.testing.assert_allclose([bar.get_height() for bar in before], table.before_percent)
    np.testing.assert_allclose([bar.get_height() for bar in after], table.after_percent, atol=1e-12)
    assert texts(ax) == ["mass 0", "1", "2"]  # mass 3 has none
    assert f"{table.largest_before_percent:.2f} %" in labels(ax)[0]
    assert before[0].get_hatch()
    assert not after[0].get_hatch()  # told apart without colour


def test_differences_mark_what_has_no_partner_and_name_several_forces(ax):
    hz = [10.0, 20.0, 15.0], [10.4, np.nan, 15.3], [np.nan] * 3
    figures.plot_differences(ar.FrequencyTable(*map(np.array, ([0, 1, 1], [0, 0, 2], *hz))), ax=ax)
    assert len(ax.containers[0]) == 2
    assert "before updating: no partner (1)" in labels(ax)
    assert "after updating, no partner at all" in labels(ax)
    assert texts(ax) == ["0, 0", "1, 0", "1, 2"]
    assert "response and force dof" in ax.get_xlabel()


def test_many_differences_keep_room_between_the_names_of_responses(ax):
    model = ar.MassSpringChain(np.ones(31), np.full(30, 500.0))
    nominal = ar.MassSpringChain(np.ones(31), np.full(30, 520.0))
    factor = ar.stiffness_factor([0], bounds=(0.8, 1.2))
    problem = ar.UpdatingProblem(nominal, factor, exact(model, range(31)))
    table = ar.update(problem, rng=0, workers=1, optimizer=ar.IslandGA(max_evaluations=200)).table
    figures.plot_differences(table, ax=ax)
    ax.figure.draw_without_rendering()
    assert len(ax.texts) > 5
    assert distinct([text.get_window_extent() for text in ax.texts])
    assert list(ax.get_xticks()) == []
    before, after = (container[0].get_facecolor() for container in ax.containers)
    assert abs(np.dot(before[:3], [0.3, 0.6, 0.1]) - np.dot(after[:3], [0.3, 0.6, 0.1])) > 0.3  # in grey too


def test_convergence_of_any_search_down_to_zero(ax):
    ga = ar.IslandGA(islands=9, max_evaluations=3000)
    found = ga.minimize(lambda x: float(np.abs(x).sum()), [(0, 1)] * 2, rng=0)
    figures.plot_convergence(found, ax=ax)
    assert found.fun == 0.0
    assert ax.get_yscale() == "linear"  # zero has no place on a logarithmic axis
    assert len(ax.lines) >= 9


# -- Damage: losses, with and without a baseline, and hypotheses
@pytest.fixture(scope="module")
def halves():
    whole = chain(np.full(3, 500.0))
    terms = []
    for n in range(3):
        half = np.zeros((4, 4))
        half[n : n + 2, n : n + 2] = 250.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])
        terms += [half, half]
    model = ar.MatrixModel(whole.stiffness(), whole.mass(), stiffness_terms=terms)
    return ar.assess_damage(model, exact(chain([500.0, 400.0, 500.0])), baseline=exact(whole))


def test_damage_has_one_bar_an_element_and_prints_the_severity(damage, ax):
    figures.plot_damage(damage, ax=ax, truth={0: 0.0, 1: 0.4, 2: 0.0})
    heights = [bar.get_height() for bar in ax.containers[0]]
    np.testing.assert_allclose(heights, 100 * damage.x)
    assert heights == pytest.approx([0.0, 40.0, 0.0], abs=0.5)
    assert texts(ax) == [f"{100 * damage.x[1]:.1f} %"]
    assert [tick.get_text() for tick in ax.get_xticklabels()] == ["spring 0", "spring 1", "spring 2"]
    assert labels(ax) == ["found", "truth", "smallest damage that would be seen"]
    np.testing.assert_array_equal(line_of(ax, "truth").get_ydata(), [0.0, 40.0, 0.0])
    seen = line_of(ax, "smallest damage that would be seen").get_ydata()
    assert set(seen[np.isfinite(seen)]) == {100 * v for v in damage.detectable.values()}


@pytest.mark.parametrize(
    ("springs", "responses", "options", "said"),
    [
        ([500.0] * 3, DOFS, {"baseline": True}, "no damage declared"),
        ([500.0, 300.0, 500.0], DOFS, {"baseline": True, "elements": [0]}, "no candidate explains"),
        ([500.0] * 3, DOFS, {}, "no loss found"),
        ([500.0] * 3, [2], {"elements": [0, 1, 2]}, "no damage could be seen"),  # H_31 depends on one spring
    ],
)
def test_no_bar_has_a_reason(ax, springs, responses, options, said):
    model = chain(np.full(3, 500.0))
    if options.pop("baseline", False):
        options["baseline"] = exact(model)
    ar.assess_damage(model, exact(chain(springs), responses), rng=0, workers=1, **options).plot(ax=ax)
    written = [ax.get_title(), *texts(ax), *(labels(ax) if ax.get_legend() else [])]
    assert any(said in text for text in written)
    assert ax.get_ylim()[1] >= 10.0


def test_what_is_seen_only_above_the_axis_is_named_at_its_edge(damage, ax, monkeypatch):
    monkeypatch.setitem(damage.__dict__, "_detectable", (0.05, 0.02, 0.96))
    monkeypatch.setitem(damage.__dict__, "x", np.array([0.0, 0.03, 0.0]))
    damage.plot(ax=ax)
    top = ax.get_ylim()[1]
    assert 25.0 < top < 40.0  # a loss of 3 % stays a bar
    assert np.nanmax(line_of(ax, "smallest damage that would be seen").get_ydata()) <= top
    assert "96" in texts(ax)
    assert "seen only from this loss on, in %" in labels(ax)


def test_bars_have_their_intervals_and_probabilities(judged, ax):
    judged.plot(ax=ax)
    found = next(each for each in ax.containers if each.get_label() == "found")
    assert [bar.get_height() for bar in found] == [100 * beta for beta in judged.severity.values()]
    intervals = next(each for each in ax.containers if each.get_label() == "90 % interval")
    (spans,) = intervals.lines[2][0].get_segments()
    assert spans[:, 1].tolist() == pytest.approx([100 * end for end in judged.interval[judged.damaged[0]]])
    assert "what else it may be" not in labels(ax)
    assert texts(ax).count("<1") == 2
    assert ">99" in texts(ax)
    assert "90 % interval" in labels(ax)
    assert ax.get_title(loc="left") == "Probability that it is damaged (%)"


def test_what_cannot_be_told_apart_stands_beside_it(halves, ax):
    halves.plot(ax=ax)
    one, other = (h.elements[0] for h in list(halves.hypotheses)[:2])  # by rounding alone
    assert {one, other} == {2, 3}
    bars = {each.get_label(): each for each in ax.containers}
    heights = [bar.get_height() for bar in bars["found"]]
    assert np.flatnonzero(heights).tolist() == [one]
    (instead,) = bars["what else it may be"]
    assert instead.get_x() + 0.5 * instead.get_width() == pytest.approx(other)
    assert instead.get_height() == pytest.approx(heights[one], rel=1e-3)
    assert "element 2 or element 3. The values cannot tell which." in halves.headline


def test_hypotheses_are_bars_of_their_probability(halves, ax):
    halves.hypotheses.plot(ax=ax)
    first, second, *_, last = (label.get_text() for label in ax.get_yticklabels())
    assert sorted(name.split("\n")[0] for name in (first, second)) == ["element 2", "element 3"]
    assert "\n40.0 % (" in first
    assert last.endswith("together")
    assert sum(bar.get_width() for bar in ax.patches) == pytest.approx(1.0)


def test_long_names_of_hypotheses_leave_room_for_the_bars(halves, monkeypatch):
    long = "element 0 and element 4: crack 0.075 m (0.0436 to 0.245) from node 0 in element 0; " * 2
    monkeypatch.setattr(type(halves.hypotheses), "called", lambda self, one: long)
    names = probabilities(halves.hypotheses).y.names
    assert max(len(line) for name in names for line in name.split("\n")) <= 48
    assert picture(lambda ax: halves.hypotheses.plot(ax=ax), (8.0, 6.0))  # no warning of its layout


# -- Structures
@pytest.mark.parametrize("ground", [{}, {"ground_first_n_per_m": 80.0, "ground_last_n_per_m": 90.0}])
def test_a_chain_shows_the_springs_it_has(ax, ground):
    model = ar.MassSpringChain([1.0, 1.0, 1.0], [500.0, 400.0], **ground)
    figures.plot_chain(model, {1: 0.3}, ax=ax, sensors=[0, 2], excitation=1)
    without, coloured = ax.collections
    assert (len(without.get_segments()), len(coloured.get_segments())) == (1 + len(ground), 1)
    assert coloured.get_array().tolist() == [0.3]
    assert set(labels(ax)) == {"without a value", "accelerometer", "force"}
    assert texts(ax).count("ground") == len(ground)
    alone = Figure().subplots()
    figures.plot_chain(model, dict.fromkeys(range(2), 0.0), ax=alone, label="Stiffness loss (%)")
    assert alone.get_title() == "Stiffness loss (%): 0 in every element"
    assert len(alone.figure.axes) == 1  # no colour bar


def test_sections_are_told_apart_without_colour(ax):
    pipe = {name: ar.Tube(0.03, 0.001 + 0.0001 * i, 2.1e11, 7850.0) for i, name in enumerate("abcde")}
    nodes = [(float(i), 0.0) for i in range(11)]
    ar.FrameModel(nodes, [(i, i + 1, "abcde"[i // 2]) for i in range(10)], pipe, fixed=[0]).plot(ax=ax)
    named = [line_of(ax, name) for name in pipe]
    assert len({(line.get_linestyle(), str(line._dash_pattern)) for line in named}) == 5


# -- Comparisons and tracks
def sets_of(*tests):
    return [ar.AntiresonanceSet(0, {0: values}) for values in tests]


@pytest.mark.parametrize("conditions", [None, [0.0, 5.0, 20.0], ["intact", "cut", "repaired"]])
def test_tracks(ax, conditions):
    followed = ar.track(sets_of([10.0, 20.0], [10.1, 30.0], [10.2, 20.1]), conditions)
    followed.plot(0, ax=ax)
    assert {"10.00 Hz", "20.00 Hz", "30.00 Hz"} == set(labels(ax))
    refused("^dof: got 7", followed.plot, 7)


def test_a_comparison(ax):
    std = {0: [0.01, 0.01], 1: [0.01]}
    a, b = (ar.AntiresonanceSet(0, {0: f, 1: [14.4]}, std_hz=std) for f in ([8.7, 23.9], [8.7, 23.5]))
    ar.compare(a, b).plot(ax=ax)
    drawn = {each.get_label(): each.lines[0].get_ydata() for each in ax.containers}
    np.testing.assert_allclose(drawn["no change seen"], [0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(drawn["changed"], [-1.674], atol=1e-3)
    assert texts(ax) == ["dof 0", "1"]

"""Pictures of an identification: stabilization, damping clusters, and what a person changed."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

import antires_rs as ar
from antires_rs.figures.canvas import dash_of, picture
from antires_rs.figures.identification import LEAST_PERCENT, LOOKS, plot_damping_clusters, plot_stabilization
from antires_rs.figures.marks import COLOURS
from tests.support import four_masses

DRAW = {"stabilization": plot_stabilization, "damping_clusters": plot_damping_clusters}


@pytest.fixture
def ax():
    return Figure().subplots()


@pytest.fixture(scope="module")
def identified():
    """A record with a value that does not stand still."""
    return four_masses.identified(13)


def labels(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def texts(ax):
    return [text.get_text() for text in ax.texts]


def verticals(ax, kind):
    """Frequencies of the lines that look as ``kind`` should."""
    colour, dash = LOOKS[kind]
    dashes = ax.axvline(0.0, ls=dash_of(dash), lw=1.1)
    look = (colour, dashes.get_linestyle(), tuple(dashes._dash_pattern[1] or ()))
    dashes.remove()
    return [
        line.get_xdata()[0]
        for line in ax.lines
        if len(line.get_xdata()) == 2
        and (line.get_color(), line.get_linestyle(), tuple(line._dash_pattern[1] or ())) == look
    ]


def colour_of(axes, name):
    return next(line.get_color() for line in axes.lines if line.get_label() == name)


@pytest.mark.parametrize("kind", DRAW)
def test_it_draws_into_the_axes_given_and_labels_units(identified, ax, kind):
    assert DRAW[kind](identified.diagrams[0], ax=ax) is ax
    assert ax.get_xlabel() == "Frequency (Hz)"
    assert ax.get_ylabel() in ("Model order (-)", "Damping ratio (%)")
    assert ax.get_xlim() == identified.diagrams[0].band_hz
    ax.figure.canvas.draw()


@pytest.mark.parametrize("kind", DRAW)
def test_no_setting_is_changed_and_matplotlib_is_asked_for(identified, monkeypatch, kind):
    import matplotlib
    from matplotlib import pyplot

    before = dict(matplotlib.rcParams)
    made = DRAW[kind](identified.diagrams[0])
    assert pyplot.fignum_exists(made.figure.number)
    pyplot.close(made.figure)
    picture(lambda ax: DRAW[kind](identified.diagrams[0], ax=ax), (6.0, 4.0), dpi=50)
    assert pyplot.get_fignums() == []
    assert dict(matplotlib.rcParams) == before
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(ar.MissingDependencyError, match=r"antires-rs\[plot\]"):
        DRAW[kind](identified.diagrams[0])


def test_clusters_show_every_pole_once_with_its_damping(identified, ax):
    diagram = identified.diagrams[0]
    plot_damping_clusters(diagram, ax=ax)
    shown = {line.get_label(): line for line in ax.lines}
    damping = 100 * np.concatenate(diagram.damping_ratio)
    stable = np.concatenate(diagram.stable)
    high = damping >= LEAST_PERCENT
    np.testing.assert_allclose(shown["stable pole"].get_ydata(), damping[stable & high])
    np.testing.assert_allclose(shown["pole, not stable"].get_ydata(), damping[~stable & high])
    foot = shown.get(f"pole with less than {LEAST_PERCENT:g} %, or none")
    assert (0 if foot is None else len(foot.get_xdata())) == int((~high).sum())
    low, top = ax.get_ylim()
    assert low == LEAST_PERCENT
    assert top > damping.max()


def test_clusters_square_the_values_damping(identified, ax):
    diagram = identified.diagrams[0]
    plot_damping_clusters(diagram, ax=ax)
    squares = next(line for line in ax.lines if line.get_label() == "damping of the value")
    np.testing.assert_allclose(squares.get_xdata(), diagram.identified)
    np.testing.assert_allclose(squares.get_ydata(), 100 * diagram.identified_damping)
    assert texts(ax) == [f"{f:.2f} Hz" for f in diagram.identified]


def test_poles_without_damping_stand_on_the_foot(identified, ax):
    diagram = identified.diagrams[0]
    negative = replace(diagram, damping_ratio=tuple(-np.abs(d) for d in diagram.damping_ratio))
    plot_damping_clusters(negative, ax=ax)
    foot = next(line for line in ax.lines if line.get_label().startswith("pole with less than"))
    assert len(foot.get_xdata()) == sum(map(len, diagram.freq_hz))
    assert set(foot.get_ydata()) == {LEAST_PERCENT}
    ax.figure.canvas.draw()


@pytest.mark.parametrize("kind", DRAW)
def test_without_a_value_it_says_so(identified, ax, kind):
    assert identified.diagrams[3].identified.size == 0
    DRAW[kind](identified.diagrams[3], ax=ax)
    assert ax.get_title() == "no antiresonance accepted in this band"
    assert texts(ax) == []


@pytest.mark.parametrize("kind", DRAW)
def test_values_that_do_not_stand_still_have_a_dash_of_their_own(identified, ax, kind):
    diagram = identified.diagrams[0]
    how = np.array(["chain", "persistent", "chain"])
    DRAW[kind](replace(diagram, accepted=diagram.accepted.with_scores(how=how)), ax=ax)
    resting, moving = list(LOOKS)[:2]
    assert verticals(ax, resting) == [diagram.identified[0], diagram.identified[2]]
    assert verticals(ax, moving) == [diagram.identified[1]]
    assert {resting, moving} <= set(labels(ax))


@pytest.mark.parametrize("kind", DRAW)
def test_a_set_draws_what_was_edited_by_hand(identified, ax, kind):
    edited = identified.drop(0, identified[0][1]).add(0, [3.3, 8.0]).drop(0, 8.0)
    assert edited.plot(0, kind=kind, ax=ax) is ax
    assert verticals(ax, "dropped by hand") == [identified[0][1]]
    assert verticals(ax, "added by hand") == [3.3]
    assert verticals(ax, "accepted") == [identified[0][0], identified[0][2]]
    assert texts(ax) == [
        f"{identified[0][0]:.2f} Hz",
        "3.30 Hz",
        f"({identified[0][1]:.2f} Hz)",
        f"{identified[0][2]:.2f} Hz",
    ]


@pytest.mark.parametrize("kind", DRAW)
def test_marks_differ_without_colour(identified, ax, kind):
    """Stable and not by their shape, the kinds of values by their dashes."""
    DRAW[kind](identified.diagrams[0], ax=ax)
    markers = {line.get_label(): line.get_marker() for line in ax.lines if line.get_marker() != "None"}
    assert len(set(markers.values())) == len(markers)
    assert len({str(dash) for _, dash in LOOKS.values()}) == len(LOOKS)
    assert {colour for colour, _ in LOOKS.values()} <= set(COLOURS.values())


def test_the_curve_behind_is_paler_than_every_mark(identified, ax):
    from matplotlib.colors import to_rgb

    plot_stabilization(identified.diagrams[0], ax=ax)
    (behind,) = [other for other in ax.figure.axes if other is not ax]

    def luminance(colour):
        return float(np.dot(to_rgb(colour), [0.299, 0.587, 0.114]))

    curve = luminance(behind.lines[0].get_color())
    marks = ("pole, not stable", "stable pole", "accepted")
    assert curve > max(luminance(colour_of(ax, name)) for name in marks)

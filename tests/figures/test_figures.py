"""Figures to be explored: what stands in them, and that nothing is loaded from anywhere."""

import json

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.signals.averaging import Averaging, average
from tests.support.four_masses import BAND

pytest.importorskip("bokeh", reason="figures to be explored need bokeh")

from antires_rs.figures.identification import LOOKS
from antires_rs.figures.live_canvas import columns, explored, item, parts, script_files
from antires_rs.figures.live_identification import curve_of, evidence_figure, mark_columns
from antires_rs.figures.marks import Axis, Bars, Panel


@pytest.fixture(scope="module")
def averages(record):
    return average(record, BAND, Averaging())


def source_of(figure, name):
    return next(each for each in figure.select({"name": name}))


def figures_in(column):
    return {fig.name: fig for fig in column.children}


def test_a_figure_shows_the_poles_and_the_values_of_its_response(identified, record, averages):
    made = evidence_figure(identified, 1, curve_of(record, averages, 1))
    shown = figures_in(made)
    assert list(shown) == ["stabilization", "curve", "coherence", "singular_values"]
    assert len({fig.x_range.id for fig in shown.values()}) == 1  # zooming one zooms all
    diagram = identified.diagrams[1]
    drawn = {
        each.glyph.marker: each.data_source.data for each in shown["stabilization"].renderers
        if type(each.glyph).__name__ == "Scatter"
    }  # fmt: skip
    stable = np.concatenate(diagram.stable)
    np.testing.assert_allclose(drawn["circle"]["x"], np.concatenate(diagram.freq_hz)[stable], rtol=1e-6)
    assert drawn["x"]["x"].size == np.count_nonzero(~stable)
    np.testing.assert_allclose(
        source_of(shown["stabilization"], "accepted").data["x"], identified[1], rtol=1e-6
    )


def test_marks_tell_what_was_dropped_and_added(identified):
    value = float(identified[1][0])
    edited = identified.drop(1, value).add(1, 1.1 * value)
    marks = mark_columns(edited, 1, BAND)
    assert marks["dropped by hand"]["x"] == [value]
    assert marks["added by hand"]["x"] == [1.1 * value]
    assert marks["accepted"]["x"] == identified[1][1:].tolist()
    looks = [(str(dash), colour) for colour, dash in LOOKS.values()]
    assert len({dash for dash, _ in looks}) == len(looks)  # told apart in grey


def test_a_curve_has_its_dips_at_the_values(identified, record, averages):
    curve = curve_of(record, averages, 1)
    for value in identified[1]:
        near = np.abs(curve.freq_hz - value) < 0.1 * value
        dip = np.median(curve.size[np.abs(curve.freq_hz - value) < 0.02 * value])
        assert dip < np.median(curve.size[near])
    assert curve.coherence is not None
    assert curve.coherence_with.startswith("dof ")
    assert curve_of(record, averages, "not there") is None
    given = ar.transmissibility(record, 0, nperseg=512)
    assert curve_of(given, None, 2).what == "Dof 2 over dof 0 (unit of the data)"


def test_values_alone_have_a_figure(identified):
    alone = ar.AntiresonanceSet(0, {0: [8.7, 12.0], 1: []})
    for dof in alone:
        assert list(figures_in(evidence_figure(alone, dof))) == ["values_alone"]
    assert evidence_figure(ar.AntiresonanceSet(0, {0: []}), 0).children


def test_numbers_are_slim_and_axes_have_units(identified):
    table = columns(a=np.arange(3.0), b=["x", "y", "z"])
    assert table.data["a"].dtype == np.float32
    assert table.data["b"] == ["x", "y", "z"]
    bars = Bars(np.arange(3), [1.0, 2.0, 3.0], label="loss", says={"Loss": "@y %"})
    fig = explored(Panel("losses", Axis("Element (-)"), Axis("Loss (%)"), [bars]))
    text = json.dumps(item(fig))
    assert "Loss (%)" in text
    assert "http" not in text
    assert fig.below[-1].ncols == 2


def test_a_page_needs_the_files_of_the_package_alone(identified):
    script, places = parts({"one": evidence_figure(identified, 1)})
    assert places.keys() == {"one"}
    assert "http" not in script + places["one"]
    files = script_files()
    assert [file.name for file in files] == ["bokeh.min.js"]
    assert sum(file.stat().st_size for file in files) < 1.6e6

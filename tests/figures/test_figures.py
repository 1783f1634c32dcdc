"""Figures to be explored: what stands in them, and that nothing is loaded from anywhere."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.signals.averaging import Averaging, average
from tests.support.four_masses import BAND

pytest.importorskip("bokeh", reason="figures to be explored need bokeh")

from antires_rs.figures.identification import curve_of, evidence_figure


@pytest.fixture(scope="module")
def averages(record):
    return average(record, BAND, Averaging())


def source_of(figure, name):
    return next(each for each in figure.select({"name": name}))


def figures_in(column):
    return {fig.name: fig for fig in column.children}


def test_a_figure_shows_the_poles_and_the_values_of_its_response(identified, record, averages):
    shown = figures_in(evidence_figure(identified, 1, curve_of(record, averages, 1)))
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
    accepted = source_of(shown["stabilization"], "accepted").data
    np.testing.assert_allclose(accepted["x"], identified[1], rtol=1e-6)


def test_a_curve_says_what_it_is_and_of_what_its_coherence(record, averages):
    assert curve_of(record, averages, 1).coherence_with.startswith("dof ")
    assert curve_of(record, averages, "not there") is None
    given = ar.transmissibility(record, 0, nperseg=512)
    assert curve_of(given, None, 2).what == "Dof 2 over dof 0 (unit of the data)"


def test_values_alone_have_a_figure(identified):
    alone = ar.AntiresonanceSet(0, {0: [8.7, 12.0], 1: []})
    for dof in alone:
        assert list(figures_in(evidence_figure(alone, dof))) == ["values_alone"]
    assert evidence_figure(ar.AntiresonanceSet(0, {0: []}), 0).children

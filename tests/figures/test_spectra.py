"""Pictures of coherence and of singular values: what is drawn, with which units, into which axes."""

import sys

import numpy as np
import pytest
from matplotlib.figure import Figure

import antires_rs as ar
from antires_rs.figures.identification import plot_coherence, plot_singular_values
from antires_rs.signals.data_check import check_data
from tests.support.four_masses import BAND, chain


@pytest.fixture
def ax():
    return Figure().subplots()


@pytest.fixture(scope="module")
def check(record):
    return check_data(record, excitation=0, band_hz=BAND)


@pytest.fixture
def draw(record, check):
    resp = ar.frf(record, nperseg=512)
    return {
        "coherence": lambda ax: plot_coherence(resp, ax=ax),
        "singular values": lambda ax: plot_singular_values(check, ax=ax),
    }


NAMES = ["coherence", "singular values"]


def labels(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


@pytest.mark.parametrize("name", NAMES)
def test_every_picture_draws_into_the_axes_given_and_labels_units(draw, ax, name):
    from matplotlib import pyplot

    assert draw[name](ax) is ax
    assert ax.get_xlabel() == "Frequency (Hz)"
    assert any(unit in ax.get_ylabel() for unit in ("(-)", "(dB re noise power)"))
    ax.figure.canvas.draw()
    assert pyplot.get_fignums() == []


@pytest.mark.parametrize("name", NAMES)
def test_without_axes_a_pyplot_figure_is_made(draw, name):
    from matplotlib import pyplot

    made = draw[name](None)
    assert pyplot.fignum_exists(made.figure.number)
    pyplot.close(made.figure)


@pytest.mark.parametrize("name", NAMES)
def test_matplotlib_missing_names_the_extra(draw, monkeypatch, name):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(ar.MissingDependencyError, match=r'pip install "antires-rs\[plot\]"'):
        draw[name](None)


def test_few_coherences_are_drawn_one_by_one_and_told_apart_without_colour(record, ax):
    resp = ar.transmissibility(record, 2, nperseg=512)
    plot_coherence(resp, ax=ax, band_hz=BAND)
    assert labels(ax)[:3] == ["dof 0", "dof 1", "dof 3"]  # the reference with itself is one everywhere
    np.testing.assert_array_equal(ax.lines[1].get_ydata(), resp.coherence[1])
    assert len({line.get_linestyle() for line in ax.lines[:3]}) == 3
    assert ax.get_ylabel() == "Coherence with dof 2 (-)"
    assert ax.get_xlim() == BAND
    # Where noise alone would lie.
    assert ax.lines[-1].get_ydata()[0] == pytest.approx(1.0 / resp.n_averages)


def test_many_coherences_are_summed_up(ax):
    rec = ar.cases.chain8().experiment(noise=0.02, duration_s=40.0, rng=60)
    resp = ar.frf(rec, nperseg=2048)
    plot_coherence(resp, ax=ax)
    assert set(labels(ax)) >= {"each dof", "lowest", "median"}
    np.testing.assert_array_equal(ax.lines[8].get_ydata(), resp.coherence.min(axis=0))
    np.testing.assert_array_equal(ax.lines[9].get_ydata(), np.median(resp.coherence, axis=0))


def test_singular_values_are_in_decibels_over_the_noise(check, ax):
    assert check.plot(ax=ax) is ax
    lines = {line.get_label(): line for line in ax.lines}
    np.testing.assert_allclose(lines["first"].get_ydata(), 10 * np.log10(check.eigenvalues[:, 0]))
    np.testing.assert_allclose(lines["second"].get_ydata(), 10 * np.log10(check.eigenvalues[:, 1]))
    np.testing.assert_allclose(
        lines["second expected under one force"].get_ydata(), 10 * np.log10(check.second_expected)
    )
    assert len({line.get_linestyle() for line in lines.values()}) >= 3
    assert ax.get_title() == ""
    assert ax.get_xlim() == BAND


def test_a_second_force_is_in_the_title(record, ax):
    other = chain().simulate(excitation=2, fs_hz=25.0, duration_s=400.0, damping_ratio=0.01, rng=1)
    both = ar.Recording(record.responses + other.responses, 25.0)
    check_data(both, band_hz=BAND).plot(ax=ax)
    assert ax.get_title() == "more than one force (fatal)"


def test_what_has_no_coherence_or_no_eigenvalues_is_refused(record):
    resp = ar.FrequencyResponse(np.linspace(0.5, 9.0, 300), np.ones((2, 300)))
    with pytest.raises(ar.InvalidInputError, match="several averages"):
        plot_coherence(resp)
    with pytest.raises(ar.InvalidInputError, match="got Recording"):
        plot_coherence(record)
    with pytest.raises(ar.InvalidInputError, match="no spectral matrix"):
        plot_singular_values(check_data(resp, band_hz=BAND))
    with pytest.raises(ar.InvalidInputError, match="got Recording"):
        plot_singular_values(record)

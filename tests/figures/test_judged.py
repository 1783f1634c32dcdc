"""Pictures of damage against a baseline: intervals, probabilities, alternatives, hypotheses."""

import numpy as np
import pytest
from matplotlib.figure import Figure

import antires_rs as ar
from antires_rs import figures as plotting
from tests.support.four_masses import chain, exact


@pytest.fixture
def ax():
    return Figure(figsize=(9.0, 4.5), layout="constrained").subplots()


def assessed(springs, **options):
    return ar.assess_damage(chain(np.full(3, 500.0)), exact(chain(springs)), **options)


@pytest.fixture(scope="module")
def judged():
    return assessed([510.0, 294.0, 505.0], baseline=exact(chain([510.0, 490.0, 505.0])))


@pytest.fixture(scope="module")
def halves():
    """Every spring is two in parallel, which nothing can tell apart."""
    whole = chain(np.full(3, 500.0))
    terms = []
    for n in range(3):
        half = np.zeros((4, 4))
        half[n : n + 2, n : n + 2] = 250.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])
        terms += [half, half]
    model = ar.MatrixModel(whole.stiffness(), whole.mass(), stiffness_terms=terms)
    return ar.assess_damage(model, exact(chain([500.0, 400.0, 500.0])), baseline=exact(whole))


def test_a_truth_without_elements_is_refused(judged, ax):
    with pytest.raises(ar.InvalidInputError, match="truth"):
        judged.plot(ax=ax, truth=[0.0, 0.4, 0.0])


def test_bars_have_their_intervals_and_probabilities(judged, ax):
    judged.plot(ax=ax)
    bars = plotting.data_of(ax)["bars"]
    assert bars["loss_percent"].tolist() == [100 * beta for beta in judged.severity.values()]
    assert bars["low_percent"].tolist() == [100 * low for low, _ in judged.interval.values()]
    assert bars["high_percent"].tolist() == [100 * high for _, high in judged.interval.values()]
    assert bars["probability"].tolist() == list(judged.probability.values())
    assert np.isnan(bars["instead_percent"]).all()
    said = [text.get_text() for text in ax.texts]
    assert said.count("<1") == 2
    assert ">99" in said
    assert "90 % interval" in [text.get_text() for text in ax.get_legend().get_texts()]
    assert ax.get_title(loc="left") == "Probability that it is damaged (%)"


def test_what_cannot_be_told_apart_stands_beside_it(halves, ax):
    halves.plot(ax=ax)
    bars = plotting.data_of(ax)["bars"]
    assert (bars["loss_percent"] > 0).tolist() == [False, False, True, False, False, False]
    assert np.isfinite(bars["instead_percent"]).tolist() == [False, False, False, True, False, False]
    assert bars["instead_percent"][3] == pytest.approx(bars["loss_percent"][2], rel=1e-3)
    assert "what else it may be" in [text.get_text() for text in ax.get_legend().get_texts()]
    assert "element 2 or element 3. The values cannot tell which." in halves.headline


def test_no_bar_has_a_reason(ax):
    model = chain(np.full(3, 500.0))
    nothing = ar.assess_damage(model, exact(model), baseline=exact(model))
    nothing.plot(ax=ax)
    assert any(text.get_text().startswith("no damage declared") for text in ax.texts)
    elsewhere = assessed([500.0, 300.0, 500.0], baseline=exact(model), elements=[0])
    other = Figure().subplots()
    elsewhere.plot(ax=other)
    assert any("no candidate explains" in text.get_text() for text in other.texts)


def test_hypotheses_are_bars_of_their_probability(halves, ax):
    halves.hypotheses.plot(ax=ax)
    table = plotting.data_of(ax)["hypotheses"]
    assert table["name"][:2].tolist() == ["element 2", "element 3"]
    assert sum(table["probability"]) == pytest.approx(1.0)
    assert table["name"][-1].endswith("others together")
    lengths = [bar.get_width() for bar in ax.patches]
    assert lengths == table["probability"].tolist()
    labels = [label.get_text() for label in ax.get_yticklabels()]
    assert labels[0].startswith("element 2\n40.0 % (")
    with pytest.raises(ar.InvalidInputError, match="^most: got 0"):
        halves.hypotheses.plot(ax=ax, most=0)


def test_there_is_no_search_to_be_drawn(judged, ax):
    with pytest.raises(
        ar.InvalidInputError, match="without a search; wanted the result of a search. See result.hy"
    ):
        plotting.plot_convergence(judged, ax=ax)

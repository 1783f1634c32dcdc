"""Reports: one file, complete, self-contained, whole or not there."""

import os
import re
import sys
from html.parser import HTMLParser
from importlib.resources import files

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.figures.report import write_report
from tests.support import four_masses
from tests.support.four_masses import exact

TITLE = "<script>alert('K & M')</script>"
VOID = {"meta", "img", "br", "link"}


class Outline(HTMLParser):
    """Balance of tags, and what the page would load."""

    def __init__(self):
        super().__init__()
        self.open, self.sources, self.text = [], [], []

    def handle_starttag(self, tag, attrs):
        if tag not in VOID:
            self.open.append(tag)
        self.sources += [value for name, value in attrs if name in ("src", "href", "srcset", "data")]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def read(path):
    html = path.read_text(encoding="utf-8")
    outline = Outline()
    outline.feed(html)
    assert outline.open == []
    return html, outline.sources, " ".join(" ".join(outline.text).split())


@pytest.fixture(scope="module")
def updated():
    nominal = ar.MassSpringChain(np.ones(4), np.full(3, 500.0))
    true = ar.MassSpringChain(np.ones(4), [500.0, 450.0, 520.0])
    problem = ar.UpdatingProblem(nominal, ar.stiffness_factor(range(3), bounds=(0.8, 1.2)), exact(true))
    return ar.update(problem, rng=0, workers=1)


@pytest.fixture(scope="module")
def damage():
    intact = ar.MassSpringChain(np.ones(4), np.full(3, 500.0))
    measured = exact(ar.MassSpringChain(np.ones(4), [500.0, 300.0, 500.0]))
    return ar.assess_damage(intact, measured, rng=0, workers=1)


def test_updating_report_is_one_complete_self_contained_file(updated, tmp_path):
    updated.report(tmp_path / "run.html")
    assert os.listdir(tmp_path) == ["run.html"]
    assert (tmp_path / "run.html").stat().st_size < 3e6
    html, sources, text = read(tmp_path / "run.html")
    assert sources[0] == "data:,"  # no icon: nobody asks the server for one
    assert len(sources) == 4
    assert all(source.startswith("data:image/png;base64,") for source in sources[1:])
    assert not re.search(r"https?://|@import|url\(|<iframe", html)
    table = updated.table
    assert f"{table.largest_before_percent:.2f} % before, {table.largest_after_percent:.2f} % after" in text
    for value in (*table.measured_hz, *table.before_hz, *table.after_hz):
        assert f"{value:.3f}" in text
    for name, value in zip(updated.problem.names, updated.x, strict=True):
        assert name in text
        assert f"{value:#.5g}" in text
    for note in updated.notes:
        assert note in text
    for fact in (
        str(updated.seed),
        updated.message,
        f"{updated.nfev:,} evaluations",
        "numpy",
        "scipy",
        "python",
        f"antires_rs {ar.__version__}",
    ):
        assert fact in text


def test_each_dof_is_named_once(updated, tmp_path):
    html, _, _ = read(write_report(updated, tmp_path / "run.html"))
    groups = re.findall(r'<tr class="group"><td class="name">(.+?)</td>\s*<td>(.+?)</td>', html)
    assert groups == [("mass 0", "mass 0"), ("mass 1", "mass 0"), ("mass 2", "mass 0")]
    assert html.count('<td class="name"></td>') == updated.table.dof.size - 3


def test_damage_report_leads_with_the_element_and_its_loss(damage, tmp_path):
    path = write_report(damage, tmp_path / "damage.html", truth={0: 0.0, 1: 0.4, 2: 0.0})
    html, sources, text = read(path)
    answer = f"Spring 1 has lost {100 * damage.severity[1]:.1f} % of its stiffness, if the model is exact."
    assert answer in text
    assert text.index(answer) < text.index("spring 0")
    assert html.count('class="hit"') == 1
    assert "truth (%)" in text
    assert len(sources) == 5


def test_no_damage_is_said_in_so_many_words(tmp_path):
    intact = ar.MassSpringChain(np.ones(4), np.full(3, 500.0))
    result = ar.assess_damage(intact, exact(intact), rng=0, workers=1)
    assert "No damage found." in read(write_report(result, tmp_path / "r.html"))[2]


def test_evidence_and_measured_response_join_on_request(updated, tmp_path):
    path = write_report(
        updated,
        tmp_path / "run.html",
        diagrams={0: four_masses.identified().diagrams[0]},
        response=ar.transmissibility(four_masses.record(), 0, nperseg=512),
    )
    _, sources, text = read(path)
    assert len(sources) == 6
    assert "Stabilization diagram of dof 0" in text
    assert "Transmissibilities over dof 0" in text


def test_several_positions_of_the_force(tmp_path):
    true = ar.MassSpringChain(np.ones(4), [500.0, 450.0, 520.0])
    sets = [ar.AntiresonanceSet(k, {1: true.antiresonances(1, k)}) for k in (0, 3)]
    problem = ar.UpdatingProblem(
        ar.MassSpringChain(np.ones(4), np.full(3, 500.0)),
        ar.stiffness_factor(range(3), bounds=(0.8, 1.2)),
        sets,
    )
    result = ar.update(problem, rng=0, workers=1, optimizer=ar.IslandGA(max_evaluations=1000))
    html, _, text = read(write_report(result, tmp_path / "r.html"))
    assert "force at dof 0, 3;" in text
    assert html.count('class="group"') == 2


def test_text_is_escaped(updated, tmp_path):
    html, _, text = read(write_report(updated, tmp_path / "run.html", title=TITLE))
    assert TITLE not in html
    assert TITLE in text


def test_a_model_without_partners_still_reports(tmp_path):
    # H_21 of this symmetric chain has its only antiresonance at a resonance that it does not see, and H_31
    # has none: nothing to pair with, until the springs differ.
    nominal = ar.MassSpringChain(np.ones(3), [500.0, 500.0])
    measured = ar.AntiresonanceSet(0, {1: [3.5], 2: [4.0]}, sees="frf")
    problem = ar.UpdatingProblem(nominal, ar.stiffness_factor([0, 1], bounds=(0.8, 1.2)), measured)
    result = ar.update(problem, rng=0, workers=1, optimizer=ar.IslandGA(max_evaluations=1000))
    assert np.isnan(result.table.largest_before_percent)
    assert np.isnan(result.table.after_hz[1])
    _, _, text = read(write_report(result, tmp_path / "r.html"))
    assert "Largest antiresonance difference: no partner at all before" in text


def test_a_failure_leaves_the_old_report_and_no_litter(updated, tmp_path, monkeypatch):
    path = tmp_path / "run.html"
    path.write_text("old")
    monkeypatch.setattr(os, "replace", lambda *_: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises(OSError, match="disk full"):
        updated.report(path)
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["run.html"]


@pytest.mark.parametrize("where", ["missing/run.html", ""])
def test_a_place_that_cannot_be_written_is_named(updated, tmp_path, where):
    with pytest.raises(ar.InvalidInputError, match="path: got"):
        updated.report(tmp_path / where)


def test_something_else_than_a_result_is_refused(tmp_path):
    with pytest.raises(ar.InvalidInputError, match="UpdateResult"):
        write_report({"x": 1}, tmp_path / "r.html")


@pytest.mark.parametrize("package", ["jinja2", "matplotlib"])
def test_missing_packages_name_the_extra(updated, tmp_path, monkeypatch, package):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ar.MissingDependencyError, match=r'pip install "antires-rs\[(report|plot)\]"'):
        updated.report(tmp_path / "run.html")
    assert os.listdir(tmp_path) == []


def test_the_template_is_part_of_the_package():
    assert files("antires_rs.figures").joinpath("assets", "report.html").is_file()


@pytest.fixture(scope="module")
def judged():
    """Springs off the model, the second softened by 40 %; the third is no candidate."""
    model = ar.MassSpringChain(np.ones(4), np.full(3, 500.0))
    before, now = (
        exact(ar.MassSpringChain(np.ones(4), springs))
        for springs in ([510.0, 490.0, 505.0], [510.0, 294.0, 505.0])
    )
    return ar.assess_damage(model, now, baseline=before, elements=[0, 1])


def test_a_report_against_a_baseline_begins_with_the_answer(judged, tmp_path):
    intact = [{"File": "intact.uff"}]
    html, sources, text = read(write_report(judged, tmp_path / "r.html", baseline=intact))
    assert re.search(r'<p class="answer">Damage: spring 1 has lost 40.0 % of its stiffness.</p>', html)
    wanted = [
        "Damage: spring 1",
        "Probability",
        "compared with those of the intact structure; 2 candidate elements",
        "Smallest loss that nine of ten such tests would show",
        "What may explain the measurement",
        "What to know before trusting this",
        "probability of damage (%)",
        "measured, corrected by the baseline (Hz)",
        "The intact structure",
        "intact.uff",
        "learned from the baseline",
    ]
    places = [text.index(words) for words in wanted]
    assert places == sorted(places)
    assert (
        text.index("What may explain") < text.index("What to know") < text.index("Stiffness loss by element")
    )
    assert "best objective" not in text  # nothing was searched
    pictures = [source for source in sources if source.startswith("data:image/png")]
    assert len(pictures) == 4  # losses, hypotheses, model, differences


def test_a_report_says_first_that_no_candidate_explains_the_change(tmp_path):
    model = ar.MassSpringChain(np.ones(4), np.full(3, 500.0))
    now = exact(ar.MassSpringChain(np.ones(4), [500.0, 300.0, 500.0]))
    result = ar.assess_damage(model, now, baseline=exact(model), elements=[0])
    html, _, text = read(write_report(result, tmp_path / "r.html"))
    assert '<p class="answer">Something has changed that none of the candidates explains' in html
    assert "What would explain it, and was no candidate: spring 1 has lost 40.0 % of its stiffness" in text
    assert "Largest changes against the intact structure, which no candidate explains" in text
    assert "spring 1, no candidate" in text
    assert "spring 1 (no candidate)" in text

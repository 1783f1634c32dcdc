"""Figures to be explored in a report: their numbers are there, nothing is loaded, pictures replace them."""

import base64
import gzip
import json
import re

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.figures import report_parts as live
from antires_rs.figures.live_canvas import explored
from antires_rs.figures.report import write_report
from antires_rs.figures.updating import differences
from tests.support.browser import browser
from tests.support.four_masses import exact

pytestmark = pytest.mark.usefixtures("quick_pictures")
NASTY = "</script><script>alert('x')</script>"


def unpacked(block):
    return gzip.decompress(base64.b64decode(block)).decode("utf-8")


@pytest.fixture(scope="module")
def judged():
    model = ar.MassSpringChain(np.ones(4), np.full(3, 500.0))
    now = exact(ar.MassSpringChain(np.ones(4), [500.0, 300.0, 500.0]))
    return ar.assess_damage(model, now, baseline=exact(model))


@pytest.fixture(scope="module")
def curves():
    rec = ar.MassSpringChain(np.ones(4), [500.0, 300.0, 500.0]).simulate(
        excitation=0, fs_hz=20.0, duration_s=300.0, damping_ratio=0.01, rng=0
    )
    return ar.frf(rec, nperseg=512)


def test_every_figure_has_its_numbers_in_the_page_and_asks_for_nothing(judged, curves, tmp_path):
    pytest.importorskip("bokeh")
    file = write_report(judged, tmp_path / "r.html", response=curves, truth={1: 0.4}, title=NASTY)
    html = file.read_text(encoding="utf-8")
    assert file.stat().st_size < 3e6
    blocks = re.findall(r'<script type="text/plain" class="packed">([^<]*)</script>', html)
    assert len(blocks) == html.count("<figure") == html.count("<img") == 5
    texts = [unpacked(block) for block in blocks]
    for text in texts:
        assert json.loads(text)["version"]
        assert "http" not in text
    assert "spring 1" in texts[0]
    assert "Stiffness loss (%)" in texts[0]
    assert any("mass 3" in text and "FRF" in text for text in texts)
    (drawer,) = re.findall(r'id="library">([^<]*)</script>', html)
    assert "Bokeh" in unpacked(drawer)
    assert NASTY not in html
    assert "alert" not in "".join(re.findall(r"<script>(.*?)</script>", html, re.DOTALL))
    # Printed, a picture stands in place of each.
    assert re.search(r"@media print \{.*\.shown \.live \{ display: none; \}", html, re.DOTALL)
    assert re.search(r"@media print \{.*\.shown img \{ display: block; \}", html, re.DOTALL)


def test_without_the_library_pictures_are_all_there_is(judged, tmp_path, monkeypatch):
    monkeypatch.setattr(live, "there", lambda: False)
    live.library.cache_clear()
    html = write_report(judged, tmp_path / "r.html").read_text(encoding="utf-8")
    live.library.cache_clear()
    assert "<script" not in html
    assert html.count("<img") == 4


def test_one_value_far_off_does_not_flatten_the_others():
    pytest.importorskip("bokeh")
    measured = np.full(12, 10.0)
    before, after = measured * np.linspace(1.02, 1.1, 12), measured * 1.01
    before[3] = 61.7
    table = ar.FrequencyTable(np.arange(12), np.zeros(12, int), measured, before, after)
    made = explored(differences(table, ("before", "after")))
    assert 10.0 < made.y_range.end < 20.0
    assert ["+517 %"] in [each.data_source.data.get("text") for each in made.renderers]
    figure = pytest.importorskip("matplotlib.figure")
    ax = ar.figures.plot_differences(table, ax=figure.Figure().subplots())
    assert 10.0 < ax.get_ylim()[1] < 20.0
    assert "+517 %" in [text.get_text() for text in ax.texts]
    assert ar.figures.data_of(ax)["bars"]["before_percent"][3] == pytest.approx(517.0)


def test_the_watch_is_explored_too(tmp_path):
    pytest.importorskip("bokeh")
    scattered = 1.0 + 1e-3 * np.random.default_rng(0).standard_normal(60)
    watched = ar.monitor([ar.AntiresonanceSet(0, {0: [8.7 * one]}) for one in scattered], baseline=50)
    watched.report(tmp_path / "w.html")
    html = (tmp_path / "w.html").read_text(encoding="utf-8")
    (block,) = re.findall(r'class="packed">([^<]*)</script>', html)
    assert "Statistic / limit" in unpacked(block)
    assert "<img" in html


def test_a_browser_runs_and_loads_nothing_else(judged, tmp_path):
    """Whatever got into the page: only its own two scripts run, and nothing is asked of anyone."""
    pytest.importorskip("bokeh")
    html = write_report(judged, tmp_path / "r.html").read_text(encoding="utf-8")
    spoiled = "<script>document.title = 'spoiled'</script><img src='http://elsewhere.example/a.png'>"
    (tmp_path / "r.html").write_text(html.replace("<main>", f"<main>{spoiled}"), encoding="utf-8")
    assert spoiled in (tmp_path / "r.html").read_text(encoding="utf-8")
    with browser() as chromium:
        page = chromium.new_page()
        asked, refused = [], []
        page.on("request", lambda one: asked.append(one.url))
        page.on("requestfailed", lambda one: refused.append((one.url, one.failure)))
        page.goto((tmp_path / "r.html").as_uri())
        page.wait_for_selector("figure.drawn")
        assert page.title() != "spoiled"
        assert [url for url in asked if url.startswith("http")] == ["http://elsewhere.example/a.png"]
        assert refused == [("http://elsewhere.example/a.png", "csp")]  # by the page, not by the network
        page.close()


def test_dollars_in_names_are_no_formulas(tmp_path):
    """What is a formula to the library of the pictures is a name here, whole or not."""
    tube = ar.Tube(0.02, 0.004, 2.1e11, 7850.0)
    names = ["$$x^2$$", "from $5 to $6", "$\\frac{1}$"]
    model = ar.FrameModel(
        [(0.2 * i, 0.0) for i in range(4)],
        [(i, i + 1, name) for i, name in enumerate(names)],
        dict.fromkeys(names, tube),
        fixed=[0],
    )
    result = ar.update(
        ar.UpdatingProblem(
            model,
            ar.youngs_modulus(names, bounds=(0.8, 1.2), relative=True),
            ar.AntiresonanceSet(7, {4: model.antiresonances(4, 7)[:2]}),
        ),
        optimizer=ar.IslandGA(max_evaluations=200),
        rng=0,
    )
    assert "from $5 to $6" in write_report(result, tmp_path / "r.html").read_text(encoding="utf-8")

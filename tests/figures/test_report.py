"""Reports: one file, complete, self-contained, whole or not there, that everybody can read."""

import base64
import gzip
import json
import os
import re
from html.parser import HTMLParser

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.figures import packing, report_parts as parts
from antires_rs.figures.report import write_report
from tests.support.browser import Watched, browser
from tests.support.four_masses import chain, exact
from tests.support.pictures import drawn_quickly

NASTY = "</script><script>alert('K & M')</script>"
VOID = {"meta", "img", "br", "link"}
LOADING = {  #: Attributes by which a page makes a browser ask for something.
    *("src", "srcset", "href", "data", "poster", "action", "formaction"),
    *("background", "manifest", "ping", "cite", "longdesc", "xlink:href"),
}


class Page(HTMLParser):
    """Tags with their attributes, in order, all of them closed; the text and that of the styles."""

    def __init__(self, html):
        super().__init__()
        self.html, self.tags, self.styles, self.said, self.open = html, [], [], [], []
        self.feed(html)
        assert self.open == []
        self.text = " ".join(" ".join(self.said).split())
        self.pictures = [attrs["src"] for _, attrs in self.of("img")]

    def handle_starttag(self, tag, attrs):
        self.open += [] if tag in VOID else [tag]
        self.tags.append((tag, dict(attrs)))
        self.styles += [value for name, value in attrs if name == "style"]

    def handle_data(self, data):
        inside = self.open[-1] if self.open else ""
        (self.styles if inside == "style" else [] if inside == "script" else self.said).append(data)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def of(self, *names):
        return [(tag, attrs) for tag, attrs in self.tags if tag in names]

    def asked(self):
        """What a browser would load."""
        return [value for _, attrs in self.tags for name, value in attrs.items() if name in LOADING]


@pytest.fixture
def explored():
    """For a test of what makes figures explorable."""


@pytest.fixture(autouse=True)
def _quickly(request):
    with drawn_quickly(explored="explored" in request.fixturenames):
        yield


def read(path):
    return Page(path.read_text(encoding="utf-8"))


def unpacked(block):
    return gzip.decompress(base64.b64decode(block)).decode("utf-8")


def blocks(html):
    return re.findall(r'<script type="text/plain" class="packed">([^<]*)</script>', html)


@pytest.fixture(scope="module")
def intact():
    return chain(np.full(3, 500.0))


@pytest.fixture(scope="module")
def nothing(intact):
    return ar.assess_damage(intact, exact(intact), rng=0, workers=1)


def diagram(lines, noise, order):
    f = np.linspace(1.0, 20.0, lines)
    scatter = noise * np.random.default_rng(0).standard_normal(lines)
    return ar.stabilization(f, 25 / (5**2 - f**2 + 0.1j * f) + scatter, max_order=order)


@pytest.fixture(scope="module")
def reports(tmp_path_factory, intact):
    folder = tmp_path_factory.mktemp("reports")
    damaged = chain([500.0, 300.0, 500.0])
    test = {"excitation": 0, "fs_hz": 25.0, "duration_s": 400.0, "damping_ratio": 0.01}
    record = damaged.simulate(**test, noise=1e-3, rng=0)
    found = ar.identify_antiresonances(record, excitation=0, band_hz=(0.8, 9.0), max_order=24)
    result = ar.assess_damage(intact, found, rng=0, workers=1)
    pipe = {"post": ar.Tube(0.03, 0.0015, 2.1e11, 7850.0)}
    frame = ar.FrameModel([(0, 0), (0, 0.5), (0.4, 0.5)], [(0, 1, "post"), (1, 2, "post")], pipe, fixed=[0])
    sensors = [frame.dof(1, "u"), frame.dof(2, "v")]
    zeros = dict(zip(sensors, frame.antiresonances(sensors, sensors[0]), strict=True))
    thickness = [ar.thickness("post", bounds=(0.001, 0.0014))]
    problem = ar.UpdatingProblem(frame, thickness, ar.AntiresonanceSet(sensors[0], zeros))
    modes = damaged.modes(f_max_hz=9.0)
    modal = ar.assess_damage(intact, ar.ModalSet(modes.freq_hz[1:], modes.shapes[1:]), rng=0, workers=1)
    more = {"measurement": record, "response": ar.transmissibility(record, 0, nperseg=512), "truth": {1: 0.4}}
    more |= {"warnings": ["Mind the gap."], "origin": {"Repeat with": "antires damage job.toml"}}
    made = {"damage": result, "update": ar.update(problem, rng=0, workers=1), "modal": modal}
    options = {"damage": more, "update": {}, "modal": {}}
    with drawn_quickly(explored=True):
        return {name: write_report(made[name], folder / f"{name}.html", **options[name]) for name in made}


@pytest.fixture(params=["damage", "update", "modal"])
def page(request, reports):
    return read(reports[request.param])


# -- What it says
def test_updating_report_is_one_complete_file(updated, tmp_path):
    updated.report(tmp_path / "run.html")
    assert os.listdir(tmp_path) == ["run.html"]
    assert (tmp_path / "run.html").stat().st_size < 3e6
    page, table = read(tmp_path / "run.html"), updated.table
    assert len(page.pictures) == 3
    said = [f"{table.largest_before_percent:.2f} % before, {table.largest_after_percent:.2f} % after"]
    said += [f"{value:.3f}" for value in (*table.measured_hz, *table.before_hz, *table.after_hz)]
    said += [*updated.problem.names, *(f"{value:#.5g}" for value in updated.x), *updated.notes]
    said += [str(updated.seed), updated.message, f"{updated.nfev:,} evaluations"]
    said += [f"antires_rs {ar.__version__}"]
    assert [text for text in said if text not in page.text] == []
    groups = re.findall(r'<tr class="group"><td class="name">(.+?)</td>\s*<td>(.+?)</td>', page.html)
    assert groups == [("mass 0", "mass 0"), ("mass 1", "mass 0"), ("mass 2", "mass 0")]  # each named once
    assert page.html.count('<td class="name"></td>') == table.dof.size - 3


def test_several_positions_of_the_force(intact, tmp_path, explored):
    sets = [ar.AntiresonanceSet(k, {1: chain().antiresonances(1, k)}) for k in (0, 3)]
    problem = ar.UpdatingProblem(intact, ar.stiffness_factor(range(3), bounds=(0.8, 1.2)), sets)
    result = ar.update(problem, rng=0, workers=1, optimizer=ar.IslandGA(max_evaluations=1000))
    page = read(write_report(result, tmp_path / "r.html"))
    assert "force at dof 0, 3;" in page.text
    assert page.html.count('class="group"') == 2


def test_a_model_without_partners_still_reports(tmp_path):
    # H_21 of this symmetric chain has its only antiresonance at a resonance that it does not see, and H_31
    # has none: nothing to pair with, until the springs differ.
    nominal = ar.MassSpringChain(np.ones(3), [500.0, 500.0])
    measured = ar.AntiresonanceSet(0, {1: [3.5], 2: [4.0]}, sees="frf")
    problem = ar.UpdatingProblem(nominal, ar.stiffness_factor([0, 1], bounds=(0.8, 1.2)), measured)
    result = ar.update(problem, rng=0, workers=1, optimizer=ar.IslandGA(max_evaluations=1000))
    assert np.isnan(result.table.largest_before_percent)
    assert np.isnan(result.table.after_hz[1])
    text = read(write_report(result, tmp_path / "r.html")).text
    assert "Largest antiresonance difference: no partner at all before" in text


def test_a_report_against_a_baseline_begins_with_the_answer(intact, tmp_path):
    before, now = (exact(chain(springs)) for springs in ([510.0, 490.0, 505.0], [510.0, 294.0, 505.0]))
    rate = ar.SearchOptions(false_alarm_rate=0.05)
    judged = ar.assess_damage(intact, now, baseline=before, elements=[0, 1], search=rate, rng=0)
    page = read(write_report(judged, tmp_path / "r.html", baseline=[{"File": "intact.uff"}]))
    assert '<p class="answer">Damage: spring 1 has lost 40.0 % of its stiffness.</p>' in page.html
    wanted = "Damage: spring 1|Probability|compared with those of the intact structure; 2 candidate elements"
    wanted += "|What may explain the measurement|What to know before trusting this"
    wanted += "|is not known from one test of the intact structure|probability of damage (%)"
    wanted += "|smallest by stated errors (%)|measured, corrected by the baseline (Hz)"
    wanted += "|The intact structure|intact.uff|learned from the baseline"
    places = [page.text.index(words) for words in wanted.split("|")]
    assert places == sorted(places)
    assert page.text.index("What to know") < page.text.index("Stiffness loss by element")
    assert "best objective" not in page.text  # nothing was searched
    assert len(page.pictures) == 4  # losses, hypotheses, model, differences


def test_a_report_says_first_that_no_candidate_explains_the_change(intact, tmp_path):
    now = exact(chain([500.0, 300.0, 500.0]))
    result = ar.assess_damage(intact, now, baseline=exact(intact), elements=[0])
    page = read(write_report(result, tmp_path / "r.html"))
    assert '<p class="answer">Something has changed that none of the candidates explains' in page.html
    for said in (
        "What would explain it, and was no candidate: spring 1 has lost 40.0 % of its stiffness",
        "Largest changes against the intact structure, which no candidate explains",
        "spring 1, no candidate",
        "spring 1 (no candidate)",
    ):
        assert said in page.text


def test_it_says_all_that_a_reader_needs(reports):
    text = read(reports["damage"]).text
    words = "4 responses: 0, 1, 2, 3|400 s at 25 Hz, 10,000 samples a channel|force recorded|Data check"
    words += "|stable over consecutive orders|orders 2 to 24, 0.8 to 9 Hz|MassSpringChain(4 masses)"
    words += "|4 of 1 kg, 4 kg in all|3 of 500 N/m|0 to 99|gamma1 = 0.0214 and gamma2 = 0.0214"  # six values
    words += "|islands 4; population 40|Seed 0|antires damage job.toml|Warnings of the run Mind the gap."
    words += f"|antires_rs {ar.__version__}|numpy|scipy|python|system|Stabilization diagram of dof 3"
    for said in words.split("|"):
        assert said in text, said


def test_a_parameter_with_a_unit_and_on_its_bound_is_told_as_such(reports):
    html = reports["update"].read_text(encoding="utf-8")
    cells = re.sub(r"<[^>]+>", " ", re.search(r'<tr class="hit">(.*?)</tr>', html, re.S)[1]).split()
    assert "(on its bound)" in " ".join(cells)
    assert cells[-3:] == ["0.001", "to", "0.0014"]
    assert "0.0014000" in cells  # not rounded to 0.0014 or 0.00
    assert "-6.67" in cells  # percent of the nominal 1.5 mm
    assert "force at node 1 u" in html
    assert "Tube, outer_diameter_m 0.03, thickness_m 0.0015" in html
    assert "No stabilization diagram can be shown" in html


# -- How it is written
def test_what_cannot_be_written_or_does_not_fit_the_result_is_refused(intact, nothing, tmp_path):
    modal = ar.assess_damage(intact, intact.modes(), rng=0, workers=1)
    for result, place, options, said in (
        (nothing, "missing/run.html", {}, "path: got"),
        (nothing, "", {}, "path: got"),
        ({"x": 1}, "r.html", {}, "UpdateResult"),
        (modal, "r.html", {"response": "curves"}, "response: got transmissibilities with measured modes"),
        (nothing, "r.html", {"measurement": ["record"]}, "measurement"),
        (nothing, "r.html", {"measurement": [{}, {}]}, "measurement"),
    ):
        with pytest.raises(ar.InvalidInputError, match=said):
            write_report(result, tmp_path / place, **options)
    assert os.listdir(tmp_path) == []


def test_diagrams_beyond_the_size_are_left_out_and_counted(nothing, tmp_path, monkeypatch, explored):
    drawn = parts.drawings_of(nothing, diagrams=dict.fromkeys(range(5), diagram(200, 1e-3, 16)))
    one = drawn.diagrams[0]
    others = len(packing.library()) + sum(len(each.uri) + len(each.live) for each in drawn.figures.values())
    room = others + int(2.5 * len(one.uri))
    shown, left = parts.fitting(drawn, room=room)
    assert (len(shown), left) == (2, 3)
    assert [live != "" for _, live in shown] == [0 < len(one.live) < 0.5 * len(one.uri), False]
    shown, left = parts.fitting(drawn, room=others + 5 * len(one.uri) + len(one.live))
    assert ([live != "" for _, live in shown][1:], left) == ([False] * 4, 0)
    monkeypatch.setattr(parts.fitting, "__defaults__", (room,))
    file = write_report(nothing, tmp_path / "r.html", drawn=drawn)
    assert "3 more diagrams are left out to keep this file below 3 MB" in file.read_text()


# -- What it would load, and who can read it
def test_nothing_leaves_the_file(page):
    assert len(page.asked()) >= 3
    for value in page.asked():
        assert value.startswith(("data:image/png;base64,", "#")) or value == "data:,"
    assert not any("src" in attrs for _, attrs in page.of("script"))
    assert not page.of("iframe", "object", "embed", "base", "form", "audio", "video")
    assert [attrs["rel"] for _, attrs in page.of("link")] == ["icon"]
    (rule,) = [attrs for _, attrs in page.of("meta") if "http-equiv" in attrs]
    assert rule["http-equiv"] == "Content-Security-Policy"
    assert rule["content"].startswith("default-src 'none';")
    for style in page.styles:
        assert not re.search(r"url\(|@import|@font-face|image-set\(|https?:|//", style)
    for leak in ('<img src="https://example.invalid/x.png">', '<a ping="x" srcset="x.png 2x"></a>'):
        assert any(not value.startswith("data:") for value in Page(leak).asked())  # the search finds them


def test_every_figure_has_its_numbers_in_the_page_and_asks_for_nothing(judged, record, tmp_path, explored):
    pytest.importorskip("bokeh")
    curves = ar.frf(record, nperseg=512)
    file = write_report(judged, tmp_path / "r.html", response=curves, truth={1: 0.4}, title=NASTY)
    page = read(file)
    assert file.stat().st_size < 3e6
    texts = [unpacked(block) for block in blocks(page.html)]
    assert len(texts) == page.html.count("<figure") == len(page.pictures) == 5
    for text in texts:
        assert json.loads(text)["version"]
        assert "http" not in text
    assert "spring 1" in texts[0]
    assert "Stiffness loss (%)" in texts[0]
    assert any("mass 3" in text and "FRF" in text for text in texts)
    (drawer,) = re.findall(r'id="library">([^<]*)</script>', page.html)
    assert "Bokeh" in unpacked(drawer)
    assert NASTY not in page.html
    assert NASTY in page.text
    assert re.search(r"@media print \{.*\.shown \.live \{ display: none; \}", page.html, re.DOTALL)
    assert re.search(r"@media print \{.*\.shown img \{ display: block; \}", page.html, re.DOTALL)


def test_without_the_library_pictures_are_all_there_is(judged, tmp_path, monkeypatch):
    monkeypatch.setattr(packing, "find_spec", lambda name: None)
    packing.library.cache_clear()
    page = read(write_report(judged, tmp_path / "r.html"))
    packing.library.cache_clear()
    assert (page.of("script"), len(page.pictures)) == ([], 4)


def test_the_watch_is_explored_too(tmp_path, explored):
    pytest.importorskip("bokeh")
    scattered = 1.0 + 1e-3 * np.random.default_rng(0).standard_normal(60)
    watched = ar.monitor([ar.AntiresonanceSet(0, {0: [8.7 * one]}) for one in scattered], baseline=50)
    watched.report(tmp_path / "w.html")
    page = read(tmp_path / "w.html")
    (block,) = blocks(page.html)
    assert "Statistic / limit" in unpacked(block)
    assert len(page.pictures) == 1


def test_dollars_in_names_are_no_formulas(tmp_path):
    names = ["$$x^2$$", "from $5 to $6", "$\\frac{1}$"]
    sections = dict.fromkeys(names, ar.Tube(0.02, 0.004, 2.1e11, 7850.0))
    elements = [(i, i + 1, name) for i, name in enumerate(names)]
    model = ar.FrameModel([(0.2 * i, 0.0) for i in range(4)], elements, sections, fixed=[0])
    factors = ar.youngs_modulus(names, bounds=(0.8, 1.2), relative=True)
    measured = ar.AntiresonanceSet(7, {4: model.antiresonances(4, 7)[:2]})
    problem = ar.UpdatingProblem(model, factors, measured)
    result = ar.update(problem, optimizer=ar.IslandGA(max_evaluations=200), rng=0)
    assert "from $5 to $6" in write_report(result, tmp_path / "r.html").read_text(encoding="utf-8")


def test_it_can_be_read_without_seeing_and_without_a_mouse(page):
    assert page.of("html")[0][1]["lang"] == "en"
    assert page.of("main", "header") != []
    pictures = [attrs["alt"] for _, attrs in page.of("img")]
    assert len(set(pictures)) == len(pictures)
    assert all(len(alt) > 15 for alt in pictures)
    assert all(attrs.get("scope") in ("row", "col") for _, attrs in page.of("th"))
    levels = [int(tag[1]) for tag, _ in page.of("h1", "h2", "h3", "h4")]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(deeper <= level + 1 for level, deeper in zip(levels, levels[1:], strict=False))
    # What may have to be scrolled sideways can be reached by keyboard and has a name.
    boxes = [attrs for _, attrs in page.of("div") if attrs.get("class") == "scroll"]
    assert len(boxes) == 2
    assert all(box["tabindex"] == "0" and box["aria-label"] for box in boxes)


def test_a_browser_runs_and_loads_nothing_else(reports, judged, tmp_path, explored):
    """Whatever got into the page: only its own two scripts run, and nothing is asked of anyone."""
    pytest.importorskip("bokeh")
    file = write_report(judged, tmp_path / "r.html")
    spoiled = "<script>document.title = 'spoiled'</script><img src='http://elsewhere.example/a.png'>"
    html = file.read_text(encoding="utf-8").replace("<main>", f"<main>{spoiled}")
    assert spoiled in html
    file.write_text(html, encoding="utf-8")
    with browser() as chromium:
        for each in reports.values():
            page = chromium.new_page()
            watched = Watched(page)
            page.goto(each.as_uri())
            page.wait_for_load_state("networkidle")
            page.close()
            assert (watched.elsewhere, watched.wrong) == ([], [])
        page = chromium.new_page()
        asked, refused = [], []
        page.on("request", lambda one: asked.append(one.url))
        page.on("requestfailed", lambda one: refused.append((one.url, one.failure)))
        page.goto(file.as_uri())
        page.wait_for_selector("figure.drawn")
        assert page.title() != "spoiled"
        assert [url for url in asked if url.startswith("http")] == ["http://elsewhere.example/a.png"]
        assert refused == [("http://elsewhere.example/a.png", "csp")]  # by the page, not by the network
        page.close()

"""The report as a page: what it would load, what a browser says, and who can read it."""

import json
import re
import shutil
import subprocess
from html.parser import HTMLParser

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.figures import report_parts as figures
from antires_rs.figures.report import write_report
from antires_rs.figures.report_parts import library
from tests.support.four_masses import exact

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
#: Attributes by which a page makes a browser ask for something.
LOADING = {
    "src",
    "srcset",
    "href",
    "data",
    "poster",
    "action",
    "formaction",
    "background",
    "manifest",
    "ping",
    "cite",
    "longdesc",
    "xlink:href",
}


class Page(HTMLParser):
    """Tags with their attributes, in order, and the text of the styles."""

    def __init__(self, html):
        super().__init__()
        self.tags, self.styles, self._in_style = [], [], False
        self.feed(html)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self._in_style = tag == "style"
        self.styles += [value for name, value in attrs if name == "style"]

    def handle_data(self, data):
        if self._in_style:
            self.styles.append(data)

    def handle_endtag(self, tag):
        self._in_style = False

    def of(self, *names):
        return [(tag, attrs) for tag, attrs in self.tags if tag in names]


@pytest.fixture(scope="module")
def reports(tmp_path_factory):
    """A damage with everything that a report can hold, an updating with units, and one of modes."""
    folder = tmp_path_factory.mktemp("reports")
    intact = ar.MassSpringChain(np.ones(4), np.full(3, 500.0))
    damaged = ar.MassSpringChain(np.ones(4), [500.0, 300.0, 500.0])
    record = damaged.simulate(
        excitation=0, fs_hz=25.0, duration_s=400.0, damping_ratio=0.01, noise=1e-3, rng=0
    )
    found = ar.identify_antiresonances(record, excitation=0, band_hz=(0.8, 9.0), max_order=24)
    result = ar.assess_damage(intact, found, rng=0, workers=1)
    pipe = {"post": ar.Tube(0.03, 0.0015, 2.1e11, 7850.0)}
    frame = ar.FrameModel([(0, 0), (0, 0.5), (0.4, 0.5)], [(0, 1, "post"), (1, 2, "post")], pipe, fixed=[0])
    sensors = [frame.dof(1, "u"), frame.dof(2, "v")]
    zeros = frame.antiresonances(sensors, sensors[0])
    update = ar.update(
        ar.UpdatingProblem(
            frame,
            [ar.thickness("post", bounds=(0.001, 0.0014))],
            ar.AntiresonanceSet(sensors[0], dict(zip(sensors, zeros, strict=True))),
        ),
        rng=0,
        workers=1,
    )
    modes = damaged.modes(f_max_hz=9.0)
    modal = ar.assess_damage(intact, ar.ModalSet(modes.freq_hz[1:], modes.shapes[1:]), rng=0, workers=1)
    return {
        "damage": write_report(
            result,
            folder / "damage.html",
            measurement=record,
            truth={1: 0.4},
            response=ar.transmissibility(record, 0, nperseg=512),
            warnings=["Mind the gap."],
            origin={"Repeat with": "antires damage job.toml"},
        ),
        "update": write_report(update, folder / "update.html"),
        "modal": write_report(modal, folder / "modal.html"),
    }


@pytest.fixture(params=["damage", "update", "modal"])
def page(request, reports):
    return Page(reports[request.param].read_text(encoding="utf-8"))


def test_nothing_leaves_the_file(page):
    asked = [value for _, attrs in page.tags for name, value in attrs.items() if name in LOADING]
    assert len(asked) >= 3
    assert all(value.startswith(("data:image/png;base64,", "#")) or value == "data:," for value in asked)
    assert not any("src" in attrs for _, attrs in page.of("script"))
    assert not page.of("iframe", "object", "embed", "base", "form", "audio", "video")
    assert [attrs["rel"] for _, attrs in page.of("link")] == ["icon"]
    (rule,) = [attrs for _, attrs in page.of("meta") if "http-equiv" in attrs]
    assert rule["http-equiv"] == "Content-Security-Policy"
    assert rule["content"].startswith("default-src 'none';")
    for style in page.styles:
        assert not re.search(r"url\(|@import|@font-face|image-set\(|https?:|//", style)


@pytest.mark.parametrize(
    ("leak", "says"),
    [
        ('<img src="https://example.invalid/x.png">', True),
        ('<img srcset="x.png 2x">', True),
        ("<p>https</p>", False),
    ],
)
def test_the_search_for_leaks_finds_them(leak, says):
    asked = [value for _, attrs in Page(leak).tags for name, value in attrs.items() if name in LOADING]
    assert any(not value.startswith("data:") for value in asked) is says


def loaded(file, folder):
    """URLs that a page asks for over any network, and what it says on the console."""
    log = folder / "net.json"
    call = [
        CHROMIUM,
        "--headless=new",
        "--no-sandbox",
        "--disable-gpu",
        "--no-first-run",
        "--host-resolver-rules=MAP * ~NOTFOUND",
        f"--user-data-dir={folder / 'profile'}",
        f"--log-net-log={log}",
        "--enable-logging=stderr",
        "--v=0",
        f"--screenshot={folder / 'page.png'}",
        "--window-size=1200,3000",
        file.as_uri(),
    ]
    done = subprocess.run(call, capture_output=True, text=True, errors="replace", timeout=25, check=False)
    assert (folder / "page.png").stat().st_size > 1000, done.stderr
    events = json.loads(log.read_text(encoding="utf-8"))["events"]
    started = [event["params"] for event in events if "initiator" in event.get("params", {})]
    # The browser's own errands (its clock, its account) have no origin.
    asked = [params["url"] for params in started if params["initiator"] != "not an origin"]
    return asked, [
        line for line in done.stderr.splitlines() if "CONSOLE" in line and "setting log level" not in line
    ]


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here to open a report in")
def test_a_browser_asks_for_nothing_and_finds_nothing_wrong(reports, tmp_path):
    # First a page that does ask and complain: the log would show it.
    leaking = tmp_path / "leaking.html"
    leaking.write_text('<img src="http://example.invalid/x.png"><script>console.error("heard")</script>')
    asked, said = loaded(leaking, tmp_path)
    assert asked == ["http://example.invalid/x.png"]
    assert any("heard" in line for line in said)
    for name, file in reports.items():
        folder = tmp_path / name
        folder.mkdir()
        assert loaded(file, folder) == ([], [])


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


def luminance(colour):
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return float(np.dot(linear, [0.2126, 0.7152, 0.0722]))


def test_text_stands_out_from_its_ground(page):
    """Contrast of at least 4.5, WCAG 2.1, 1.4.3."""
    colours = dict(re.findall(r"--(\w+): (#\w{6})", page.styles[0]))
    for text in ("ink", "soft"):
        for ground in ("#ffffff", colours["tint"]):
            assert (luminance(ground) + 0.05) / (luminance(colours[text]) + 0.05) >= 4.5


def test_it_says_all_that_a_reader_needs(reports):
    html = reports["damage"].read_text(encoding="utf-8")
    text = " ".join(re.sub(r"<style.*?</style>|<[^>]+>", " ", html, flags=re.S).split())
    for said in (
        "4 responses: 0, 1, 2, 3",
        "400 s at 25 Hz, 10,000 samples a channel",
        "force recorded",
        "stable over consecutive orders",
        "orders 2 to 24, 0.8 to 9 Hz",
        "Data check",
        "MassSpringChain(4 masses)",
        "4 of 1 kg, 4 kg in all",
        "3 of 500 N/m",
        "0 to 99",
        "gamma1 = 0.0214 and gamma2 = 0.0214",  # six values
        "islands 4; population 40",
        "Seed 0",
        "antires damage job.toml",
        "Warnings of the run Mind the gap.",
        f"antires_rs {ar.__version__}",
        "numpy",
        "scipy",
        "python",
        "system",
        "Stabilization diagram of dof 3",
    ):
        assert said in text, said


def test_a_parameter_with_a_unit_and_on_its_bound_is_told_as_such(reports):
    html = reports["update"].read_text(encoding="utf-8")
    row = re.search(r'<tr class="hit">(.*?)</tr>', html, re.S)[1]
    cells = re.sub(r"<[^>]+>", " ", row).split()
    assert "(on its bound)" in " ".join(cells)
    assert cells[-3:] == ["0.001", "to", "0.0014"]
    assert "0.0014000" in cells  # not rounded to 0.0014 or 0.00
    assert "-6.67" in cells  # percent of the nominal 1.5 mm
    assert "force at node 1 u" in html
    assert "Tube, outer_diameter_m 0.03, thickness_m 0.0015" in html
    assert "No stabilization diagram can be shown" in html


def drawn_of(diagram, count=1):
    chain = ar.MassSpringChain(np.ones(3), [500.0, 500.0])
    result = ar.assess_damage(chain, exact(chain), rng=0, workers=1)
    return figures.drawings_of(result, diagrams=dict.fromkeys(range(count), diagram))


@pytest.mark.usefixtures("quick_pictures")
def test_diagrams_beyond_the_size_are_left_out_and_counted(tmp_path, monkeypatch):
    f = np.linspace(1.0, 20.0, 200)
    noise = 1e-3 * np.random.default_rng(0).standard_normal(200)
    one = ar.stabilization(f, 25 / (5**2 - f**2 + 0.1j * f) + noise, max_order=16)
    drawn = drawn_of(one, 5)
    size = len(drawn.diagrams[0].uri)
    others = len(library()) + sum(len(each.uri) + len(each.live) for each in drawn.figures.values())
    shown, left = figures.fitting(drawn, room=others + int(2.5 * size))
    assert (len(shown), left) == (2, 3)
    assert [live != "" for _, live in shown] == [0 < len(drawn.diagrams[0].live) < 0.5 * size, False]
    shown, left = figures.fitting(drawn, room=others + 5 * size + len(drawn.diagrams[0].live))
    assert ([live != "" for _, live in shown][1:], left) == ([False] * 4, 0)
    chain = ar.MassSpringChain(np.ones(3), [500.0, 500.0])
    result = ar.assess_damage(chain, exact(chain), rng=0, workers=1)
    monkeypatch.setattr(figures.fitting, "__defaults__", (others + int(2.5 * size),))
    file = write_report(result, tmp_path / "r.html", diagrams=dict.fromkeys(range(5), one))
    assert "3 more diagrams are left out to keep this file below 3 MB" in file.read_text()


def test_with_all_the_room_for_diagrams_filled_it_stays_below_three_megabytes(tmp_path):
    f = np.linspace(1.0, 20.0, 400)
    noise = 1e-2 * np.random.default_rng(0).standard_normal(400)
    one = ar.stabilization(f, 25 / (5**2 - f**2 + 0.1j * f) + noise, max_order=60)
    chain = ar.MassSpringChain(np.ones(3), [500.0, 500.0])
    result = ar.assess_damage(chain, exact(chain), rng=0, workers=1)
    drawn = figures.drawings_of(result, diagrams={0: one})
    file = write_report(result, tmp_path / "r.html", drawn=drawn)
    both = [*drawn.figures.values(), *drawn.diagrams.values()]
    counted = len(library()) + sum(len(each.uri) + len(each.live) for each in both)
    # What is not counted, the text of all the others, leaves room to the limit.
    assert 0 < file.stat().st_size - counted < 2.9e6 - figures.MOST_BYTES


@pytest.mark.parametrize("given", [[], ["record"], [{}, {}]])
def test_a_measurement_that_does_not_fit_is_refused(tmp_path, given):
    chain = ar.MassSpringChain(np.ones(3), [500.0, 500.0])
    result = ar.assess_damage(chain, exact(chain), rng=0, workers=1)
    if not given:
        write_report(result, tmp_path / "r.html", measurement=given)
        return
    with pytest.raises(ar.InvalidInputError, match="measurement"):
        write_report(result, tmp_path / "r.html", measurement=given)

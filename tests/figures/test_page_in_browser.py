"""The page as a person uses it: real clicks in a real browser, and what the set is after each."""

import numpy as np
import pytest

import antires_rs as ar
from tests.support.browser import Watched, browser

pytest.importorskip("bokeh", reason="the page needs bokeh")

from antires_rs.figures.identification import pole_table
from antires_rs.figures.page import Page
from antires_rs.figures.page_session import SetView


@pytest.fixture(scope="module")
def chromium():
    with browser() as started:
        yield started


@pytest.fixture
def shown(chromium, served):
    """The page, drawn; at its end nothing was asked of anyone else, and nothing went wrong."""
    page = chromium.new_page(viewport={"width": 1400, "height": 1400})
    watched = Watched(page)
    page.goto(served.url)
    drawn(page)
    yield page
    page.close(run_before_unload=False)
    assert watched.elsewhere == []
    assert watched.wrong == []


def drawn(page):
    page.wait_for_selector("#pictures[data-drawn]")


def said(page, text):
    page.wait_for_function("text => document.querySelector('#said').textContent.includes(text)", arg=text)


def values(page):
    return page.evaluate(
        "[...document.querySelectorAll('#values tbody tr[data-dof]')]"
        ".map(row => [row.dataset.dof, row.querySelector('.hz').textContent])"
    )


def same(page, zeros):
    written = values(page)
    expected = [(str(dof), freq) for dof in zeros for freq in zeros[dof]]
    assert [name for name, _ in written] == [name for name, _ in expected]
    for (_, text), (_, freq) in zip(written, expected, strict=True):
        assert float(text) == pytest.approx(freq, abs=0.51 * 10.0 ** -len(text.partition(".")[2]))
    return True


def click_on(page, name, x, y=None):
    """A click in a figure, at a place in units of its axes; y by default in the middle."""
    place = page.evaluate(
        """([name, x, y]) => {
          const plot = plots().find(one => one.model.name === name);
          const box = plot.el.getBoundingClientRect(), frame = plot.frame.bbox;
          const sy = y === null ? frame.top + frame.height / 2 : plot.frame.y_scale.compute(y);
          return [box.x + plot.frame.x_scale.compute(x), box.y + sy];
        }""",
        [name, float(x), y],
    )
    page.wait_for_timeout(400)  # two clicks at once are one double click
    page.mouse.click(*place)


def test_pick_drop_band_save_and_reload(shown, session, identified, tmp_path):
    page, dof = shown, 1
    assert same(page, identified)
    page.select_option("#response", "1")
    page.wait_for_selector("#pictures[data-drawn='1']")

    first = float(identified[dof][0])
    page.fill("#reason", "mains hum")
    click_on(page, "stabilization", first)  # on its line: dropped
    said(page, "dropped")
    assert same(page, session.zeros)
    assert session.zeros[dof].tolist() == identified[dof][1:].tolist()
    click_on(page, "stabilization", first)  # again: brought back
    said(page, "brought back")
    assert session.zeros == identified
    assert not session.zeros.edits
    page.fill("#reason", "mains hum")
    click_on(page, "stabilization", first)
    said(page, "dropped")
    assert session.zeros.edits[0].reason == "mains hum"

    order, pole = lone_pole(identified.diagrams[dof], identified[dof])
    click_on(page, "stabilization", pole, order)  # on a pole: added
    said(page, "added")
    assert session.zeros[dof][session.zeros.tables[dof].by_hand] == pytest.approx([pole])
    assert same(page, session.zeros)

    before = session.zeros
    page.fill("#low", "2")
    page.fill("#high", "8,5")
    page.click("#identify")
    said(page, "identified")
    assert session.now.band_hz == (2.0, 8.5)
    assert {edit.action for edit in before.edits} == {"drop", "add"}
    assert len(session.now.asked) == 2  # no edit is lost
    assert same(page, session.zeros)

    page.click("#save")
    said(page, "saved")
    kept = ar.AntiresonanceSet.load(tmp_path / "zeros.json")
    assert kept == session.zeros
    assert kept.edits == session.zeros.edits
    page.reload()
    drawn(page)
    assert same(page, kept)
    assert page.input_value("#high") == "8.5"


def lone_pole(diagram, taken):
    order, freq, _, _ = pole_table(diagram)
    for at in np.argsort(order):
        near = np.abs(freq - freq[at]) < 0.12
        near &= np.abs(order - order[at]) < 3
        if near.sum() == 1 and np.abs(taken - freq[at]).min() > 0.3 and 1.2 < freq[at] < 8.0:
            return float(order[at]), float(freq[at])
    raise AssertionError("no pole stands alone")


def test_by_keyboard_and_by_the_table(shown, session, identified):
    page = shown
    page.fill("#value", "3,21")
    page.press("#value", "Enter")
    said(page, "added 3.21")
    assert 3.21 in session.zeros[0]
    page.locator("#values td.drop button").nth(0).click()
    said(page, "dropped")
    assert len(session.zeros.edits) == 2
    page.get_by_role("button", name="take back").nth(0).click()
    said(page, "took back")
    assert [edit.action for edit in session.zeros.edits] == ["drop"]
    page.locator("h1").click()
    page.keyboard.press("Control+s")
    said(page, "saved")
    page.fill("#value", "nonsense")
    page.press("#value", "Enter")
    said(page, "A frequency in Hz")


def test_a_reason_is_that_of_one_edit_and_what_is_being_typed_stays(shown, session):
    page = shown
    page.fill("#reason", "clear in the phase")
    click_on(page, "coherence", 0.5 * sum(session.zeros[0][:2]))  # hits nothing: the reason stays
    said(page, "nothing there")
    assert page.input_value("#reason") == "clear in the phase"
    for freq in ("3.21", "4.32"):
        page.fill("#value", freq)
        page.press("#value", "Enter")
        said(page, f"added {freq}")
        assert page.input_value("#reason") == ""
    assert [edit.reason for edit in session.zeros.edits] == ["clear in the phase", ""]
    assert "4.32 Hz at dof 0" in page.locator("#edits").text_content()
    page.fill("#low", "2")
    page.fill("#high", "8.5")
    page.click("#save")
    said(page, "saved")
    assert ar.AntiresonanceSet.load(session.file.path).edits == session.zeros.edits
    assert (page.input_value("#low"), page.input_value("#high")) == ("2", "8.5")


def test_a_double_click_drops_one_value(shown, session, identified):
    page = shown
    box = page.locator("#values td.drop button").nth(0).bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    said(page, "dropped")
    page.mouse.down(click_count=2)  # the next value stands there now
    page.mouse.up(click_count=2)
    page.wait_for_timeout(300)
    assert [edit.freq_hz for edit in session.zeros.edits] == [identified[0][0]]


def test_another_response_is_shown_while_an_answer_is_on_its_way(shown, session):
    page = shown
    page.route("**/do/identify*", lambda route: (page.wait_for_timeout(1500), route.continue_()))
    band = "({ low_hz: state.band_hz[0], high_hz: state.band_hz[1], max_order: state.max_order })"
    same = page.evaluate(band)
    page.evaluate("body => { window.acted = act('identify', body); }", same)
    page.evaluate("show(2)")
    page.wait_for_selector("#pictures[data-drawn='2']")
    page.evaluate("acted")
    said(page, "identified")
    assert (page.input_value("#response"), page.evaluate("state.dof")) == ("2", 2)
    of_values = "[...figures.roots[0].model.references()].find(one => one.name === 'accepted').data.x"
    marks = page.evaluate(of_values)
    shown = list(marks.values() if isinstance(marks, dict) else marks)
    assert shown == pytest.approx(session.zeros[2].tolist(), rel=1e-5)


def test_a_file_that_is_there_is_replaced_after_a_question(shown, session, identified):
    page = shown
    identified.save(session.file.path)
    asked = []
    page.once("dialog", lambda box: (asked.append(box.message), box.dismiss()))
    page.fill("#value", "3.21")
    page.press("#value", "Enter")
    said(page, "added")
    page.click("#save")
    said(page, "is there already")
    assert "Replace it?" in asked[0]
    assert ar.AntiresonanceSet.load(session.file.path) == identified
    page.once("dialog", lambda box: box.accept())
    page.click("#save")
    said(page, "saved")
    assert ar.AntiresonanceSet.load(session.file.path) == session.zeros


def test_the_server_ends_with_its_page(chromium, session, monkeypatch):
    monkeypatch.setattr("antires_rs.figures.page.GRACE_S", 1.0)
    page = Page(SetView(session, "four masses"), ends_with_page=True)
    page.start()
    shown = chromium.new_page()
    shown.goto(page.url)
    drawn(shown)
    shown.reload()
    drawn(shown)
    assert page.running
    shown.close(run_before_unload=False)
    page._over.wait(10.0)
    assert not page.running

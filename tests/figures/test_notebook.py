"""``zeros.look()`` in a notebook: the page below the cell, and the edits in the next cell."""

import json
import re
from http.server import BaseHTTPRequestHandler, HTTPServer
from threading import Thread
from urllib.request import urlopen

import pytest

from tests.support.browser import Watched, browser

pytest.importorskip("bokeh", reason="the page needs bokeh")

MAKE = """
import antires_rs as ar
from tests.support.four_masses import identified, record
page = identified().look(record(), max_order=30)
"""


@pytest.fixture(scope="module")
def notebook():
    client = pytest.importorskip("nbclient", reason="notebooks are run by nbclient")
    pytest.importorskip("ipykernel", reason="notebooks are run by ipykernel")
    from nbformat.v4 import new_code_cell, new_notebook

    book = new_notebook(cells=[new_code_cell(MAKE)])
    runner = client.NotebookClient(book, timeout=120)
    with runner.setup_kernel():
        shown = runner.execute_cell(book.cells[0], 0)

        def run(code):
            book.cells.append(new_code_cell(code))
            done = runner.execute_cell(book.cells[-1], len(book.cells) - 1)
            return "".join(one.get("text", "") for one in done.outputs)

        yield shown, run


pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.fixture(scope="module")
def framed(notebook):
    cell, _ = notebook
    html = next(one.data["text/html"] for one in cell.outputs if one.output_type == "display_data")

    class Host(BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.end_headers()
            self.wfile.write(f"<!doctype html><link rel=icon href=data:,><body>{html}".encode())

        def log_message(self, *args):
            pass

    server = HTTPServer(("127.0.0.1", 0), Host)
    Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/", re.search(r'src="([^"]+)"', html)[1]
    server.shutdown()
    server.server_close()


def test_the_page_is_framed_and_its_edits_are_there_in_the_next_cell(notebook, framed):
    _, run = notebook
    _, address = framed
    base, _, token = address.replace("&amp;", "&").partition("/?")
    with urlopen(f"{base}/do/add?{token}", json.dumps({"dof": 0, "freq_hz": 3.21}).encode()) as answer:
        assert json.load(answer)["said"] == "added 3.21 Hz at dof 0"
    assert run("print(page.zeros.edits[0], page.running)") == "added 3.21 Hz at dof 0 True\n"


def test_a_browser_draws_it_inside_the_notebook(notebook, framed):
    outside, _ = framed
    with browser() as chromium:
        page = chromium.new_page(viewport={"width": 1100, "height": 900})
        watched = Watched(page)
        page.goto(outside)
        inside = page.frame_locator("iframe")
        inside.locator("#pictures[data-drawn]").wait_for(timeout=30_000)
        assert inside.locator("#values tbody td.hz").count() >= 6
        page.close(run_before_unload=False)
        assert (watched.elsewhere, watched.wrong) == ([], [])


def test_it_can_be_ended(notebook):
    _, run = notebook
    assert run("page.stop(); print(page.running)") == "False\n"

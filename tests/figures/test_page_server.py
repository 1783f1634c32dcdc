"""The server of the page without a browser: who is answered, and what commands do."""

import json
import os
import socket
import threading
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import pytest

import antires_rs as ar

pytest.importorskip("bokeh", reason="the page needs bokeh")

from antires_rs.figures.page import Page
from antires_rs.figures.page_handlers import ADDRESS, Guard
from antires_rs.figures.page_session import SetView
from tests.support.snapshots import replay


def asked(page, path, body=None, *, token=None, **headers):
    """Status and text of an answer; ``headers`` with underscores."""
    base, _, own = page.url.partition("/?token=")
    query = ("&" if "?" in path else "?") + f"token={own if token is None else token}" * (token != "")
    given = {name.replace("_", "-"): value for name, value in headers.items()}
    data = None if body is None else (body if isinstance(body, bytes) else json.dumps(body).encode())
    try:
        with urlopen(Request(f"{base}/{path}{query}", data, given)) as answer:
            return answer.status, answer.read().decode(), answer.headers
    except HTTPError as exc:
        return exc.code, exc.read().decode(), exc.headers


def told(page, path, body=None):
    status, text, _ = asked(page, path, body)
    assert status == 200
    return json.loads(text)


PATHS = ["", "state", "figure", "page.js", "tables.js", "page.css", "bokeh.js", "download", "alive"]


def test_only_who_has_the_token_is_answered(served, tmp_path):
    for path in (*PATHS, "do/save", "nothing"):
        for token in ("", "wrong", served.url[-5:]):
            for body in (None, b"{}"):
                assert asked(served, path, body, token=token)[0] in (403, 405), path
        assert asked(served, path, token="")[0] == 403, path
    assert not list(tmp_path.iterdir())


def test_the_arguments_of_the_browser_tell_no_token(served, tmp_path, monkeypatch):
    monkeypatch.setattr("pathlib.Path.home", lambda: tmp_path)
    addresses = []
    monkeypatch.setattr("webbrowser.open", lambda address: addresses.append(address) or True)
    assert served.in_browser()
    (file,) = tmp_path.iterdir()
    assert addresses == [file.as_uri()]
    assert served.url in file.read_text()
    assert os.name != "posix" or file.stat().st_mode & 0o777 == 0o600
    served.stop()
    assert not file.exists()


def test_other_pages_and_bent_names_are_refused(served):
    port = served.url.split(":")[2].partition("/")[0]
    for host in ("evil.example", f"evil.example:{port}", ADDRESS, f"{ADDRESS}:1", f"[::1]:{port}"):
        assert asked(served, "state", Host=host)[0] == 403
    for origin in ("http://evil.example", "null", f"https://{ADDRESS}:{port}", f"http://{ADDRESS}:1"):
        assert asked(served, "do/save", {}, Origin=origin)[0] == 403
        assert asked(served, "alive", Origin=origin, Upgrade="websocket", Connection="Upgrade")[0] == 403
    assert asked(served, "state", Origin=f"http://{ADDRESS}:{port}", Host=f"localhost:{port}")[0] == 200


def test_a_page_may_load_nothing_from_elsewhere(served):
    _, text, headers = asked(served, "")
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "unsafe-eval" not in policy
    assert "http" not in policy.partition("frame-ancestors")[0].replace("http-equiv", "")
    assert headers["Referrer-Policy"] == "no-referrer"
    for path in ("", "page.js", "tables.js", "page.css"):
        assert "https://" not in asked(served, path)[1]
    assert "http" not in text
    assert served.url.startswith(f"http://{ADDRESS}:")
    assert Guard(1).token != Guard(1).token
    assert Guard(1).token not in repr(Guard(1))


def test_commands_edit_the_set(served, session, identified, tmp_path):
    value = float(identified[1][0])
    answer = told(served, "do/drop?shown=1", {"dof": 1, "freq_hz": value, "reason": "mains hum"})
    assert answer["said"] == f"dropped {value:.2f} Hz at dof 1 (mains hum)"
    assert value not in session.zeros[1]
    assert answer["marks"]["dropped by hand"]["x"] == [value]
    assert answer["unsaved"] is True
    assert told(served, "do/save", {})["unsaved"] is False
    assert ar.AntiresonanceSet.load(tmp_path / "zeros.json") == served.zeros == session.zeros
    assert served.keep_unsaved() is None
    assert told(served, "do/take_back", {"number": 0})["edits"] == []
    status, text, headers = asked(served, "download")
    assert status == 200
    assert headers["Content-Disposition"] == 'attachment; filename="zeros.json"'
    assert ar.AntiresonanceSet.from_json(text) == identified


def test_what_cannot_be_done_is_told_and_changes_nothing(served, session):
    """Each line of the file is a command and what is said of it."""
    before = session.now

    def said(case):
        command, _, body = case.partition(" ")
        return told(served, f"do/{command}", eval(body))["error"].replace("0" * 400, "...")

    replay(Path(__file__).with_name("wrong_commands.txt"), said)
    assert session.now is before


def test_malformed_requests_are_refused(served):
    assert asked(served, "do/drop", b"{")[0] == 400
    assert asked(served, "do/drop", b"[]")[0] == 400
    assert asked(served, "do/drop", b"[" * 50_000)[0] == 400
    assert asked(served, f"state?shown={'9' * 5000}")[0] == 400
    assert asked(served, "state?shown=x")[0] == 400
    assert asked(served, "nothing")[0] == 404
    assert asked(served, "do/../state", {})[0] in (404, 405)
    assert "error" in told(served, "figure?shown=99")


def test_nothing_is_left_of_a_page_that_ended(session):
    """Neither threads nor sockets, however it ended; ending twice is ending once."""
    before = {thread.ident for thread in threading.enumerate()}
    for _ in range(2):
        served = Page(SetView(session, "four masses"), ends_with_page=False)
        served.start()
        told(served, "state")
        told(served, "figure")
        served.stop()
        served.stop()
        served.show(SetView(session, "too late"))
        port = int(served.url.partition("/?")[0].rpartition(":")[2])
        with pytest.raises(OSError, match="refused"):
            socket.create_connection((ADDRESS, port), 1.0)
    for thread in threading.enumerate():
        if thread.ident not in before:
            thread.join(10.0)  # of a figure that was being drawn
            assert not thread.is_alive()

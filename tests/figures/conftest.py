"""What pictures are drawn of, made once a process, and axes to draw into."""

import pytest

from tests.support import every_picture, four_masses


@pytest.fixture
def ax():
    figure = pytest.importorskip("matplotlib.figure")
    return figure.Figure(figsize=(9.0, 4.5), layout="constrained").subplots()


_once = pytest.fixture(scope="session")
record, identified = _once(four_masses.record), _once(four_masses.identified)
updated, damage, judged = map(_once, (every_picture.updated, every_picture.damage, every_picture.judged))


@pytest.fixture
def session(identified, record, tmp_path):
    """The set on the desk, with what it was identified from and a file."""
    from antires_rs.figures.page_session import Session

    given = {"band_hz": four_masses.BAND, "options": {"max_order": 30}, "save_to": tmp_path / "zeros.json"}
    return Session(identified, record, **given)


@pytest.fixture
def served(session):
    """Its page."""
    from antires_rs.figures.page import Page
    from antires_rs.figures.page_session import SetView

    page = Page(SetView(session, "four masses"), ends_with_page=False)
    page.start()
    yield page
    page.stop()

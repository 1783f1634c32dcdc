"""What pictures are drawn of, made once a process, and axes to draw into."""

import numpy as np
import pytest

import antires_rs as ar
from tests.support import four_masses
from tests.support.four_masses import SPRINGS, chain, exact


@pytest.fixture
def ax():
    figure = pytest.importorskip("matplotlib.figure")
    return figure.Figure(figsize=(9.0, 4.5), layout="constrained").subplots()


@pytest.fixture(scope="session")
def record():
    return four_masses.record()


@pytest.fixture(scope="session")
def identified():
    return four_masses.identified()


@pytest.fixture(scope="session")
def updated():
    parameters = ar.stiffness_factor(range(3), bounds=(0.8, 1.2))
    problem = ar.UpdatingProblem(chain(np.full(3, 500.0)), parameters, exact(chain()))
    return ar.update(problem, rng=0, workers=1)


@pytest.fixture(scope="session")
def damage():
    """Spring 1 softened by 40 %, found without a baseline."""
    return ar.assess_damage(chain(), exact(chain(SPRINGS * [1.0, 0.6, 1.0])), rng=0, workers=1)


@pytest.fixture(scope="session")
def judged():
    """The same against a baseline, whose springs are not those of the model."""
    model, before, now = (chain(each) for each in ([500.0] * 3, [510.0, 490.0, 505.0], [510.0, 294.0, 505.0]))
    return ar.assess_damage(model, exact(now), baseline=exact(before))


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

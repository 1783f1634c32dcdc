"""For every public picture something to draw, of four masses; each is made once a process."""

from functools import cache

import numpy as np

import antires_rs as ar
from antires_rs.signals.data_check import check_data
from tests.support.four_masses import BAND, SPRINGS, chain, exact, identified, record
from tests.support.meshed import meshed_chain


@cache
def updated():
    parameters = ar.stiffness_factor(range(3), bounds=(0.8, 1.2))
    problem = ar.UpdatingProblem(chain(np.full(3, 500.0)), parameters, exact(chain()))
    return ar.update(problem, rng=0, workers=1)


@cache
def damage():
    """Spring 1 softened by 40 %, found without a baseline."""
    return ar.assess_damage(chain(), exact(chain(SPRINGS * [1.0, 0.6, 1.0])), rng=0, workers=1)


@cache
def judged():
    """The same against a baseline, whose springs are not those of the model."""
    model, before, now = (chain(each) for each in ([500.0] * 3, [510.0, 490.0, 505.0], [510.0, 294.0, 505.0]))
    return ar.assess_damage(model, exact(now), baseline=exact(before))


@cache
def given():
    """Arguments of ``plot_...`` by the name of the picture; a mapping at the end holds those by name."""
    sets = [ar.AntiresonanceSet(0, {0: [f]}, std_hz={0: [0.1]}) for f in (8.7, 8.6)]
    pipe = ar.Tube(0.038, 0.0015, 2.1e11, 7850.0)
    frame = ar.FrameModel([(0, 0), (1, 0), (1, 1)], [(0, 1), (1, 2)], pipe, fixed=[0])
    known = ar.identifiability(ar.cases.chain8().updating_problem(), points=4, forces=[], sensors=[])
    scattered = 1.0 + 1e-3 * np.random.default_rng(0).standard_normal(60)
    diagram, found = identified().diagrams[1], damage()
    return {
        "stabilization": (diagram, {}),
        "singular_values": (check_data(record(), band_hz=BAND), {}),
        "responses": (ar.frf(record(), nperseg=512), chain(), {"excitation": 0}),
        "differences": (updated().table, {}),
        **dict.fromkeys(("damage", "convergence"), (found, {})),
        "hypotheses": (found.hypotheses, {}),
        "frame": (frame, {1: 0.4}, {}),
        "chain": (chain(), found.severity, {}),
        "mesh": (meshed_chain(), {4: 55.0}, {"excitation": 0}),
        "comparison": (ar.compare(*sets), {}),
        "identifiability": (known, {}),
        "plan": (ar.plan_test(chain(), n_sensors=2, excitations=0), {}),
        "detectability": (ar.detectability(chain(), excitation=0, std=5e-4, n_tests=1, rng=0), {}),
        "monitor": (ar.monitor([ar.AntiresonanceSet(0, {0: [8.7 * f]}) for f in scattered], baseline=50), {}),
        "tracks": (ar.track(sets), {}),
    }

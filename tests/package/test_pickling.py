"""Models, problems, searches and data through pickle and deepcopy: the same bits, and as unchangeable."""

import copy
import multiprocessing
import pickle

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.identification.stabilization import StabilizationDiagram
from tests.support.problems import PROBLEMS, QUICK, zeros

COPIES = {"pickle": lambda value: pickle.loads(pickle.dumps(value)), "deepcopy": copy.deepcopy}


@pytest.fixture(params=COPIES, scope="module")
def copied(request):
    return COPIES[request.param]


def updated(problem):
    low, high = problem.bounds.T
    return problem.model_at(low + 0.7 * (high - low))


def nearby(model, measured=None):
    measured = zeros(model, [0, 1], 1, f_max_hz=400.0) if measured is None else measured
    return ar.UpdatingProblem(model, ar.stiffness_factor([0], bounds=(0.8, 1.2)), measured)


MODELS = {name: problem.model for name, problem in PROBLEMS.items() if name != "modes"}
MODELS |= {f"updated {name}": updated(PROBLEMS[name]) for name in MODELS}
MODELS["updated twice"] = updated(nearby(MODELS["updated chain"]))  # and then looked at for damage


def same_bits(one, other):
    one, other = (value.toarray() if hasattr(value, "toarray") else value for value in (one, other))
    return np.asarray(one).tobytes() == np.asarray(other).tobytes() and np.shape(one) == np.shape(other)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.filterwarnings("ignore::antires_rs.AntiresWarning")  # some dofs are not connected
def test_a_model_has_the_same_bits(name, copied):
    model = MODELS[name]
    dofs = list(range(model.n_dof))
    for again in (copied(model), type(model).from_description(model.description)):
        assert type(again) is type(model)
        assert repr(again) == repr(model)
        assert again.description == model.description
        assert same_bits(again.stiffness(), model.stiffness())
        assert same_bits(again.mass(), model.mass())
        for one, other in zip(again.antiresonances(dofs, 1), model.antiresonances(dofs, 1), strict=True):
            assert same_bits(one, other)
        response, other = (one.frf(0, 1, [10.0, 20.0], damping_ratio=0.01) for one in (model, again))
        assert same_bits(response, other)
        if isinstance(model, ar.FrameModel):
            assert again.sections == model.sections
            assert again.node_springs == model.node_springs
        for attribute in ("description", "n_dof", "_core", "anything"):
            with pytest.raises(AttributeError):
                setattr(again, attribute, 1)
        for value in vars(again.description.recipe).values():
            assert not isinstance(value, np.ndarray) or not value.flags.writeable
    given = nearby(model)
    assert nearby(copied(again), given.measured).cost([0.9]) == given.cost([0.9])


@pytest.mark.parametrize("name", PROBLEMS)
def test_a_problem_has_the_same_bits(name, copied):
    given = PROBLEMS[name]
    again = copied(given)
    low, high = given.bounds.T
    points = low + np.random.default_rng(0).uniform(size=(5, low.size)) * (high - low)
    assert same_bits(again.evaluate_many(points), given.evaluate_many(points))
    assert same_bits(again.residuals(points[0]), given.residuals(points[0]))
    for name in ("names", "misfit", "penalty", "parameters", "objective"):
        assert getattr(again, name) == getattr(given, name)
    assert same_bits(again.bounds, given.bounds)
    assert again.cost(points[1]) == given.cost(points[1])
    assert same_bits(again.model_at(points[2]).stiffness(), given.model_at(points[2]).stiffness())
    found, wanted = (ar.update(p, optimizer=QUICK, rng=1) for p in (again, given))
    assert same_bits(found.x, wanted.x)


def test_searches(copied):
    ga = copied(QUICK)
    assert ga.options == QUICK.options
    found = ga.minimize(lambda x: float(np.sum((x - 0.3) ** 2)), [(-1, 1)] * 2, rng=0)
    again = copied(found)
    assert (again.status, again.message, again.fun) == (found.status, found.message, found.fun)
    assert same_bits(again.x, found.x)


@pytest.fixture(scope="module")
def measured():
    record = ar.cases.chain8().experiment(0, noise=0.01, duration_s=64.0, rng=1)
    response = ar.frf(record, nperseg=4096)
    zeros = ar.identify_antiresonances(record, excitation=0, band_hz=(3, 130))
    edited = zeros.drop(0, zeros[0][0], reason="hum").add(1, 77.0)
    modes = ar.identify_modes(response, band_hz=(3, 130))
    by_hand = ar.AntiresonanceSet("tip", {"tip": [3.0], "root": []})
    return [
        (record, lambda r: [r.responses, r.force]),
        (response, lambda r: [r.freq_hz, r.values, r.coherence, r.std]),
        (zeros, lambda z: [z[3], z.damping_ratio[3], z.std_hz[3], z.scores[3]["rows"]]),
        (edited, lambda z: [z[0], z.damping_ratio[1], z.original()[0]]),
        (by_hand, lambda z: [z["tip"], z["root"]]),
        (modes, lambda m: [m.freq_hz, m.shapes, m.damping_ratio]),
        (zeros.diagrams[2], lambda d: [d.orders, d.freq_hz[3], d.background, d.accepted.freq_hz]),
        (zeros.data_check, lambda c: [c.freq_hz, c.eigenvalues]),
    ]


def test_data_stay_as_they_are(measured, copied):
    for value, arrays in measured:
        again = copied(value)
        assert repr(again) == repr(value)
        for one, other in zip(arrays(again), arrays(value), strict=True):
            assert same_bits(one, other)
            assert one is not other
            assert one.dtype == other.dtype
            with pytest.raises(ValueError, match="read-only"):
                one[...] = 0
        if isinstance(value, ar.AntiresonanceSet):
            assert again == value
            assert again.original() == value.original()
            assert again.edits == value.edits
            assert again.to_json() == value.to_json()
            assert all(isinstance(d, StabilizationDiagram) for d in again.diagrams.values())


def test_two_processes_share_a_problem():
    given = PROBLEMS["chain"]
    points = np.random.default_rng(1).uniform(0.8, 1.2, (6, 2))
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        costs = pool.map(given.cost, points)
        models = pool.map(given.model_at, points[:2])
    assert same_bits(costs, given.evaluate_many(points))
    for model, x in zip(models, points, strict=False):
        assert same_bits(model.stiffness(), given.model_at(x).stiffness())

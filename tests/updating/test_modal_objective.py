"""Resonances and mode shapes as the objective: against numpy, its pairing, its results, and wrong input."""

import numpy as np
import pytest
import scipy.linalg

import antires_rs as ar
from tests.support.tolerances import COST, EXACT_SEVERITY

CASE = ar.cases.chain8()
RNG = np.random.default_rng(18)
DAMAGED, SEVERITY = 4, 0.55


def mac(phi, psi):
    """Modal assurance criterion of two vectors."""
    return abs(np.vdot(phi, psi)) ** 2 / (np.vdot(phi, phi) * np.vdot(psi, psi)).real


def reference_cost(model, measured, beta=(), gammas=(0.0, 0.0)):
    """Eq. 18 in numpy, with the pairing as documented."""
    lam, shapes = scipy.linalg.eigh(np.asarray(model.stiffness()), np.asarray(model.mass()))
    limit = (1.5 * 2 * np.pi * measured.freq_hz.max()) ** 2
    flexible = [r for r in range(lam.size) if 1e-9 * lam[-1] < lam[r] <= limit]
    cost = 0.0
    for freq, shape in zip(measured.freq_hz, measured.shapes, strict=True):
        goal = (2 * np.pi * freq) ** 2
        pairs = [
            (abs(np.log(lam[r] / goal)) + (1 - mac(shape, shapes[measured.dofs, r])) ** 2, r)
            for r in flexible
        ]
        if not pairs:
            cost += 2.0
            continue
        _, r = min(pairs)
        cost += abs(lam[r] / goal - 1.0) + (1 - mac(shape, shapes[measured.dofs, r])) ** 2
    return cost + gammas[0] * np.sum(beta) + gammas[1] * np.count_nonzero(np.asarray(beta) > 0)


def disturbed(modes, dofs, error, rng):
    """A measurement of exact modes: complex, scaled and turned at will, noisy, at a few dofs."""
    shapes = modes.shapes[:, dofs] / np.abs(modes.shapes).max(axis=1, keepdims=True)
    noise = rng.standard_normal((2, *shapes.shape)) * error
    factor = rng.uniform(0.1, 10.0, len(modes)) * np.exp(2j * np.pi * rng.random(len(modes)))
    freq = modes.freq_hz * (1.0 + 0.2 * error * rng.standard_normal(len(modes)))
    return ar.ModalSet(freq, (shapes + noise[0] + 1j * noise[1]) * factor[:, None], dofs)


@pytest.mark.parametrize("dofs", [list(range(8)), [6, 1], [3]])
def test_the_objective_is_the_independent_one(dofs):
    measured = disturbed(CASE.exact_modes(1), dofs, 0.05, RNG)
    problem = ar.UpdatingProblem(CASE.model, ar.stiffness_reduction(range(7)), measured, penalty=(0.1, 0.3))
    assert problem.objective == "modal"
    betas = RNG.uniform(0.01, 0.99, (40, 7)) * (RNG.random((40, 7)) < 0.4)
    for beta in betas:
        wanted = reference_cost(problem.model_at(beta), measured, beta, (0.1, 0.3))
        assert problem.cost(beta) == pytest.approx(wanted, rel=COST)
    np.testing.assert_array_equal(problem.evaluate_many(betas, workers=2), [problem.cost(b) for b in betas])
    np.testing.assert_array_equal(
        problem.evaluate_many(betas, workers=3), problem.evaluate_many(betas, workers=1)
    )


def frame():
    """A fixed mast with a boom, 23 beams in the plane, 69 dofs: the band route."""
    nodes = [(0.0, 0.1 * i) for i in range(16)] + [(0.1 * i, 1.5) for i in range(1, 9)]
    beams = [(i, i + 1) for i in range(23)]
    return ar.FrameModel(nodes, beams, ar.Tube(0.03, 0.002, 2.1e11, 7850.0), fixed=[0])


def test_a_frame_by_the_band_route_is_the_independent_one():
    model = frame()
    dofs = [model.dof(node, "u") for node in (4, 9, 15)] + [model.dof(node, "v") for node in (18, 23)]
    parameters = ar.stiffness_reduction(range(8))
    any_mode = ar.ModalSet([1.0], [[1.0]], dofs=[dofs[0]])
    damage = np.where(np.arange(8) == 3, 0.6, 0.0)
    modes = ar.UpdatingProblem(model, parameters, any_mode).model_at(damage).modes(n_modes=6)
    measured = disturbed(modes, dofs, 0.02, RNG)
    problem = ar.UpdatingProblem(model, parameters, measured)
    for beta in (damage, np.zeros(8), RNG.uniform(0.0, 0.9, 8)):
        assert problem.cost(beta) == pytest.approx(
            reference_cost(Dense(problem.model_at(beta)), measured), rel=1e-7
        )


class Dense:
    """Sparse matrices of a model as arrays."""

    def __init__(self, model):
        self._pair = model.stiffness().toarray(), model.mass().toarray()

    def stiffness(self):
        return self._pair[0]

    def mass(self):
        return self._pair[1]


def test_the_mac_of_a_problem_is_that_of_the_sets():
    measured = disturbed(CASE.exact_modes(1), [0, 2, 5, 7], 0.05, RNG)
    problem = CASE.damage_problem(measured)
    x = np.zeros(7)
    pairs = measured.mac(CASE.exact_modes(0))
    np.testing.assert_allclose(problem.paired_mac(x), np.diag(pairs), rtol=1e-9)
    np.testing.assert_allclose(problem.paired_hz(x), CASE.exact_modes(0).freq_hz, rtol=1e-9)


def test_residuals_are_those_of_the_frequencies_then_of_the_shapes():
    problem = CASE.damage_problem(disturbed(CASE.exact_modes(1), [0, 4, 7], 0.05, RNG))
    x = np.array([0.1, 0, 0, 0, 0.4, 0, 0])
    e, shape = problem.residuals(x)[:7], problem.residuals(x)[7:]
    np.testing.assert_allclose(e, (problem.paired_hz(x) / problem.measured_hz) ** 2 - 1.0, rtol=COST)
    np.testing.assert_allclose(shape, 1.0 - problem.paired_mac(x), rtol=COST)
    assert np.abs(e).sum() + (shape**2).sum() + 0.25 == pytest.approx(problem.cost(x), rel=COST)


@pytest.mark.parametrize(
    ("misfit", "norm"),
    [
        ("absolute", lambda e: np.abs(e).sum()),
        ("squared", lambda e: np.sum(e**2)),
        ("largest", lambda e: np.abs(e).max()),
    ],
)
def test_the_misfit_is_of_the_frequencies_and_weights_are_of_both(misfit, norm):
    measured = disturbed(CASE.exact_modes(1), [0, 4, 7], 0.05, RNG)
    weights = RNG.uniform(0.2, 2.0, 7)
    problem = ar.UpdatingProblem(
        CASE.model, ar.stiffness_reduction(range(7)), measured, misfit=misfit, weights=weights
    )
    x = RNG.uniform(0.0, 0.5, 7)
    e, shape = np.split(problem.residuals(x), 2)
    assert problem.cost(x) == pytest.approx(norm(weights * e) + ((weights * shape) ** 2).sum(), rel=COST)


# ---- pairing -----------------------------------------------------------------------------------------


def test_modes_that_have_changed_places_keep_their_shapes():
    """Two oscillators hardly joined; in the model the other one is the softer."""
    build = [
        ar.MassSpringChain([1.0, 1.0], [1.0], ground_first_n_per_m=a, ground_last_n_per_m=b)
        for a, b in ((900.0, 1000.0), (1000.0, 900.0))
    ]
    truth, model = build[0].modes(), build[1].modes()
    problem = ar.UpdatingProblem(build[1], ar.stiffness_factor([1, 2], bounds=(0.7, 1.4)), truth)
    np.testing.assert_allclose(problem.paired_hz([1.0, 1.0]), model.freq_hz[::-1], rtol=1e-9)
    assert np.all(problem.paired_mac([1.0, 1.0]) > 0.99)
    result = ar.update(problem, rng=0)
    np.testing.assert_allclose(result.x, [0.9, 10 / 9], atol=1e-6)


def test_no_far_mode_and_no_rigid_body_takes_a_partner_from_a_nearer_one():
    """At dofs 0 and 1 a measured shape may look like the rigid body, or like a mode much higher."""
    modes = CASE.model.modes()
    for shape in ([1.0, 1.0], modes.shapes[5][:2]):
        problem = CASE.damage_problem(ar.ModalSet([24.0, 110.0], [shape, modes.shapes[7][:2]], [0, 1]))
        assert problem.paired_hz(np.zeros(7))[0] == pytest.approx(modes.freq_hz[1], rel=1e-9)


def test_with_one_sensor_the_nearest_frequency_is_the_partner_and_one_may_serve_two():
    modes = CASE.model.modes()
    problem = CASE.damage_problem(
        ar.ModalSet([0.95 * modes.freq_hz[2], 1.02 * modes.freq_hz[2]], [[1.0], [-2.0j]], [3])
    )
    np.testing.assert_allclose(problem.paired_hz(np.zeros(7)), modes.freq_hz[2], rtol=1e-9)
    np.testing.assert_allclose(problem.paired_mac(np.zeros(7)), 1.0)


def test_a_repeated_mode_is_compared_by_its_space():
    """Two equal oscillators: any combination of their motions is a mode."""
    model = ar.MatrixModel(
        np.diag([400.0, 400.0, 900.0]), np.eye(3), stiffness_terms=[np.diag([1.0, 1.0, 0.0])]
    )
    measured = ar.ModalSet([20.0 / (2 * np.pi)], [[0.8, -0.6j, 0.0]])
    problem = ar.UpdatingProblem(model, ar.stiffness_factor([0], bounds=(0.5, 2.0)), measured)
    assert problem.cost([1.0]) == pytest.approx(0.0, abs=1e-12)


def test_the_cost_is_finite_without_any_partner():
    model = ar.MassSpringChain([1.0, 1.0], [500.0])
    measured = ar.ModalSet([5.0], [[1.0, -1.0]])
    problem = ar.UpdatingProblem(model, ar.stiffness_reduction([0], bounds=(0.0, 1.0)), measured)
    assert problem.cost([1.0]) == 2.0
    assert np.isnan(problem.paired_hz([1.0])[0])
    assert np.isnan(problem.paired_mac([1.0])[0])
    np.testing.assert_array_equal(problem.residuals([1.0]), [1.0, 1.0])


def test_rigid_body_modes_of_the_measurement_are_left_out():
    free = CASE.true_model(1).modes()
    assert free.freq_hz[0] == 0.0
    problem = CASE.damage_problem(free)
    np.testing.assert_array_equal(problem.measured_hz, free.freq_hz[1:])
    np.testing.assert_array_equal(ar.update(problem, rng=0).table.mode, range(1, 8))


def test_several_sets_of_sensors_add_up():
    modes = CASE.exact_modes(1)
    sets = [
        ar.ModalSet(modes.freq_hz[:3], modes.shapes[:3][:, [0, 4]], [0, 4]),
        ar.ModalSet(modes.freq_hz[2:], modes.shapes[2:][:, [1, 6, 7]], [1, 6, 7]),
    ]
    x = RNG.uniform(0.0, 0.3, 7)
    parameters = ar.stiffness_reduction(range(7))
    alone = [ar.UpdatingProblem(CASE.model, parameters, s) for s in sets]
    both = ar.UpdatingProblem(CASE.model, parameters, sets)
    one_by_one = np.concatenate([p.paired_mac(x) for p in alone])
    np.testing.assert_allclose(both.paired_mac(x), one_by_one, rtol=1e-9)
    assert ar.assess_damage(CASE.model, sets, rng=0).damaged == [DAMAGED]


# ---- results -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def damage():
    measured = disturbed(CASE.exact_modes(1), list(range(8)), 0.01, np.random.default_rng(3))
    return ar.assess_damage(CASE.model, measured, rng=1)


@pytest.mark.parametrize(
    ("dofs", "error", "seed"), [(list(range(8)), 0.01, 0), ([0, 3, 6], 0.01, 1), ([2, 5], 0.01, 2)]
)
def test_damage_is_found_from_disturbed_modes(dofs, error, seed):
    measured = disturbed(CASE.exact_modes(1), dofs, error, np.random.default_rng(seed))
    result = ar.assess_damage(CASE.model, measured, rng=seed)
    assert result.success
    assert result.damaged == [DAMAGED]
    assert result.severity[DAMAGED] == pytest.approx(SEVERITY, abs=0.01)


def test_exact_modes_give_the_exact_answer():
    result = ar.assess_damage(CASE.model, CASE.exact_modes(1), rng=0)
    assert result.damaged == [DAMAGED]
    assert result.severity[DAMAGED] == pytest.approx(SEVERITY, abs=EXACT_SEVERITY)
    assert result.fun == pytest.approx(0.05 * (1.0 + SEVERITY), abs=2 * EXACT_SEVERITY)  # 7 modes


def test_both_objectives_from_one_record():
    """Row 11b in small; in full: benchmarks/both_objectives.py."""
    record = CASE.experiment(level=1, noise=0.01, rng=5, duration_s=128.0)
    modes = ar.identify_modes(record, band_hz=CASE.band_hz, route="responses")
    zeros = ar.identify_antiresonances(record, excitation=0, band_hz=CASE.band_hz)
    for measured, objective in ((modes, "modal"), (zeros, "antiresonance")):
        result = ar.update(CASE.damage_problem(measured), rng=0)
        assert result.problem.objective == objective
        assert np.flatnonzero(result.x).tolist() == [DAMAGED]
        assert result.x[DAMAGED] == pytest.approx(SEVERITY, abs=0.02)


@pytest.mark.parametrize("workers", [2, 5])
def test_the_same_bits_for_any_number_of_threads(damage, workers):
    other = ar.assess_damage(CASE.model, damage.problem.measured, rng=1, workers=workers)
    assert damage.x.tobytes() == other.x.tobytes()
    assert damage.search.populations.tobytes() == other.search.populations.tobytes()


def test_the_table_has_a_column_of_mac(damage):
    table = damage.table
    assert isinstance(table, ar.ModalTable)
    np.testing.assert_array_equal(table.after_hz, damage.problem.paired_hz(damage.x))
    np.testing.assert_array_equal(table.before_mac, damage.problem.paired_mac(np.zeros(7)))
    assert table.before_mac.min() < 0.8 < 0.99 < table.after_mac.min()
    assert table.largest_before_percent > 10.0 > 1.0 > table.largest_after_percent
    text = str(table)
    assert len(text.splitlines()) == 2 + 7 + 1
    assert f"{table.after_mac[3]:.3f}" in text
    assert "MAC" in damage.summary()


def test_every_spring_of_a_free_chain_is_seen_alike(damage):
    """A chain is statically determinate: phi' K_i phi / lambda, summed over modes, is trace(K+ K_i) = 1 for
    every spring i. To first order a loss beta costs beta whichever spring it is, against 0.05 beta + 0.05."""
    visible = np.array(list(damage.detectable.values()))
    np.testing.assert_allclose(visible, 1 / 19, rtol=0.1)
    assert np.ptp(visible) < 2e-3
    assert "(spring" in " ".join(damage.notes)


def test_what_modes_cannot_tell_is_said():
    """Resonances see all masses and springs but their common scale."""
    case = ar.cases.chain8(perturbation=0.05, rng=3)
    problem = case.updating_problem(case.exact_modes(0))
    result = ar.update(problem, rng=0, optimizer=ar.IslandGA(max_evaluations=20_000))
    assert result.table.largest_after_percent < 0.1
    found = result.identifiability
    assert found.rank == 14
    assert found.scale_unseen
    notes = " ".join(result.notes)
    assert "a common scale moves no mode" in notes
    assert "antiresonance" not in notes
    ratios = result.x / result.x[-1]
    truth = np.concatenate([case.truth()["mass_factor"], case.truth()["stiffness_factor"]])
    np.testing.assert_allclose(ratios, truth / truth[-1], atol=0.02)


@pytest.mark.usefixtures("quick_pictures")
def test_pictures_and_report(damage, tmp_path):
    figure = pytest.importorskip("matplotlib.figure")
    pytest.importorskip("jinja2")
    from antires_rs.figures.damage import plot_damages

    ax = damage.plot(ax=figure.Figure().subplots(), truth={DAMAGED: SEVERITY})
    assert ax.get_ylabel() == "Stiffness loss (%)"
    ax = ar.UpdateResult.plot(damage, ax=figure.Figure().subplots())
    assert len(ax.containers) == 2
    shown = " ".join(text.get_text() for text in ax.texts)
    assert f"{damage.table.after_mac[0]:.3f}" in shown
    beside = ar.assess_damage(CASE.model, CASE.exact(1), rng=0)
    ax = plot_damages(
        {"zeros": beside, "modes": damage}, ax=figure.Figure().subplots(), truth={DAMAGED: SEVERITY}
    )
    heights = [bar.get_height() for bars in ax.containers for bar in bars]
    np.testing.assert_allclose(heights, 100 * np.concatenate([beside.x, damage.x]))
    other = ar.assess_damage(CASE.model, CASE.exact(1), elements=[4])
    for wrong in ({"alone": beside}, {"a": beside, "b": other}):
        with pytest.raises(ar.InvalidInputError, match="results"):
            plot_damages(wrong, ax=figure.Figure().subplots())
    damage.report(tmp_path / "modes.html", truth={DAMAGED: SEVERITY})
    html = (tmp_path / "modes.html").read_text()
    assert "Damage assessment with resonances and mode shapes" in html
    assert "7 measured resonances with shapes at 8 dofs" in html
    assert html.count('<th scope="col">MAC</th>') == 2
    for value in (*damage.table.before_mac, *damage.table.after_mac):
        assert f"<td>{value:.3f}</td>" in html
    assert "antiresonance" not in html.split("<footer")[0].replace("antires_rs", "")


@pytest.mark.usefixtures("quick_pictures")
def test_the_report_of_identified_modes_shows_their_diagram(tmp_path):
    pytest.importorskip("jinja2")
    record = CASE.experiment(level=1, noise=0.01, rng=6, duration_s=64.0)
    modes = ar.identify_modes(record, band_hz=CASE.band_hz, route="responses")
    result = ar.assess_damage(CASE.model, modes, rng=0)
    result.report(tmp_path / "modes.html")
    assert "Stabilization diagram of all responses" in (tmp_path / "modes.html").read_text()
    response = ar.transmissibility(record, 0, nperseg=4096)
    with pytest.raises(ar.InvalidInputError, match="response: got transmissibilities"):
        result.report(tmp_path / "other.html", response=response)


# ---- wrong input -------------------------------------------------------------------------------------


def one_mode(freq_hz=20.0, shape=(1.0, -1.0), dofs=(0, 1)):
    return ar.ModalSet([freq_hz], [list(shape)], list(dofs))


@pytest.mark.parametrize(
    ("measured", "words"),
    [
        (one_mode(dofs=(0, 8)), "measured dof: got 8"),
        (one_mode(dofs=(0, "tip")), "measured dof: got 'tip'"),
        (one_mode(shape=(0.0, 0.0)), "zero at every dof"),
        (one_mode(freq_hz=-3.0), "positive"),
        (one_mode(freq_hz=0.0), "no mode"),
        (ar.ModalSet([], np.empty((0, 2))), "no mode"),
        ([one_mode(), ar.AntiresonanceSet(0, {0: [12.0]})], "several of one kind"),
        ([], "an AntiresonanceSet or a ModalSet"),
        ("modes", "an AntiresonanceSet or a ModalSet"),
    ],
)
def test_measurements_that_cannot_be(measured, words):
    with pytest.raises(ar.InvalidInputError, match=words):
        ar.UpdatingProblem(CASE.model, ar.stiffness_reduction(range(7)), measured)


def test_the_objective_must_be_that_of_the_measurement():
    parameters = ar.stiffness_reduction(range(7))
    for measured, right, wrong in (
        (CASE.exact_modes(1), "modal", "antiresonance"),
        (CASE.exact(1), "antiresonance", "modal"),
    ):
        problem = ar.UpdatingProblem(CASE.model, parameters, measured, objective=right)
        assert problem.objective == right
        with pytest.raises(ar.InvalidInputError, match="measured: got a"):
            ar.UpdatingProblem(CASE.model, parameters, measured, objective=wrong)
        with pytest.raises(ar.InvalidInputError, match="objective"):
            ar.UpdatingProblem(CASE.model, parameters, measured, objective="shapes")


def test_what_only_one_kind_has():
    with pytest.raises(ar.InvalidInputError, match="Antiresonances have no shape"):
        CASE.damage_problem().paired_mac(np.zeros(7))
    problem = CASE.damage_problem(CASE.exact_modes(1))
    assert problem.measured_dofs is None
    assert problem.measured_excitations is None
    assert "7 modes" in repr(problem)


@pytest.mark.parametrize("weights", ["std", [1.0], -np.ones(7), np.zeros(7)])
def test_weights_that_cannot_be(weights):
    with pytest.raises(ar.InvalidInputError, match="weights"):
        ar.UpdatingProblem(CASE.model, ar.stiffness_reduction(range(7)), CASE.exact_modes(1), weights=weights)

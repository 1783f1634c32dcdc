"""Every formulation finds what it should: those of all transmissibilities, and those of the paper's curve."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs import FitOptions
from antires_rs.exceptions import InvalidInputError
from antires_rs.identification.lines import Lines, lines_of_recording
from antires_rs.identification.options import check_formulation
from antires_rs.identification.paper import PowerFit, PowerSweep, real_basis, real_roots, sweep_of
from antires_rs.identification.rational_fit import guessed_poles, guessed_weights
from antires_rs.identification.stabilization import diagram
from antires_rs.signals.averaging import Averaging, average
from antires_rs.signals.recording import Recording
from reference.matching import match
from reference.structures import structure
from reference.virtual_records import (
    CHAIN8_MASSES,
    CHAIN8_SPRINGS,
    accelerance,
    chain8_matrices,
    chain_matrices,
    random_record,
    true_antiresonances,
)
from tests.support.campaign import campaign

STIFFNESS, MASS = chain8_matrices()
TRUTH = [true_antiresonances(STIFFNESS, MASS, dof, 0) for dof in range(8)]
BAND = (3.0, 130.0)


@pytest.fixture(scope="module")
def lines():
    """Exact responses, with the signal-to-noise ratio of a good test."""
    freq = np.arange(3.0, 130.0, 1 / 16)
    x = accelerance(STIFFNESS, MASS, 0, freq, 0.01)
    size = np.linalg.norm(x, axis=0)
    return Lines(freq, x / size, 1e6 * size**2 / np.median(size**2))


#: The paper's: 1 % and 5 % in more than ten orders, and no other test.
PAPER = FitOptions(damping_tol=0.05, min_dominance=0.0, persistent=False)


def found_by(formulation, lines, row, rule=None):
    rule = rule or FitOptions()
    sweep, orders, background = sweep_of(lines, row, 2, 60, rule, formulation)
    assert background.shape == lines.freq_hz.shape
    assert background.min() >= 0.0
    return diagram(sweep, orders, BAND, rule, lines.freq_hz, background)


@pytest.mark.parametrize("formulation", ["joint", "power"])
@pytest.mark.parametrize("row", [0, 3, 5])
def test_exact_responses_give_all_antiresonances(lines, formulation, row):
    found = found_by(formulation, lines, row)
    near = [np.abs(found.identified / f - 1.0).min() for f in TRUTH[row]]
    # abs(s) of the damped zero differs from the undamped root by less than this.
    assert max(near) < 1e-3
    if formulation != "power":  # without phase a false one is possible beyond the last resonance, 115 Hz
        assert found.identified.size == TRUTH[row].size
    assert np.count_nonzero(found.identified < 115.0) == np.count_nonzero(TRUTH[row] < 115.0)
    # Modal damping of 1 % makes antiresonances of 0.5 to 1.07 %.
    assert np.all(
        (found.identified_damping[found.identified < 115.0] > 0.004)
        & (found.identified_damping[found.identified < 115.0] < 0.012)
    )


def test_all_formulations_agree_in_damping(lines):
    zeta = {name: found_by(name, lines, 2).identified_damping[:5] for name in ("joint", "power")}
    assert np.allclose(zeta["power"], zeta["joint"], rtol=0.01)


def test_the_papers_curve_has_its_peaks_at_the_antiresonances(lines):
    hits, false = {}, {}
    for name in ("eq10", "eq10_squared"):
        hits[name], false[name] = 0, 0
        for row in (0, 2, 4):
            values = found_by(name, lines, row, PAPER).identified
            near = [values.size > 0 and np.abs(values / f - 1.0).min() < 0.01 for f in TRUTH[row]]
            hits[name] += sum(near)
            false[name] += values.size - sum(near)
    # Of 15. On exact curves the kinks are sharp and take most of the orders; and |T| itself has branch points
    # where its square has poles.
    assert hits["eq10_squared"] > 2 * hits["eq10"]
    assert max(false.values()) <= 1


def test_one_transmissibility_alone_is_its_own_power(lines):
    # With two channels Eq. 10 has one term, no kink in its size, and is what "power" fits.
    two = Lines(lines.freq_hz, lines.vectors[[2, 5]], lines.snr)
    for name in ("eq10_squared", "power"):
        values = found_by(name, two, 0, PAPER).identified
        inside = TRUTH[2][TRUTH[2] < 110.0]
        near = [np.abs(values / f - 1.0).min() for f in inside]
        assert max(near) < 1e-3, name


def identified(structure, record, **options):
    """Found and false values under preset="paper"."""
    found = ar.identify_antiresonances(
        record, excitation=0, band_hz=structure.band_hz, preset="paper", check="off", **options
    )  # says nothing: warnings are errors here
    matched = [match(found[dof], values) for dof, values in structure.truth().items()]
    return sum(len(m.pairs) for m in matched), sum(len(m.false) for m in matched)


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_the_papers_preset_on_a_record(noise):
    four = structure(*chain_matrices(CHAIN8_MASSES[:4], CHAIN8_SPRINGS[:3]))
    found, false = identified(four, four.record(noise=noise, seed=7, duration_s=60.0))
    assert (found >= 5, false <= 1) == (True, True), (found, false)  # of 6


@campaign
@pytest.mark.parametrize("seed", [7, 8, 9])
def test_the_papers_preset_on_the_papers_chain(seed):
    eight = structure(*chain8_matrices())
    found, false = identified(eight, eight.record(noise=0.0, seed=seed))
    assert (found >= 26, false <= 1) == (True, True), (found, false)  # of 28


def test_the_papers_preset_on_frfs_keeps_its_rule():
    three = structure(*chain_matrices(CHAIN8_MASSES[:3], CHAIN8_SPRINGS[:2]))
    record = three.record(noise=0.01, seed=7, duration_s=30.0)
    options = {"excitation": 0, "band_hz": three.band_hz, "route": "frf", "check": "off"}
    by_preset = ar.identify_antiresonances(record, **options, preset="paper")
    by_name = ar.identify_antiresonances(
        record, **options, preset="paper", fit=ar.FitOptions(formulation="joint")
    )
    assert by_preset == by_name
    with pytest.raises(InvalidInputError, match="^formulation: got eq10_squared"):
        ar.identify_antiresonances(record, **options, fit=ar.FitOptions(formulation="eq10_squared"))


def test_noise_at_one_percent():
    responses, _ = random_record(STIFFNESS, MASS, noise=0.01, seed=13, duration_s=200.0)
    record = Recording(responses, 512.0)
    averages = average(record, BAND, Averaging(nperseg=8192, method="welch"))
    lines_for = lines_of_recording(record, averages, BAND, use_force=False, estimator="rank1")
    for formulation, least in (("joint", 15), ("power", 14)):
        hits = false = 0
        for row in (0, 2, 4):  # 7, 5 and 3
            values = found_by(formulation, lines_for(row), row).identified
            good = [v for v in values if TRUTH[row].size and np.abs(TRUTH[row] / v - 1.0).min() < 0.01]
            hits, false = hits + len(good), false + values.size - len(good)
        assert (hits >= least, false <= 1) == (True, True), (formulation, hits, false)


def test_bad_arguments_are_named(lines):
    with pytest.raises(InvalidInputError, match="^formulation: got 'eq11'"):
        sweep_of(lines, 0, 2, 60, FitOptions(), "eq11")
    with pytest.raises(InvalidInputError, match="^formulation: got 'sum'.* use formulation='joint'"):
        check_formulation("sum")
    few = lines.part(0, 30)
    assert sweep_of(few, 0, 2, 60, FitOptions(), "joint")[1] == range(2, 21)
    # Without phase a line is one number, not two.
    with pytest.raises(InvalidInputError, match="^band_hz: got a band with 30 lines"):
        sweep_of(few, 0, 2, 60, FitOptions(), "power")


# ---- the real rational function of f^2 ---------------------------------------------------------------


def test_the_real_basis_is_orthonormal():
    rng = np.random.default_rng(13)
    t = 2.0 * np.linspace(0.0, 1.0, 300) ** 2 - 1.0
    weight = rng.uniform(0.1, 10.0, 300)
    basis = real_basis(t, weight, 80)  # far beyond 2 sqrt(300), where the recurrence alone is lost
    assert np.abs(basis.p.T @ (weight[:, None] * basis.p) - np.eye(81)).max() < 1e-12
    # The recurrence off the lines is that of the values on them, as far as it goes by itself.
    assert np.allclose(basis.at(t[::20] + 0j, 25), basis.p[::20, :26], atol=1e-9)


def test_real_roots_are_where_the_sum_vanishes():
    t = np.linspace(-1.0, 1.0, 400)
    basis = real_basis(t, np.ones(400), 15)
    coefficients = np.random.default_rng(13).standard_normal(16)
    found = real_roots(coefficients, basis)
    assert found.size == 15
    terms = basis.at(found, 15) * coefficients
    assert np.all(np.abs(terms.sum(axis=1)) < 1e-9 * np.abs(terms).sum(axis=1))
    assert real_roots(np.array([1.0, 0.5, 1e-18]), basis).size == 1
    assert real_roots(np.array([1.0, 0.0]), basis).size == 0


@pytest.mark.parametrize("norm", [False, True])
def test_poles_of_squared_magnitudes_lie_in_the_left_half_plane(norm):
    freq = np.linspace(1.0, 50.0, 1200)
    s = 2j * np.pi * freq
    true = 2 * np.pi * np.array([-0.1 + 12.0j, -0.2 + 31.0j])
    curves = [
        sum(r / (s - p) + np.conj(r) / (s - p.conj()) for r, p in zip(row, true, strict=True))
        for row in ((1.0, 1.0j), (2.0, -1.0))
    ]
    squares = np.abs(np.array(curves)) ** 2
    sweep = PowerSweep(PowerFit(freq, squares, 1.0 / squares.sum(axis=0) ** 2, 20))
    poles = sweep.roots(4, norm)
    upper = poles[poles.imag > 0]
    assert np.allclose(upper[np.argsort(upper.imag)], true, rtol=1e-7)
    assert np.all(poles.real < 0)
    # Alone at its frequency each pole owns the curve.
    assert np.all(sweep.dominances(4, true) > 0.9)
    data, fit = sweep.curves(4)
    assert np.allclose(fit, data, rtol=1e-6)


def test_units_do_not_matter_to_the_power_fit():
    freq = np.linspace(1.0, 50.0, 600)
    y = 1.0 / np.abs(20.0**2 - freq**2 + 0.4j * freq) ** 2
    for factor in (1e-12, 1.0, 1e12):
        fit = PowerFit(freq, factor * y[None], 1.0 / y**2, 10)
        s = fit.poles(fit.denominator(fit.gram(2)))
        assert np.abs(s).max() / (2 * np.pi) == pytest.approx(20.0, rel=1e-6)


# ---- the guess to start from -------------------------------------------------------------------------


def test_guessed_poles_lie_where_the_curve_moves():
    freq = np.linspace(1.0, 200.0, 4000)
    power = 1.0 / np.abs((5.0**2 - freq**2 + 0.1j * freq) * (9.0**2 - freq**2 + 0.1j * freq)) ** 2
    poles = guessed_poles(freq, power, 8)
    # Evenly laid, the first of eight would be at 13 Hz.
    assert np.count_nonzero(poles.imag < 2 * np.pi * 12.0) == 3
    assert np.all(poles.real < 0)
    flat = guessed_poles(freq, np.ones(4000), 4)
    assert np.allclose(flat.imag / (2 * np.pi), 1.0 + 199.0 * (np.arange(4) + 0.5) / 4)


@pytest.mark.parametrize("order", [0, 1, 2, 60, 400])
def test_guessed_weights_are_finite_and_positive(order):
    freq = np.linspace(0.0, 500.0, 2000)
    power = np.where(freq < 100, 0.0, 1.0 + freq)  # lines without any signal, and zero frequency
    weights = guessed_weights(freq, power, order)
    assert np.isfinite(weights).all()
    assert weights.min() > 0

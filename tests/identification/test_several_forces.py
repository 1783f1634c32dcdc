"""Several unknown forces: minors, their noise, how many act, and what is found of exact roots."""

from itertools import combinations

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.identification import minors
from antires_rs.identification.column_fit import likeliest_columns
from antires_rs.identification.minors import MinorLines, Subspaces, minors_of, subspace, tangents
from antires_rs.identification.selection import _joined, order_scatter
from antires_rs.identification.stability import looks_of
from antires_rs.signals.averaging import Averaging, average
from antires_rs.signals.repeats import one_source
from antires_rs.signals.spectra import Segments
from reference.deleted_pencils import antiresonances_hz
from reference.forces_bound import Bound, Receptances, information, inverse
from reference.several_forces import modal_record, modes_of, record_of, verdict, verdict_of
from tests.support.refusals import refused, unsuitable

BAND = (3.0, 130.0)
CHAIN = ar.cases.chain8().model
STIFFNESS, MASS = (np.asarray(a) for a in (CHAIN.stiffness(), CHAIN.mass()))


def quiet(record, excitation, **options):
    return ar.identify_antiresonances(record, excitation=excitation, band_hz=BAND, check="off", **options)


@pytest.fixture(scope="module")
def record():
    return record_of(CHAIN, (0, 4), 240.0, 0.01, 3)


@pytest.fixture(scope="module")
def zeros(record):
    return ar.identify_antiresonances(record, excitation=[4, 0], band_hz=BAND, check="raise")


def rows_of(n, order):
    return np.array(list(combinations(range(n), order)))


# -- Minors and their noise


@pytest.mark.parametrize(("n", "order"), [(6, 2), (6, 3), (7, 4)])
def test_minors_and_what_moves_them_are_orthonormal(n, order):
    rng = np.random.default_rng(n)
    basis = np.linalg.qr(rng.standard_normal((n, n)) + 1j * rng.standard_normal((n, n)))[0][None]
    rows = rows_of(n, order)
    own = minors_of(basis[..., :order], rows)
    moves = tangents(basis[..., :order], basis[..., order:], rows).reshape(1, len(rows), -1)
    together = np.concatenate([own[..., None], moves], axis=2)[0]
    assert np.abs(together.conj().T @ together - np.eye(together.shape[1])).max() < 1e-12


def test_minors_of_receptances_have_lost_forces_and_resonances():
    """Ratios of the minors of H[:, J] are those of the deleted determinants, by Jacobi's identity."""
    w2 = (2 * np.pi * 40.0) ** 2
    dynamic = STIFFNESS - w2 * MASS
    columns = np.linalg.inv(dynamic)[:, [0, 4]] @ np.array([[1.0, 2.0 - 1j], [0.3j, 1.5]])
    rows = rows_of(8, 2)
    own = minors_of(columns[None], rows)[0]
    deleted = np.array([np.linalg.det(np.delete(np.delete(dynamic, pair, 0), [0, 4], 1)) for pair in rows])
    signs = np.array([(-1.0) ** (pair.sum()) for pair in rows])
    heard = np.abs(deleted) > 1e-9 * np.abs(deleted).max()
    ratio = own[heard] / (signs * deleted)[heard]
    assert np.abs(ratio / ratio[0] - 1.0).max() < 1e-9
    assert np.abs(own[~heard]).max() < 1e-9 * np.abs(own).max()


@pytest.mark.parametrize("order", [2, 3])
def test_noise_of_minors_is_that_of_many_records(order):
    """The scatter of minors over many averaged matrices is what the segments of each state."""
    n, count, trials = 6, 200, 2000
    rng = np.random.default_rng(order)
    signal = np.linalg.qr(rng.standard_normal((n, order)) + 1j * rng.standard_normal((n, order)))[0]
    size = np.array([60.0, 25.0, 12.0])[:order]
    shape = (trials, order, count)
    s = (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2)
    x = (signal * size) @ s
    x += (rng.standard_normal(x.shape) + 1j * rng.standard_normal(x.shape)) / np.sqrt(2)
    segments = Segments.of(x)
    values, vectors = subspace(segments.matrix, np.ones(n))
    some = Subspaces(np.arange(float(trials)), values, vectors, segments, order, np.ones(trials))
    rows = rows_of(n, order)
    true = minors_of(signal[None], rows)[0]
    own = some.minors(rows)
    along = own @ true.conj()
    error = own * (along.conj() / np.abs(along))[:, None] - true
    moves = some.moves(rows, slice(None))
    assert np.abs(moves.mean(axis=2)).max() < 1e-9
    stated = np.mean(np.abs(moves) ** 2, axis=2).mean(axis=0) / count
    assert np.abs(np.mean(np.abs(error) ** 2, axis=0) / stated - 1.0).max() < 0.12
    total = some.noise.mean() * order * (n - order) / count
    assert np.mean(np.sum(np.abs(error) ** 2, axis=1)) == pytest.approx(total, rel=0.05)


# -- How well values can be known, and are

SMALL = ar.MassSpringChain([1.0, 0.8, 1.2, 0.9, 1.1], [4e4, 3e4, 5e4, 3.5e4], ground_first_n_per_m=2e4)
STILL = [np.asarray(matrix) for matrix in (SMALL.stiffness(), SMALL.mass())]
STRUCTURE = modes_of(SMALL, 0.01, (5.0, 70.0), 200.0)


def test_the_bound_is_that_of_the_whole_likelihood():
    """The formula of Slepian and Bangs with the spectra of the forces, unknown at every line, eliminated."""
    exact, noise = Receptances(STRUCTURE, (0, 3)), np.array([0.5, 1.0, 2.0, 1.5, 0.8]) * 1e-3
    freq_hz, looks = np.linspace(6.0, 65.0, 9), 7.0
    units = [
        np.array(one) for one in ([[1, 0], [0, 0]], [[0, 0], [0, 1]], [[0, 1], [1, 0]], [[0, 1j], [-1j, 0]])
    ]
    total = 0.0
    for f in freq_hz:
        a, d = exact.at(2j * np.pi * f), exact.by_parameters(2j * np.pi * f)
        s = a @ a.conj().T + np.diag(noise)
        changes = [one @ a.conj().T + a @ one.conj().T for one in d]
        changes += [a @ one @ a.conj().T for one in units]
        white = [np.linalg.solve(s, one) for one in changes]
        j = looks * np.array([[np.trace(p @ q).real for q in white] for p in white])
        t = len(d)
        total = total + j[:t, :t] - j[:t, t:] @ np.linalg.solve(j[t:, t:], j[t:, :t])
    of_module = information(exact, freq_hz, noise, looks)
    assert np.abs(of_module - total).max() < 1e-9 * np.abs(total).max()


def lines_of(some, rows, leakage):
    own = {"order": some.order, "subspaces": some, "rows": rows, "leakage": leakage}
    return MinorLines(some.freq_hz, some.minors(rows).T, 1.0 / some.noise, 0.0, some.segments, **own)


@pytest.mark.parametrize("noise", [1.0, 1e-6])
def test_what_a_window_leaks_from_line_to_line_is_taken_out(noise):
    """The expected spectra under a Hann window, which puts a sixth of the power into each line beside.

    With hardly any noise it is what leaks that the level of every line tells.
    """
    freq_hz, exact, rows = np.linspace(5.0, 70.0, 1000), Receptances(STRUCTURE, (0, 2)), rows_of(5, 2)
    a = exact.at(2j * np.pi * freq_hz) / np.sqrt(1e-4)
    sharp = a @ a.conj().transpose(0, 2, 1)
    seen = sharp[1:-1] * 2.0 / 3.0 + (sharp[:-2] + sharp[2:]) / 6.0 + noise * np.eye(5)
    values, vectors = subspace(seen.conj(), np.ones(5))
    floor = minors.floor_of(values, 2)
    some = Subspaces(freq_hz[1:-1], values / floor[:, None], vectors, None, 2, floor)
    bound, off = Bound(STRUCTURE, (0, 2), 1.0, 0.0), []
    for leakage in (np.empty(0), np.array([1.0 / 6.0])):
        best = likeliest_columns(lines_of(some, rows, leakage), 40)
        off.append([])
        for row, pair in enumerate(rows):
            exact_hz = antiresonances_hz(*STILL, list(pair), [0, 2])
            exact_hz = np.empty(0) if exact_hz is None else exact_hz
            s = best.fit.zeros(best.coefficients[:, row])
            off[-1] += [np.abs(s / near.mean() - 1.0).min() for near in bound.zeros(pair, exact_hz)]
    before, after = np.array(off)
    assert before.size > 10
    assert np.median(after) < 0.1 * np.median(before)


def test_zeros_of_a_fit_scatter_by_the_bound():
    """And what a fit states is what they scatter by; ten records in white noise."""
    freq_hz, looks, noise = np.linspace(5.0, 70.0, 500), 60, np.full(5, 0.1)
    bound = Bound(STRUCTURE, (0, 2), 1.0, 0.0)
    bound.covariance = inverse(information(bound.exact, freq_hz, noise, looks))
    a = bound.exact.at(2j * np.pi * freq_hz) / np.sqrt(noise)[:, None]
    rows, rng, off, stated = rows_of(5, 2), np.random.default_rng(20), [], []

    def circular(*shape):
        return (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2)

    for _ in range(10):
        segments = Segments.of(a @ circular(500, 2, looks) + circular(500, 5, looks))
        some = Subspaces(freq_hz, *subspace(segments.matrix, np.ones(5)), segments, 2, np.ones(500))
        lines = lines_of(some, rows, np.empty(0))
        best = likeliest_columns(lines, 40)
        influence = best.influence(lines)
        assert best.misfit == pytest.approx(some.by_noise(slice(None), 1.0), rel=0.1)
        for row, pair in enumerate(rows):
            exact_hz = antiresonances_hz(*STILL, list(pair), [0, 2])
            if exact_hz is None or not exact_hz.size:
                continue
            s = best.fit.zeros(best.coefficients[:, row])
            s = s[s.imag > 0.0]
            for near, std in zip(bound.zeros(pair, exact_hz), bound.std_hz(pair, exact_hz), strict=True):
                hz = abs(near.mean()) / (2 * np.pi)
                at = np.argmin(np.abs(np.abs(s) / (2 * np.pi) - hz))
                off.append((abs(s[at]) / (2 * np.pi) - hz) / std)
                stated.append(influence.standard_deviations(row, s[[at]])[0] / std)
    assert len(off) > 100
    assert 0.8 < np.sqrt(np.mean(np.square(off))) < 1.2
    assert 0.9 < np.median(stated) < 1.15
    twice = np.repeat(best.columns[:, :, :1], 2, axis=2)
    assert best.fit.state(twice).misfit == np.inf  # dependent columns span nothing: no error, no gain


def test_without_noise_errors_hold_what_leakage_scatters_by():
    """What leaks into one segment the next takes back: by independent segments the rms is 0.73, now 0.89."""
    bound, off = Bound(STRUCTURE, (0, 2), 1.0, 0.0), []
    for seed in range(6):
        record = modal_record(STRUCTURE, (0, 2), 300.0, 0.0, seed)
        zeros = ar.identify_antiresonances(record, excitation=[0, 2], band_hz=STRUCTURE.band_hz, check="off")

        def exact(rows):
            found = antiresonances_hz(*STILL, list(rows), [0, 2])
            return np.empty(0) if found is None else found

        off.append(verdict_of(zeros, exact, STRUCTURE.band_hz, held_of=bound.zeros).deviations)
    off = np.concatenate(off)
    assert off.size >= 60
    assert 0.78 < np.sqrt(np.mean(off**2)) < 1.3


def test_the_noise_of_a_channel_that_the_signal_holds_is_told():
    """A first guess of 40 times as much, as a second force gives, is mended."""
    rng, noise = np.random.default_rng(4), np.array([1.0, 1.5, 0.7, 1.2, 2.0, 0.9])
    signal = np.linalg.qr(rng.standard_normal((300, 6, 2)) + 1j * rng.standard_normal((300, 6, 2)))[0]
    signal[:, 0] *= 6.0
    x = 30.0 * signal @ (rng.standard_normal((300, 2, 80)) + 1j * rng.standard_normal((300, 2, 80)))
    x += np.sqrt(noise)[:, None] * (rng.standard_normal(x.shape) + 1j * rng.standard_normal(x.shape))
    found = minors.noise_beside(Segments.of(x).matrix, noise * np.array([40.0, 1, 1, 1, 1, 1]), 2)
    assert found / found.mean() == pytest.approx(noise / noise.mean(), rel=0.15)


# -- What is found


def test_two_forces_of_unknown_spectra(zeros):
    said = verdict(zeros, STIFFNESS, MASS, BAND)
    assert zeros.excitation == (0, 4)
    assert zeros.channels == tuple(range(8))
    assert zeros.sees == "transmissibility"
    assert said.there == 70
    assert said.found >= 66
    assert said.false <= 1
    assert np.median(np.abs(said.off)) < 3e-4
    assert said.held >= 0.75
    assert 0.7 < np.sqrt(np.mean(said.deviations**2)) < 1.3  # seeds 100 to 104: 0.93 to 1.15


def test_double_root_is_one_value():
    """Equal springs between the forces: 58.52 Hz twice, which one per cent of damping parts by three."""
    record = record_of(CHAIN, (2, 6), 300.0, 0.01, 11)
    zeros = quiet(record, [2, 6], dofs=[(1, 5), (2, 5)])
    for pair in zeros:
        exact = antiresonances_hz(STIFFNESS, MASS, list(pair), [2, 6])
        (double,) = exact[:-1][np.diff(exact) < 1e-3]
        (at,) = np.flatnonzero(np.abs(zeros[pair] / double - 1.0) < 0.03)
        assert zeros.tables[pair].scores["how"][at] == "double root"
        assert abs(zeros[pair][at] - double) < min(3.0 * zeros.tables[pair].std_hz[at], 0.003 * double)


def test_responses_behind_one_force_have_no_minor(zeros):
    """Beyond mass 4 both forces arrive through it, so that two responses there hold one unknown."""
    silent = {*combinations(range(4, 8), 2)}
    roots = {pair: antiresonances_hz(STIFFNESS, MASS, [*pair], [0, 4]) for pair in combinations(range(8), 2)}
    assert {pair for pair, hz in roots.items() if hz is None} == silent
    assert not silent & set(zeros)
    assert {tuple(pair) for pair in zeros.options["silent"]} == silent


def test_sets_of_responses_are_named_in_any_order(record):
    some = quiet(record, [0, 4], dofs=[(5, 1), [2, 3]])
    assert list(some) == [(1, 5), (2, 3)]
    refused("2 responses for 2 forces", quiet, record, [0, 4], dofs=[1])


def test_a_node_and_its_direction_are_not_two_forces():
    record = ar.Recording(np.random.default_rng(0).standard_normal((3, 4096)), 64.0, ["node 4 u", "4:v", "u"])
    for given in ((4, "v"), [4, "v"], (12, "+Z")):
        for call in (ar.identify_antiresonances, ar.check_data):
            with pytest.raises(ar.InvalidInputError, match=r'excitation: got \(.*two forces.*"node \d+ .*"'):
                call(record, excitation=given, band_hz=(1, 30))
    assert ar.check_data(record, excitation=(4, "u"), band_hz=(1, 30)).excitation == (4, "u")  # a channel


def test_one_place_in_a_list_is_one_force():
    record = record_of(CHAIN, (0,), 60.0, 0.01, 1)
    assert quiet(record, [0]) == quiet(record, 0)


def test_values_are_followed(record, zeros):
    again = quiet(record_of(CHAIN, (0, 4), 240.0, 0.01, 4), [0, 4], near=zeros)
    assert sum(map(len, again.values())) >= 0.9 * sum(map(len, zeros.values()))
    refused("near", quiet, record, [0, 3], near=zeros)


def frfs(place, freq_hz, kind):
    values = CHAIN.frf(list(range(8)), place, freq_hz, damping_ratio=0.01)
    std = np.broadcast_to(1e-4 * np.abs(values).mean(axis=1, keepdims=True), values.shape)
    rng = np.random.default_rng(place)
    values = values + std * (rng.standard_normal(values.shape) + 1j * rng.standard_normal(values.shape))
    if kind == "frf":
        return ar.FrequencyResponse(freq_hz, values, std=std)
    return ar.FrequencyResponse(freq_hz, values / values[2], kind="transmissibility", reference=2)


def hit(place, seed):
    """A tap, and what follows it in 20 s."""
    fs_hz, count = 400.0, 8192
    freq_hz, pulse = np.fft.rfftfreq(count, 1.0 / fs_hz), np.zeros(count)
    pulse[400:403] = 0.5, 1.0, 0.5
    values = np.zeros((8, freq_hz.size), dtype=complex)
    values[:, 1:] = CHAIN.frf(list(range(8)), place, freq_hz[1:], damping_ratio=0.01)
    x = np.fft.irfft(values * np.fft.rfft(pulse), count)
    noise = np.random.default_rng(seed).standard_normal(x.shape)
    return ar.Recording(x + 0.01 * x.std(axis=1, keepdims=True) * noise, fs_hz, force=pulse)


@pytest.mark.parametrize("kind", ["frf", "transmissibility"])
def test_curves_measured_one_force_after_the_other(kind):
    freq_hz = np.arange(1, 1200) * 0.125
    columns = [frfs(place, freq_hz, kind) for place in (0, 4)]
    found = quiet(columns, [0, 4])
    said = verdict(found, STIFFNESS, MASS, BAND)
    assert said.found >= 0.9 * said.there > 60
    assert said.false <= 2
    assert found.sees == kind
    assert found.channels == tuple(range(8))


def test_parts_of_curves_agree_with_one_fit(monkeypatch):
    columns = [frfs(place, np.arange(1, 1200) * 0.125, "frf") for place in (0, 4)]
    monkeypatch.setattr(minors, "IN_ONE_FIT", 14)
    monkeypatch.setattr(minors, "ANCHORS", 6)
    said = verdict(quiet(columns, [0, 4]), STIFFNESS, MASS, BAND)
    assert said.found >= 64
    assert said.false <= 2


@pytest.mark.parametrize(("hits", "least"), [(0, 66), (2, 25), (4, 66)])
def test_records_of_one_force_after_the_other(hits, least):
    """Pooled, their spectra have the rank of their number; two hits at each place are few."""
    one = hit if hits else (lambda place, seed: record_of(CHAIN, (place,), 120.0, 0.01, seed))
    found = quiet([one(place, seed) for seed, place in enumerate((0, 4) * max(hits, 1))], [0, 4])
    said = verdict(found, STIFFNESS, MASS, BAND)
    assert said.found >= least
    assert said.false <= 2
    assert np.median(np.abs(said.off)) < 2e-3


def test_noise_of_as_many_minors_as_channels_is_that_of_minors():
    """Of three channels and two forces both are three."""
    every = (hit(place, seed) for seed, place in enumerate((0, 4) * 4))
    hits = [ar.Recording(one.responses[[1, 3, 6]], 400.0, [1, 3, 6]) for one in every]
    averages = average(one_source(hits), BAND, Averaging().checked())
    made = minors.MinorsOfRecord(averages.rec, averages, 2)
    look = looks_of(averages, BAND, made.directions)[0]
    assert look.noise.shape[1] == 3
    np.testing.assert_allclose(look.noise, look.noise[:, :1] * np.ones(3), rtol=1e-12)


def test_what_a_window_adds_to_the_decay_joins_no_roots():
    """A quarter of a hertz apart, well known; in an exponential window both decay by 6 /s more."""

    class Known:
        def standard_deviations(self, row, s, means=None):
            return np.full(s.size, 0.002) if means is None else np.full(len(means), 1e-4)

    true = 2j * np.pi * np.array([57.9, 58.15]) - 0.4
    for added in (0.0, 6.0):
        s, *_, count = _joined(Known(), 0, true - added, np.ones(2), np.full(2, 0.002), added)
        assert count.tolist() == [1, 1]
        np.testing.assert_allclose(s, true - added)


def test_an_order_without_roots_counts_with_the_distance_looked_for():
    """A double root has no mean of two in it."""
    found = order_scatter(np.array([1j, 2j]), [np.empty(0, dtype=complex), np.array([1j])], np.array([2, 1]))
    assert np.isfinite(found).all()


# -- How many act


def test_the_number_of_forces_is_told():
    for forces, levels in (((0,), [1.0]), ((0, 4), [1.0, 0.1]), ((0, 3, 6), [1.0, 1.0, 0.1])):
        record = record_of(CHAIN, forces, 200.0, 0.02, 5, levels=levels)
        checked = ar.check_data(record, excitation=list(forces), band_hz=BAND)
        assert checked.n_forces == len(forces)
        assert checked.ok


@pytest.mark.parametrize(
    ("acting", "named", "said"),
    [((0, 4), 0, "name all: excitation=[0, 4]"), ((0, 3, 6), [0, 4], "need more than 2 forces")]
    + [((0,), [0, 4], "1 uncorrelated force is seen")],
)
def test_the_wrong_number_is_told(acting, named, said):
    record = record_of(CHAIN, acting, 120.0, 0.01, 6)
    checked = ar.check_data(record, excitation=named, band_hz=BAND)
    assert (checked.fatal, said in str(checked)) == (True, True), str(checked)


def test_the_wrong_number_gives_no_confident_answer():
    record = record_of(CHAIN, (0, 3, 6), 120.0, 0.01, 6)
    with pytest.warns(ar.AntiresWarning, match="one_force"):
        found = ar.identify_antiresonances(record, excitation=[0, 4], band_hz=BAND)
    assert {str(grade) for table in found.tables.values() for grade in table.scores["grade"]} == {"weak"}


def test_what_cannot_be_is_refused(record):
    few = ar.Recording(record.responses[:2], record.fs_hz)
    unsuitable("at least 3 channels", quiet, few, [0, 4])
    for some in ([0] * 5, [0, 1, 2, 3, 0]):  # exact copies once ended in a raw LinAlgError, or in no value
        factors = np.arange(1.0, 6.0)[:, None]
        for excitation in ([0, 4], [0, 3, 6]):
            copies = ar.Recording(factors * record.responses[some], record.fs_hz)
            unsuitable("one signal from dofs 0 and", quiet, copies, excitation)
    refused("^estimator", quiet, record, [0, 4], estimator="h1")
    refused("^route", quiet, record, [0, 4], route="frf")
    least = ar.FitOptions(min_order=1, min_rows=1)
    refused("max_order: got 2; wanted at least 3", quiet, record, [0, 4, 6], max_order=2, fit=least)
    refused("same dof twice", quiet, record, [0, 0])
    curves = [frfs(0, np.arange(1, 600) * 0.25, "frf")] * 3
    refused("3 FrequencyResponses for 2 forces", quiet, curves, [0, 4])


def test_minors_of_a_record_are_fitted_over_the_band_whatever_it_predicts(record, monkeypatch):
    """Local fits take what a strong mode leaks for zeros: 5 to 17 a record of a truss and a plate strip."""
    monkeypatch.setattr("antires_rs.identification.identify.LARGEST_AHEAD", 0.0)
    assert quiet(record, [0, 4]).options["fitted"] == "numerators"
    assert quiet(record, 0).options["fitted"] == "directions"


def test_columns_that_are_not_defined_are_told(record, monkeypatch):
    import antires_rs.identification.selection as chapter

    def singular(lines, max_order):
        raise np.linalg.LinAlgError

    monkeypatch.setattr(chapter, "likeliest_columns", singular)
    with pytest.raises(ar.NumericalError, match="columns of several forces"):
        quiet(record, [0, 4], fit=ar.FitOptions(formulation="numerators"))
    assert quiet(record, [0, 4]).options["fitted"] == "directions"

"""The prepared answer is that of the full run, or says that it may not be."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import antires_rs as ar
from tests.support.wrong_chains import NOMINAL, N, chain, measured, truth


def states(seed, losses):
    """Intact state and a test of a chain with errors of its own."""
    rng, factors = truth(seed)
    return measured(chain(factors), rng), measured(chain(factors, losses), rng)


@pytest.fixture(scope="module")
def prepared():
    """An assessor, its baseline, and the test of a damage of 30 %."""
    before, now = states(301, (0, 0, 0.3, 0, 0))
    return ar.Assessor(NOMINAL, baseline=before, workers=1), before, now


def same_answer(quick, full):
    best = full.hypotheses[0]
    assert quick.hypotheses[0].elements == best.elements
    assert quick.assessment.declared == full.assessment.declared
    for e in full.assessment.declared:
        low, high = full.interval[e]
        # Within a tenth of the interval's width; the full run stops its search within a few of these too.
        assert abs(quick.severity[e] - full.severity[e]) <= 0.1 * (high - low) + 1e-3
        assert quick.interval[e] == pytest.approx((low, high), abs=0.15 * (high - low) + 1e-3)


@pytest.mark.parametrize("seed", range(310, 322))
@pytest.mark.parametrize("n_damaged", [0, 1, 2])
def test_the_same_answer_as_the_full_run(seed, n_damaged):
    """Severities from the smallest that are seen to most of the element; seeds that nothing was set on."""
    rng = np.random.default_rng([seed, n_damaged])
    losses = np.zeros(N - 1)
    losses[rng.choice(N - 1, n_damaged, replace=False)] = np.exp(
        rng.uniform(np.log(0.01), np.log(0.8), n_damaged)
    )
    before, now = states(seed, losses)
    quick = ar.Assessor(NOMINAL, baseline=before, workers=1).assess(now)
    full = ar.assess_damage(NOMINAL, now, baseline=before, workers=1)
    if quick.full_run_wanted:
        assert quick.reasons
        return
    same_answer(quick, full)
    for e, p in full.probability.items():
        assert quick.probability[e] == pytest.approx(p, abs=0.05)


def test_most_answers_need_no_full_run():
    """Otherwise the flag would make every test above pass."""
    wanted = 0
    for seed in range(330, 350):
        losses = np.zeros(N - 1)
        losses[seed % (N - 1)] = 0.02 * (1 + seed % 9)
        before, now = states(seed, losses)
        wanted += ar.Assessor(NOMINAL, baseline=before, workers=1).assess(now).full_run_wanted
    assert wanted <= 2


def test_a_rate_of_false_alarms_is_kept():
    before, now = states(302, (0, 0, 0, 0, 0))
    assessor = ar.Assessor(
        NOMINAL, baseline=before, search=ar.SearchOptions(false_alarm_rate=0.05), rng=1, workers=1
    )
    full = ar.assess_damage(
        NOMINAL, now, baseline=before, search=ar.SearchOptions(false_alarm_rate=0.05), rng=1, workers=1
    )
    quick = assessor.assess(now)
    assert quick.assessment.threshold == pytest.approx(full.assessment.threshold, abs=0.02)
    assert quick.assessment.declared == full.assessment.declared


def test_what_detects_is_known_before_the_test(prepared):
    assessor, before, now = prepared
    full = ar.assess_damage(NOMINAL, now, baseline=before)
    for e, beta in full.detectable.items():
        assert assessor.detectable[e] == pytest.approx(beta, rel=0.02)


def test_saved_and_loaded_it_gives_the_same_bits(prepared, tmp_path):
    assessor, _, now = prepared
    loaded = ar.Assessor.load(assessor.save(tmp_path / "plan.npz"))
    one, other = assessor.assess(now), loaded.assess(now)
    assert one.assessment == other.assessment
    assert (one.severity, one.interval, one.probability) == (
        other.severity,
        other.interval,
        other.probability,
    )
    assert repr(loaded) == repr(assessor)


def test_pickled_and_in_threads_it_gives_the_same_bits(prepared):
    assessor, before, now = prepared
    copied = pickle.loads(pickle.dumps(assessor))
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(copied.assess, [now, before] * 4))
    for k, test in enumerate([now, before] * 4):
        assert found[k].assessment == assessor.assess(test).assessment


def test_the_number_of_threads_changes_no_bit(prepared):
    assessor, before, now = prepared
    again = ar.Assessor(NOMINAL, baseline=before, workers=2)
    assert again.assess(now).assessment == assessor.assess(now).assessment


def test_a_damaged_file_is_refused(prepared, tmp_path):
    path = prepared[0].save(tmp_path / "plan.npz")
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0xFF
    path.write_bytes(bytes(data))
    with pytest.raises(ar.exceptions.AntiresError):
        ar.Assessor.load(path)
    with pytest.raises(ar.InvalidInputError, match=r"\.npz"):
        prepared[0].save(tmp_path / "plan.dat")
    with pytest.raises(ar.InvalidInputError, match="path: got 5"):
        prepared[0].save(5)
    with pytest.raises(FileNotFoundError):
        ar.Assessor.load(tmp_path / "none.npz")


def test_another_kind_of_file_is_refused(prepared, tmp_path):
    _, before, now = prepared
    path = tmp_path / "result.npz"
    ar.assess_damage(NOMINAL, now, baseline=before).save(path)
    with pytest.raises(ar.exceptions.AntiresError, match="antires_rs.result"):
        ar.Assessor.load(path)


def test_a_response_that_the_plan_does_not_have_wants_a_full_run(prepared):
    before = [
        ar.AntiresonanceSet(
            s.excitation, {d: s[d] for d in range(4)}, std_hz={d: s.std_hz[d] for d in range(4)}
        )
        for s in prepared[1]
    ]
    found = ar.Assessor(NOMINAL, baseline=before, workers=1).assess(prepared[2])
    assert found.full_run_wanted
    assert any("does not have dof 4" in reason for reason in found.reasons)
    assert "A full run is wanted" in found.headline


def test_what_no_element_explains_wants_a_full_run(prepared):
    assessor, before, _ = prepared
    rng = np.random.default_rng(5)
    now = [
        ar.AntiresonanceSet(
            s.excitation, {d: f * (1 + 0.02 * rng.standard_normal(f.size)) for d, f in s.items()}
        )
        for s in before
    ]
    assert assessor.assess(now).full_run_wanted


def test_nearly_nothing_left_of_a_spring_wants_a_full_run():
    before, now = states(303, (0, 0, 0.985, 0, 0))
    found = ar.Assessor(NOMINAL, baseline=before, workers=1).assess(now)
    assert found.full_run_wanted


def test_all_values_moved_alike_is_no_damage(prepared):
    assessor, before, _ = prepared
    warm = [
        ar.AntiresonanceSet(
            s.excitation, {d: 0.99 * f for d, f in s.items()}, std_hz={d: s.std_hz[d] for d in s}
        )
        for s in before
    ]
    found = assessor.assess(warm)
    full = ar.assess_damage(NOMINAL, warm, baseline=before)
    assert found.hypotheses[0].unknown
    assert full.hypotheses[0].unknown
    assert found.assessment.moved_alike == pytest.approx(-0.01, abs=1e-3)


@pytest.mark.parametrize(
    ("options", "argument"),
    [
        ({"baseline": []}, "baseline"),
        ({"baseline": "intact"}, "baseline"),
        ({"baseline": [ar.AntiresonanceSet(0, {1: []})]}, "baseline"),
        ({"elements": []}, "elements"),
        ({"elements": [99]}, r"elements\[0\]: got 99"),
        ({"prior": 0.5}, "prior"),
        ({"search": ar.SearchOptions(false_alarm_rate=0.9)}, "false_alarm_rate"),
        ({"search": ar.SearchOptions(std_common=-1.0)}, "std_common"),
    ],
)
def test_wrong_arguments_are_refused(prepared, options, argument):
    given = {"baseline": prepared[1], **options}
    with pytest.raises(ar.InvalidInputError, match=argument):
        ar.Assessor(NOMINAL, **given)


def test_a_model_without_terms_is_told_what_it_lacks(prepared):
    bare = ar.MatrixModel(np.diag([2e4, 1e4, 1e4, 1e4, 1e4, 1e4]), np.eye(6))
    with pytest.raises(ar.InvalidInputError, match="stiffness_terms"):
        ar.Assessor(bare, baseline=prepared[1])


def test_wrong_models_and_tests_are_refused(prepared):
    with pytest.raises(ar.InvalidInputError, match="model"):
        ar.Assessor("chain", baseline=prepared[1])
    for wrong in ("zeros", [], 3.0, [3.0]):
        with pytest.raises(ar.InvalidInputError, match="zeros"):
            prepared[0].assess(wrong)
    with pytest.raises(ar.InvalidInputError, match="force at 5"):
        prepared[0].assess(ar.AntiresonanceSet(5, {1: [20.0]}))
    with pytest.raises(ar.InvalidInputError, match="no antiresonance"):
        prepared[0].assess(ar.AntiresonanceSet(0, {1: []}))


def test_the_answer_reads_as_that_of_the_full_run(prepared):
    assessor, before, now = prepared
    quick, full = assessor.assess(now), ar.assess_damage(NOMINAL, now, baseline=before)
    assert not quick.full_run_wanted, quick.reasons
    assert quick.headline.split(" of its stiffness")[0].rsplit(" ", 2)[0] in full.headline
    assert quick.damaged == full.damaged == [2]
    assert quick.probability_of_damage == pytest.approx(full.probability_of_damage, abs=0.01)
    assert quick.probability_elsewhere == pytest.approx(full.probability_elsewhere, abs=0.02)
    assert quick.chi_square == pytest.approx(full.chi_square, rel=0.05)
    assert "spring 2" in str(quick)


ALWAYS = ar.DamagePrior(nothing=0.0, one=0.86)
THREE = ar.DamagePrior(nothing=0.0, one=0.0, two=0.0, three=0.98, elsewhere=0.01, unknown=0.01)
ONLY_THREE = ar.DamagePrior(nothing=0.0, one=0.0, two=0.0, three=1.0, elsewhere=0.0, unknown=0.0)


@pytest.mark.parametrize("prior", [ALWAYS, THREE], ids=["always damage", "three or none of ours"])
def test_priors_that_exclude_the_usual(prepared, prior):
    _, before, now = prepared
    quick = ar.Assessor(NOMINAL, baseline=before, prior=prior, workers=1).assess(before)
    rows = [one.elements for one in quick.hypotheses]
    assert len(rows) == len(set(rows))
    assert quick.assessment.probability_of_nothing == 0.0
    full = ar.assess_damage(NOMINAL, before, baseline=before, prior=prior, workers=1)
    assert rows[0] == full.hypotheses[0].elements


def test_priors_that_allow_nothing_are_refused_as_by_a_full_run(prepared):
    _, before, now = prepared
    with pytest.raises(ar.exceptions.InvalidInputError, match="always damage"):
        ar.Assessor(
            NOMINAL, baseline=before, prior=ALWAYS, search=ar.SearchOptions(false_alarm_rate=0.05), workers=1
        )
    assessor = ar.Assessor(NOMINAL, baseline=before, prior=ONLY_THREE, workers=1)
    with pytest.raises(ar.exceptions.InvalidInputError, match="allows none of the hypotheses"):
        assessor.assess(before)

"""The prepared answer is that of the full run, or says that it may not be."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import antires_rs as ar
from reference.wrong_chains import NOMINAL, N, changed, states
from tests.support.campaign import some_of
from tests.support.refusals import refused
from tests.support.snapshots import refusals


@pytest.fixture(scope="module")
def prepared():
    """An assessor, its baseline, and the test of a damage of 30 %."""
    before, now = states(301)
    return assessor(before), before, now


def assessor(before, model=NOMINAL, **options):
    return ar.Assessor(model, baseline=before, workers=1, **options)


def full_run(before, now, model=NOMINAL, **options):
    return ar.assess_damage(model, now, baseline=before, workers=1, **options)


@pytest.mark.parametrize("seed", some_of(range(310, 322), 3))
@pytest.mark.parametrize("n_damaged", [0, 1, 2])
def test_the_same_answer_as_the_full_run(seed, n_damaged):
    """Severities from the smallest that are seen to most of the element; seeds that nothing was set on."""
    rng = np.random.default_rng([seed, n_damaged])
    losses = np.zeros(N - 1)
    places = rng.choice(N - 1, n_damaged, replace=False)
    losses[places] = np.exp(rng.uniform(np.log(0.01), np.log(0.8), n_damaged))
    before, now = states(seed, losses)
    quick, full = assessor(before).assess(now), full_run(before, now)
    if quick.full_run_wanted:
        assert quick.reasons
        return
    assert quick.hypotheses[0].elements == full.hypotheses[0].elements
    assert quick.assessment.declared == full.assessment.declared
    for e in full.assessment.declared:
        low, high = full.interval[e]
        # Within a tenth of the interval's width; the full run stops its search within a few of these too.
        assert abs(quick.severity[e] - full.severity[e]) <= 0.1 * (high - low) + 1e-3
        assert quick.interval[e] == pytest.approx((low, high), abs=0.15 * (high - low) + 1e-3)
    for e, p in full.probability.items():
        assert quick.probability[e] == pytest.approx(p, abs=0.05)


@pytest.mark.parametrize("tests", some_of([10, 20]))
def test_most_answers_need_no_full_run(tests):
    """Otherwise the flag would make every test above pass."""
    wanted = 0
    for seed in range(330, 330 + tests):
        before, now = states(seed, 0.02 * (1 + seed % 9) * np.eye(N - 1)[seed % (N - 1)])
        wanted += assessor(before).assess(now).full_run_wanted
    assert wanted <= tests // 10


MASSES = [1.0] * 6
SPRINGS = 100.0 * np.array([510.0, 495.0, 500.0, 520.0, 480.0])


def of_chain(springs, dofs, seed):
    model, rng = ar.MassSpringChain(MASSES[: len(springs) + 1], springs), np.random.default_rng(seed)
    exact = dict(zip(dofs, model.antiresonances(dofs, 0), strict=True))
    std = {dof: 1e-3 * f for dof, f in exact.items()}
    noisy = {dof: np.sort(f + std[dof] * rng.standard_normal(f.size)) for dof, f in exact.items()}
    return ar.AntiresonanceSet(0, noisy, std_hz=std)


@pytest.mark.parametrize("left", [480.0, 400.0, 200.0])
def test_one_value_that_no_undamaged_root_is_near(left):
    """The element is judged at no damage first, where nothing belongs to the value and no slope leads on."""
    before, now = of_chain([520.0], [0, 1], 1), of_chain([left], [0, 1], 2)
    model = ar.MassSpringChain([1.0, 1.0], [500.0])
    quick, full = assessor(before, model).assess(now), full_run(before, now, model).hypotheses[0]
    assert quick.hypotheses[0].elements == full.elements == (0,)
    assert quick.hypotheses[0].probability == pytest.approx(full.probability, abs=0.05)
    assert quick.severity[0] == pytest.approx(1.0 - left / 520.0, abs=0.01)


@pytest.mark.parametrize("seed", some_of([31, 61, 90]))
def test_a_small_damage_that_errors_of_three_times_their_size_explain_too(seed):
    """No damage is most probable with such errors, and seen with these no element is worth a look."""
    dofs, model = [0, 1, 3, 4, 5], ar.MassSpringChain(MASSES, [5e4] * 5)
    before, now = of_chain(SPRINGS, dofs, 1), of_chain(SPRINGS * [1, 1, 1, 0.98, 1], dofs, seed)
    found = assessor(before, model).assess(now), full_run(before, now, model)
    quick, full = (each.hypotheses[0] for each in found)
    assert quick.elements == full.elements == (3,)
    assert quick.probability == pytest.approx(full.probability, abs=0.03)


def test_a_rate_of_false_alarms_is_kept():
    before, now = states(302, (0, 0, 0, 0, 0))
    options = {"search": ar.SearchOptions(false_alarm_rate=0.05), "rng": 1}
    quick = assessor(before, **options).assess(now).assessment
    full = full_run(before, now, **options).assessment
    assert quick.threshold == pytest.approx(full.threshold, abs=0.02)
    assert quick.declared == full.declared


def test_the_answer_reads_as_that_of_the_full_run(prepared):
    made, before, now = prepared
    quick, full = made.assess(now), full_run(before, now)
    assert not quick.full_run_wanted, quick.reasons
    assert quick.headline.split(" of its stiffness")[0].rsplit(" ", 2)[0] in full.headline
    assert quick.damaged == full.damaged == [2]
    assert quick.probability_of_damage == pytest.approx(full.probability_of_damage, abs=0.01)
    assert quick.probability_elsewhere == pytest.approx(full.probability_elsewhere, abs=0.02)
    assert quick.chi_square == pytest.approx(full.chi_square, rel=0.05)
    assert "spring 2" in str(quick)
    assert "spring 2" in repr(quick)
    for known in (made.detectable, quick.detectable):
        assert known == pytest.approx(full.detectable, rel=0.02)


def test_kept_copied_and_in_threads_it_gives_the_same_bits(prepared, tmp_path):
    made, before, now = prepared
    loaded, copied = ar.Assessor.load(made.save(tmp_path / "plan.npz")), pickle.loads(pickle.dumps(made))
    again = ar.Assessor(NOMINAL, baseline=before, workers=2)
    one = made.assess(now)
    for each in (loaded, again):
        other = each.assess(now)
        assert one.assessment == other.assessment
        for name in ("severity", "interval", "probability"):
            assert getattr(one, name) == getattr(other, name)
    assert repr(loaded) == repr(made)
    with ThreadPoolExecutor(4) as pool:
        for test, found in zip([now, before] * 4, pool.map(copied.assess, [now, before] * 4), strict=True):
            assert found.assessment == made.assess(test).assessment


def test_files_that_do_not_fit_are_refused(prepared, tmp_path):
    made, before, now = prepared
    path = made.save(tmp_path / "plan.npz")
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0xFF
    path.write_bytes(bytes(data))
    with pytest.raises(ar.exceptions.AntiresError):
        ar.Assessor.load(path)
    refused(r"\.npz", made.save, tmp_path / "plan.dat")
    refused("path: got 5", made.save, 5)
    with pytest.raises(FileNotFoundError):
        ar.Assessor.load(tmp_path / "none.npz")
    full_run(before, now).save(tmp_path / "result.npz")
    with pytest.raises(ar.exceptions.AntiresError, match=r"antires_rs.result"):
        ar.Assessor.load(tmp_path / "result.npz")


def test_what_wants_a_full_run(prepared):
    made, before, now = prepared
    lacking = assessor(changed(before, dofs=range(4))).assess(now)
    assert any("does not have dof 4" in reason for reason in lacking.reasons)
    assert "A full run is wanted" in lacking.headline
    rng = np.random.default_rng(5)
    moved = [{d: f * (1 + 0.02 * rng.standard_normal(f.size)) for d, f in s.items()} for s in before]
    strange = [ar.AntiresonanceSet(s.excitation, hz) for s, hz in zip(before, moved, strict=True)]
    assert made.assess(strange).full_run_wanted  # what no element explains
    before, now = states(303, (0, 0, 0.985, 0, 0))
    assert assessor(before).assess(now).full_run_wanted  # nearly nothing is left of a spring


def test_all_values_moved_alike_is_no_damage(prepared):
    made, before, _ = prepared
    warm = changed(before, 0.99)
    found, full = made.assess(warm), full_run(before, warm)
    for each in (found, full):  # such a change may come with any hypothesis
        assert each.hypotheses[0].elements == ()
        assert not each.damaged
        assert each.assessment.moved_alike == pytest.approx(-0.01, abs=1e-3)
        assert each.headline.startswith("No damage found: all values are 1")


def test_responses_that_were_not_measured_are_priced_as_by_a_full_run():
    before, now = states(621, (0, 0, 0.85, 0, 0))
    few = changed(now, dofs=(0, 5))
    with pytest.warns(ar.exceptions.AntiresWarning, match="12 of the intact structure, .*4 of now, .*Only 4"):
        quick, full = assessor(before).assess(few), full_run(before, few)
    assert quick.hypotheses[0].elements == full.hypotheses[0].elements
    assert quick.probability[2] == pytest.approx(full.probability[2], abs=0.02)


ALWAYS = ar.DamagePrior(nothing=0.0, one=0.86)
THREE = ar.DamagePrior(nothing=0.0, one=0.0, two=0.0, three=0.98, elsewhere=0.01, unknown=0.01)
ONLY_THREE = ar.DamagePrior(nothing=0.0, one=0.0, two=0.0, three=1.0, elsewhere=0.0, unknown=0.0)


def test_wrong_arguments_and_tests_are_refused(prepared):
    made, before, _ = prepared
    refusals(__file__, "wrong_assessors.txt", globals() | {"made": made, "before": before})


@pytest.mark.parametrize("prior", [ALWAYS, THREE], ids=["always damage", "three or none of ours"])
def test_priors_that_exclude_the_usual(prepared, prior):
    _, before, _ = prepared
    quick = assessor(before, prior=prior).assess(before)
    rows = [one.elements for one in quick.hypotheses]
    assert len(rows) == len(set(rows))
    assert quick.assessment.probability_of_nothing == 0.0
    assert rows[0] == full_run(before, before, prior=prior).hypotheses[0].elements

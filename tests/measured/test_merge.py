"""Setups with other places of sensors or hammer joined to one set."""

import numpy as np
import pytest

import antires_rs as ar
from tests.support.refusals import unsuitable
from tests.support.snapshots import refusals

MODEL = ar.MassSpringChain([0.5593] + 7 * [0.4194], np.full(7, 56.7e3))
STD = 3e-4


def setup(excitation, dofs, rng, shift=0.0):
    exact = dict(zip(dofs, MODEL.antiresonances(list(dofs), excitation), strict=True))
    found = {d: f * (1.0 + shift + STD * rng.standard_normal(f.size)) for d, f in exact.items()}
    return ar.AntiresonanceSet(excitation, found, std_hz={d: STD * f for d, f in exact.items()})


def test_roving_sensors_around_a_reference():
    rng = np.random.default_rng(0)
    setups = [setup(0, dofs, rng) for dofs in ((0, 1, 2), (0, 3, 4), (0, 5, 6, 7))]
    merged = ar.merge_setups(setups)
    assert list(merged) == [0, 1, 2, 3, 4, 5, 6, 7]
    for dof, exact in enumerate(MODEL.antiresonances(range(8), 0)):
        assert merged[dof].size == exact.size
        assert np.allclose(merged[dof], exact, rtol=5 * STD)
    assert merged[3].tolist() == setups[1][3].tolist()
    assert np.median(merged.std_hz[0] / setups[0].std_hz[0]) < 0.9
    assert np.std(merged[0] / MODEL.antiresonances(0, 0)) < STD


def test_a_roving_hammer_by_reciprocity():
    rng = np.random.default_rng(1)
    setups = [setup(k, (0, 4), rng) for k in range(8)]
    merged = ar.merge_setups(setups, excitation=0, check="off")
    assert merged.excitation == 0
    for dof, exact in enumerate(MODEL.antiresonances(range(8), 0)):
        assert np.allclose(merged[dof], exact, rtol=5 * STD)
    # H_40 was measured twice: as response 4 under force 0, and as response 0 under force 4.
    assert np.median(merged.std_hz[4] / setups[4].std_hz[0]) < 0.9 or merged[4].size < 3
    other = ar.merge_setups(setups, excitation=4)
    assert {dof: f.size for dof, f in other.items()}[0] == merged[4].size


def test_setups_that_agree_are_merged_in_silence_and_others_not():
    # Set on seeds 0 and 1, looked at on these: no alarm, warnings being errors here.
    for seed in range(10, 30):
        rng = np.random.default_rng(seed)
        ar.merge_setups([setup(0, dofs, rng) for dofs in ((0, 1), (0, 2), (0, 3), (0, 4))], alpha=1e-3)
    setups = [setup(0, dofs, np.random.default_rng(3)) for dofs in ((1, 2), (3, 4))]
    with pytest.warns(ar.AntiresWarning, match="2 setups have no response in common"):
        ar.merge_setups(setups)
    sets = [ar.AntiresonanceSet(0, {0: f}) for f in ([8.7, 23.9], [8.7, 23.8], [8.8, 15.0, 23.9])]
    merged = ar.merge_setups(sets)
    assert merged[0].round(2).tolist() == [8.73, 23.87]
    assert merged.std_hz[0][0] == pytest.approx(0.1 / 3)


def test_the_setup_that_disagrees_is_named():
    rng = np.random.default_rng(2)
    setups = [setup(0, (0, d), rng, shift=0.005 if d == 3 else 0.0) for d in (1, 2, 3, 4)]
    said = r"Setup 2 disagrees .*at dof 0, \+0\..* % from the others"
    with pytest.warns(ar.AntiresWarning, match=said) as seen:
        merged = ar.merge_setups(setups)
    assert "Setup 0" not in str(seen[0].message)
    assert np.all(np.abs(merged[0] / MODEL.antiresonances(0, 0) - 1.0) < 3 * merged.std_hz[0] / merged[0])
    unsuitable("^sets: got setups that disagree: Setup 2", ar.merge_setups, setups, check="raise")
    ar.merge_setups(setups, std_between=0.005)
    with pytest.warns(ar.AntiresWarning, match="Setups 0 and 1 disagree"):
        ar.merge_setups(setups[1:3])


ONE, OTHER = (setup(k, (0, 1), np.random.default_rng(0)) for k in (0, 1))
TEN, ELSEWHERE, ANOTHER = (ar.AntiresonanceSet(k, {dof: [10.0]}) for k, dof in ((0, 0), (1, 0), (0, 1)))


def test_bad_arguments_are_named():
    refusals(__file__, "wrong_tests.txt", globals())


def test_the_same_set_twice_counts_once():
    rng = np.random.default_rng(5)
    one, other = setup(0, (0, 1, 2), rng), setup(0, (0, 3), rng)
    with pytest.warns(ar.AntiresWarning, match=r"setups 0 and 1 have \d+ values in common to the last bit"):
        merged = ar.merge_setups([one, one])
    for dof in one:
        assert merged[dof].tolist() == one[dof].tolist()
        assert merged.std_hz[dof].tolist() == one.std_hz[dof].tolist()
    with pytest.warns(ar.AntiresWarning, match="setups 0 and 2 have"):
        merged = ar.merge_setups([one, other, one])
    plain = ar.merge_setups([one, other])
    for dof in plain:
        assert merged[dof].tolist() == plain[dof].tolist()
        assert merged.std_hz[dof].tolist() == plain.std_hz[dof].tolist()
    unsuitable(r"setups 0 and 1 .* Give each setup once", ar.merge_setups, [one, one], check="raise")
    assert ar.merge_setups([one, one], check="off") == ar.AntiresonanceSet.from_tables(0, one.tables)
    a, b = (ar.AntiresonanceSet(0, {0: [f], 1: []}, std_hz={0: [0.02]}) for f in (8.7, 8.71))
    assert ar.merge_setups([a, b])[1].size == 0


# ---- Antiresonances followed over many tests
def sets_of(*tests):
    return [ar.AntiresonanceSet(0, {0: values}) for values in tests]


def kinds(followed):
    return [(event.kind, event.test, round(event.freq_hz, 2)) for event in followed.events]


def test_values_move_through_many_tests():
    # Spring 4 softens by 60 % in steps of 2 %: some values move by a tenth, none is taken for another.
    tests, exact = [], []
    for loss in np.arange(0.0, 0.6, 0.02):
        springs = np.full(7, 56.7e3)
        springs[4] *= 1.0 - loss
        values = ar.MassSpringChain([0.5593] + 7 * [0.4194], springs).antiresonances(range(8), 0)
        exact.append(np.concatenate(values))
        tests.append(ar.AntiresonanceSet(0, dict(enumerate(values))))
    followed = ar.track(tests, conditions=100 * np.arange(0.0, 0.6, 0.02), max_shift=0.02)
    assert followed.events == ()
    assert np.array_equal(followed.freq_hz, np.array(exact))
    assert followed.change_percent.min() < -8.0
    assert followed.of(3).tolist() == [18, 19, 20, 21]


def test_new_lost_merged_and_back_are_told():
    followed = ar.track(sets_of([10.0, 20.0, 20.3], [10.0, 20.1], [20.1, 40.0], [10.1, 20.1, 40.0]))
    assert kinds(followed) == [("merged", 1, 20.3), ("lost", 2, 10.0), ("new", 2, 40.0), ("back", 3, 10.1)]
    assert followed.freq_hz.shape == (4, 4)
    assert np.isnan(followed.freq_hz[2, 0])
    assert "lost at 2, back at 3" in str(followed)
    empty = ar.track(sets_of([], []))
    assert len(empty) == 0
    assert np.isnan(empty.std_between)


def test_the_scatter_between_repeats_is_estimated():
    rng = np.random.default_rng(5)
    exact = np.concatenate(ar.cases.chain8().model.antiresonances(range(8), 0))
    # Errors of 0.02 % that are stated, and 0.1 % from test to test that are not.
    errors = [2e-4 * rng.standard_normal(7) + 1e-3 * rng.standard_normal(7) for _ in range(20)]
    std = {0: 2e-4 * exact[:7]}
    tests = [ar.AntiresonanceSet(0, {0: exact[:7] * (1.0 + error)}, std_hz=std) for error in errors]
    between = ar.track(tests).std_between
    assert 7e-4 < between < 1.4e-3
    pairs = list(zip(tests[::2], tests[1::2], strict=True))
    assert sum(ar.compare(a, b).different for a, b in pairs) >= 8
    assert sum(ar.compare(a, b, std_between=between).different for a, b in pairs) <= 1
    assert ar.track([ar.AntiresonanceSet(0, {0: exact[:7]}, std_hz=std)] * 3).std_between == 0.0


def test_what_moves_all_values_alike_is_told_from_what_moves_each():
    rng = np.random.default_rng(6)
    exact = np.linspace(10.0, 120.0, 28)
    std = np.geomspace(1e-5, 5e-4, 28)

    def test_at(warmth):
        values = exact * (1.0 + warmth + std * rng.standard_normal(28))
        return ar.AntiresonanceSet(0, {0: values}, std_hz={0: std * exact})

    # Temperature: 0.1 % up and down, far beyond the errors of the well-known values.
    tests = [test_at(1e-3 * rng.standard_normal()) for _ in range(40)]
    followed = ar.track(tests[:20])
    assert 6e-4 < followed.std_common < 1.5e-3
    assert followed.std_between < 1e-5
    pairs = list(zip(tests[20::2], tests[21::2], strict=True))
    known = {"std_between": followed.std_between, "std_common": followed.std_common}
    assert sum(ar.compare(a, b).different for a, b in pairs) == 10
    assert sum(ar.compare(a, b, **known).different for a, b in pairs) <= 1
    a, b = pairs[0]
    moved = {0: b[0] * np.where(np.arange(28) == np.argmin(b.std_hz[0] / b[0]), 1.001, 1.0)}
    assert ar.compare(a, ar.AntiresonanceSet(0, moved, std_hz=b.std_hz), **known).different


def test_tables_of_tracks():
    pytest.importorskip("pandas")
    followed = ar.track(sets_of([10.0, 20.0], [10.1]), conditions=["20 C", "30 C"])
    frame = followed.to_dataframe()
    assert frame["event"].tolist() == ["", "", "", "lost"]
    assert frame["condition"].tolist() == ["20 C", "20 C", "30 C", "30 C"]
    pytest.importorskip("xarray")
    data = followed.to_xarray()
    assert dict(data.sizes) == {"test": 2, "track": 2}
    assert data["change_percent"].values[1, 0] == pytest.approx(1.0)

"""Setups with other places of sensors or hammer joined to one set."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.exceptions import AntiresWarning, InvalidInputError, UnsuitableDataError

MODEL = ar.MassSpringChain([0.5593] + 7 * [0.4194], np.full(7, 56.7e3))
STD = 3e-4


def setup(excitation, dofs, rng, shift=0.0):
    """A set as one setup would give it."""
    exact = MODEL.antiresonances(list(dofs), excitation)
    return ar.AntiresonanceSet(
        excitation,
        {d: f * (1.0 + shift + STD * rng.standard_normal(f.size)) for d, f in zip(dofs, exact, strict=True)},
        std_hz={d: STD * f for d, f in zip(dofs, exact, strict=True)},
    )


def test_roving_sensors_around_a_reference():
    rng = np.random.default_rng(0)
    setups = [setup(0, dofs, rng) for dofs in ((0, 1, 2), (0, 3, 4), (0, 5, 6, 7))]
    merged = ar.merge_setups(setups)
    assert list(merged) == [0, 1, 2, 3, 4, 5, 6, 7]
    for dof, exact in enumerate(MODEL.antiresonances(range(8), 0)):
        assert merged[dof].size == exact.size
        assert np.allclose(merged[dof], exact, rtol=5 * STD)
    assert merged[3].tolist() == setups[1][3].tolist()
    # Three looks at the reference: more than any of them knows.
    assert np.median(merged.std_hz[0] / setups[0].std_hz[0]) < 0.9
    assert np.std(merged[0] / MODEL.antiresonances(0, 0)) < STD


def test_a_roving_hammer_by_reciprocity():
    rng = np.random.default_rng(1)
    # Two sensors stay, at 0 and 4; the hammer goes everywhere.
    setups = [setup(k, (0, 4), rng) for k in range(8)]
    merged = ar.merge_setups(setups, excitation=0, check="off")
    assert merged.excitation == 0
    for dof, exact in enumerate(MODEL.antiresonances(range(8), 0)):
        assert np.allclose(merged[dof], exact, rtol=5 * STD)
    # H_40 was measured twice: as response 4 under force 0, and as response 0 under force 4.
    assert np.median(merged.std_hz[4] / setups[4].std_hz[0]) < 0.9 or merged[4].size < 3
    other = ar.merge_setups(setups, excitation=4)
    assert {dof: f.size for dof, f in other.items()}[0] == merged[4].size


def test_setups_that_agree_are_merged_in_silence():
    # Set on seeds 0 and 1, looked at on these: no alarm, warnings being errors here.
    for seed in range(10, 30):
        rng = np.random.default_rng(seed)
        ar.merge_setups([setup(0, dofs, rng) for dofs in ((0, 1), (0, 2), (0, 3), (0, 4))], alpha=1e-3)


def test_the_setup_that_disagrees_is_named():
    rng = np.random.default_rng(2)
    setups = [setup(0, (0, d), rng, shift=0.005 if d == 3 else 0.0) for d in (1, 2, 3, 4)]
    with pytest.warns(
        AntiresWarning, match=r"Setup 2 disagrees .*at dof 0, \+0\..* % from the others"
    ) as seen:
        merged = ar.merge_setups(setups)
    assert "Setup 0" not in str(seen[0].message)
    # The errors hold what is left of it in the mean.
    assert np.all(np.abs(merged[0] / MODEL.antiresonances(0, 0) - 1.0) < 3 * merged.std_hz[0] / merged[0])
    with pytest.raises(UnsuitableDataError, match="^sets: got setups that disagree: Setup 2"):
        ar.merge_setups(setups, check="raise")
    ar.merge_setups(setups, std_between=0.005)
    with pytest.warns(AntiresWarning, match="Setups 0 and 1 disagree"):
        ar.merge_setups(setups[1:3])


def test_setups_with_nothing_in_common_are_said_to_be_untested():
    setups = [setup(0, dofs, np.random.default_rng(3)) for dofs in ((1, 2), (3, 4))]
    with pytest.warns(AntiresWarning, match="2 setups have no response in common"):
        ar.merge_setups(setups)


def test_a_value_that_one_of_three_shows_is_left_out():
    sets = [ar.AntiresonanceSet(0, {0: f}) for f in ([8.7, 23.9], [8.7, 23.8], [8.8, 15.0, 23.9])]
    merged = ar.merge_setups(sets)
    assert merged[0].round(2).tolist() == [8.73, 23.87]
    # Without stated deviations the scatter of the three is all there is.
    assert merged.std_hz[0][0] == pytest.approx(0.1 / 3)


ONE, OTHER = (setup(k, (0, 1), np.random.default_rng(0)) for k in (0, 1))


@pytest.mark.parametrize(
    ("sets", "options", "said"),
    [
        ([ONE], {}, "^sets: got .*list of 2"),
        ([ONE, OTHER], {}, r"^sets\[1\]: got .*excitation=DOF"),
        ([ONE, OTHER], {"excitation": 5}, r"^sets\[0\]: got .*Name a place"),
        ([ONE, ONE], {"check": "maybe"}, "^check: got .*one of"),
    ],
)
def test_bad_arguments_of_merge_are_named(sets, options, said):
    with pytest.raises(InvalidInputError, match=said):
        ar.merge_setups(sets, **options)


def test_identified_setups_keep_their_scores():
    rec = MODEL.simulate(excitation=0, fs_hz=512.0, duration_s=64.0, damping_ratio=0.01, noise=0.01, rng=0)
    sets = [
        ar.identify_antiresonances(
            ar.Recording(rec.responses[list(rows)], 512.0, dofs=rows), excitation=0, band_hz=(3, 130)
        )
        for rows in ((0, 1, 2, 3), (0, 4, 5, 6))
    ]
    merged = ar.merge_setups(sets, check="off")
    assert list(merged) == [0, 1, 2, 3, 4, 5, 6]
    assert set(merged.scores[0]) == set(sets[0].scores[0])
    assert (merged.sees, merged.channels) == ("transmissibility", (0, 1, 2, 3, 4, 5, 6))


def test_the_same_set_twice_counts_once():
    rng = np.random.default_rng(5)
    one, other = setup(0, (0, 1, 2), rng), setup(0, (0, 3), rng)
    with pytest.warns(AntiresWarning, match=r"setups 0 and 1 have \d+ values in common to the last bit"):
        merged = ar.merge_setups([one, one])
    for dof in one:
        assert merged[dof].tolist() == one[dof].tolist()
        assert merged.std_hz[dof].tolist() == one.std_hz[dof].tolist()
    with pytest.warns(AntiresWarning, match="setups 0 and 2 have"):
        merged = ar.merge_setups([one, other, one])
    plain = ar.merge_setups([one, other])
    for dof in plain:
        assert merged[dof].tolist() == plain[dof].tolist()
        assert merged.std_hz[dof].tolist() == plain.std_hz[dof].tolist()
    with pytest.raises(UnsuitableDataError, match=r"setups 0 and 1 .* Give each setup once"):
        ar.merge_setups([one, one], check="raise")
    assert ar.merge_setups([one, one], check="off") == ar.AntiresonanceSet.from_tables(0, one.tables)
    # Empty responses are no copies.
    a, b = (ar.AntiresonanceSet(0, {0: [f], 1: []}, std_hz={0: [0.02]}) for f in (8.7, 8.71))
    assert ar.merge_setups([a, b])[1].size == 0

"""Values that are known, followed in a test: where they are now, what is not there, what is new."""

import json

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.exceptions import AntiresWarning
from antires_rs.watch.stored_tests import decoded, encoded
from reference.virtual_records import hit_record

EXCITATION, BAND = 1, (5.0, 75.0)
MASSES, SPRINGS, GROUND = [10.0, 9.0, 10.0, 8.0, 7.0], [4.5e5, 5e5, 4e5, 3.5e5], 5e5


def chain(factor=1.0, at=None):
    springs = [k * (factor if at in (None, i) else 1.0) for i, k in enumerate(SPRINGS)]
    return ar.MassSpringChain(MASSES, springs, ground_first_n_per_m=GROUND * (factor if at is None else 1.0))


def curves(model, seed=0):
    freq, rng = np.linspace(2.0, 80.0, 700), np.random.default_rng(seed)
    values = model.frf([0, 1, 2, 3], EXCITATION, freq, damping_ratio=0.01)
    rough = rng.standard_normal(values.shape) + 1j * rng.standard_normal(values.shape)
    return ar.FrequencyResponse(freq, values * (1.0 + 1e-3 * rough), dofs=[0, 1, 2, 3])


def hit(model, seed, noise=0.02):
    k, m = np.asarray(model.stiffness()), np.asarray(model.mass())
    responses, _ = hit_record(k, m, excitation=EXCITATION, fs_hz=256.0, noise=noise, seed=seed)
    return ar.Recording(responses[:4], 256.0, dofs=[0, 1, 2, 3])


def exact(model):
    return {dof: model.antiresonances(dof, EXCITATION, f_max_hz=BAND[1]) for dof in range(4)}


KNOWN = ar.AntiresonanceSet(EXCITATION, exact(chain()))


def follow(source, near=KNOWN, **options):
    return ar.identify_antiresonances(source, excitation=EXCITATION, band_hz=BAND, near=near, **options)


def test_every_value_of_single_hits_is_followed_within_its_error():
    off, seen = [], 0
    for seed in range(6):
        zeros = follow(hit(chain(), seed))
        seen += sum(map(len, zeros.values()))
        for dof in zeros:
            truth = KNOWN[dof][zeros.followed[dof]]
            off.append((zeros[dof] - truth) / np.hypot(zeros.std_hz[dof], 1e-3 * truth))
    assert seen >= 0.95 * 6 * sum(map(len, KNOWN.values()))
    assert np.mean(np.abs(np.concatenate(off)) < 2.0) >= 0.9


@pytest.mark.parametrize("factor", [0.8, 1.2])
def test_a_change_of_ten_percent_is_not_taken_for_the_neighbour(factor):
    now = exact(chain(factor))  # all values move by a tenth, further than some are apart
    assert min(np.diff(KNOWN[2]) / KNOWN[2][1:]) < 0.13
    zeros = follow(curves(chain(factor)), fit=ar.FitOptions(min_share=0.3))
    for dof in zeros:
        np.testing.assert_array_equal(zeros.followed[dof], np.arange(len(KNOWN[dof])))
        np.testing.assert_allclose(zeros[dof], now[dof], rtol=3e-3)


def test_what_is_not_there_is_said_and_what_is_new_is_found_on_request():
    less = {dof: list(KNOWN[dof]) for dof in KNOWN}
    less[3] = [27.0, less[3][1]]  # one that is not there, and one less
    near = ar.AntiresonanceSet(EXCITATION, less)
    zeros = follow(curves(chain()), near)
    assert zeros.not_seen[3].tolist() == [27.0]
    assert not zeros.not_seen[0].size
    assert zeros.followed[3].tolist() == [1]
    both = follow(curves(chain()), near, fit=ar.FitOptions(new_values=True))
    assert both.followed[3].tolist() == [-1, 1]
    assert abs(both[3][0] / KNOWN[3][0] - 1.0) < 1e-3
    status = both.to_dataframe().set_index(["dof", "followed"])["status"]
    assert (status[3, -1], status[3, 0], status[3, 1]) == ("new", "not seen", "followed")


def test_files_and_series_keep_it():
    zeros = follow(curves(chain()), ar.AntiresonanceSet(EXCITATION, {0: [30.0], 3: [*KNOWN[3]]}))
    stored = json.loads(json.dumps(encoded(zeros)))
    for again in (ar.AntiresonanceSet.from_json(zeros.to_json()), decoded(stored)):
        assert again == zeros
        assert again.options["fitted"] == "followed"
        for dof in zeros:
            np.testing.assert_array_equal(again.followed[dof], zeros.followed[dof])
            np.testing.assert_array_equal(again.not_seen[dof], zeros.not_seen[dof])
    assert zeros.not_seen[0].tolist() == [30.0]
    more = zeros.add(0, 70.0)
    assert more.followed[0].tolist() == [*zeros.followed[0], -1]
    frame = more.to_dataframe().set_index("freq_hz")
    assert (frame["status"][70.0], frame["followed"][70.0]) == ("new", -1)
    assert ar.AntiresonanceSet.from_json(more.to_json()).followed[0].tolist() == more.followed[0].tolist()


def test_what_one_fit_over_the_band_predicts_keeps_its_values():
    case = ar.cases.chain8()
    one, other = (case.experiment(noise=0.02, duration_s=64.0, rng=seed) for seed in (1, 2))
    known = ar.identify_antiresonances(one, excitation=0, band_hz=(3, 130))
    assert known.options["fitted"] == "numerators"
    plain = ar.identify_antiresonances(other, excitation=0, band_hz=(3, 130))
    zeros = ar.identify_antiresonances(other, excitation=0, band_hz=(3, 130), near=known)
    assert sum(np.isin(zeros[dof], plain[dof]).sum() for dof in zeros) >= 27


WRONG = [(ar.AntiresonanceSet(0, {0: [17.0]}), BAND)]
WRONG += [(ar.AntiresonanceSet(EXCITATION, {0: [170.0], 9: [17.0]}), BAND), ({0: [17.0]}, BAND)]
WRONG += [(KNOWN, (40.0, 43.0))]


@pytest.mark.parametrize(("near", "band"), WRONG)
def test_what_cannot_be_followed_is_refused(near, band):
    with pytest.raises(ar.InvalidInputError):
        ar.identify_antiresonances(curves(chain()), excitation=EXCITATION, band_hz=band, near=near)


def test_of_responses_without_a_known_value_new_ones_are_found_or_refused():
    near = ar.AntiresonanceSet(EXCITATION, {0: [*KNOWN[0]]})
    zeros = follow(curves(chain()), near, fit=ar.FitOptions(new_values=True))
    assert tuple(zeros) == (0, 1, 2, 3)
    for dof in (1, 2, 3):
        assert len(zeros[dof])
        assert (zeros.followed[dof] == -1).all()
        assert not zeros.not_seen[dof].size
    assert set(zeros.to_dataframe()["status"]) <= {"followed", "new", "not seen"}
    assert tuple(follow(curves(chain()), near, dofs=[1], fit=ar.FitOptions(new_values=True))) == (1,)
    with pytest.raises(ar.InvalidInputError, match=r"dofs: got \[1\], of which near has no values"):
        follow(curves(chain()), near, dofs=[1])


@pytest.mark.parametrize(
    ("sees", "of_hit", "of_curves"),
    [("frf", "transmissibility", "frf"), ("transmissibility",) * 3, (None, "transmissibility", "frf")],
)
def test_what_is_seen_is_what_the_test_sees(sees, of_hit, of_curves):
    near = ar.AntiresonanceSet(EXCITATION, {0: [*KNOWN[0]]}, sees=sees)
    assert follow(hit(chain(), 0), near).sees == of_hit
    assert follow(curves(chain()), near).sees == of_curves


def test_options_of_a_search_have_no_effect_on_what_is_followed():
    with pytest.warns(AntiresWarning, match=r"freq_tol has no effect on values that are followed"):
        follow(curves(chain()), fit=ar.FitOptions(freq_tol=0.01))

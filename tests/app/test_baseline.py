"""Jobs with a baseline: the intact structure from files, what is written, what a run that ends early says."""

import json

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.app import main as cli
from antires_rs.app.arguments import model_of
from antires_rs.app.job import read_job
from antires_rs.app.reading import baseline_of
from antires_rs.exceptions import InvalidInputError
from tests.support.four_masses import BAND, chain, exact
from tests.support.job_files import DAMAGE, losses, run
from tests.support.refusals import refused
from tests.support.signalled import interrupt_assessments

#: Four masses of 1 kg on springs that are off by up to 6 %.
FOUR = """\
[data]
file = "damaged.npz"
excitation = 0
band_hz = [0.8, 9.0]

[model]
kind = "chain"
masses_kg = [1.0, 1.0, 1.0, 1.0]
springs_n_per_m = [520.0, 435.0, 500.0]

[identification]
max_order = 30

[damage]
baseline = "intact.npz"

[output]
report = false
pictures = false
"""
WITH = DAMAGE.replace("[damage]", '[damage]\nbaseline = "intact.json"')


def write_states(folder):
    case = ar.cases.chain8(perturbation=0.05, rng=0)
    case.exact(0).save(folder / "intact.json")
    case.exact(1).save(folder / "measured.json")


def test_an_intact_state_without_values_is_told_at_the_band(tmp_path):
    case = ar.cases.chain8(perturbation=0.05, rng=0)
    noise = np.random.default_rng(0).standard_normal((8, 4096))
    for name in ("intact", "damaged"):
        ar.write_npz(tmp_path / f"{name}.npz", ar.Recording(noise, 512.0))
    job = tmp_path / "job.toml"
    job.write_text(FOUR.replace("[0.8, 9.0]", "[100.0, 200.0]"), encoding="utf-8")
    said = r"line 4, \[data\] band_hz: got no antiresonance of the intact structure in 100-200 Hz"
    with pytest.warns(ar.AntiresWarning):
        refused(said, lambda: baseline_of(read_job(job), case.model))
    ar.AntiresonanceSet(0, {1: []}).save(tmp_path / "intact.json")
    job.write_text(FOUR.replace("intact.npz", "intact.json"), encoding="utf-8")
    said = r"\[damage\] baseline: got no antiresonance of the intact structure;"
    refused(said, lambda: baseline_of(read_job(job), case.model))


def test_saved_sets(tmp_path, capsys):
    write_states(tmp_path)
    text = WITH.replace("[search]", "false_alarm_rate = 0.05\nprior = { nothing = 0.9, one = 0.1, two = 0, "
                        "three = 0, elsewhere = 0, unknown = 0 }\n\n[search]")  # fmt: skip
    summary = run(tmp_path, text, "--json")
    assert json.loads(capsys.readouterr().out) == summary
    assert losses(summary) == {"spring 4": 0.55}
    now, intact = (ar.AntiresonanceSet.load(tmp_path / name) for name in ("measured.json", "intact.json"))
    how = {"prior": ar.DamagePrior(0.9, 0.1, 0, 0, 0, 0), "search": ar.SearchOptions(false_alarm_rate=0.05)}
    direct = ar.assess_damage(ar.cases.chain8().model, now, baseline=intact, rng=1, **how)
    kept = ar.DamageResult.load(tmp_path / "job_results" / "result.npz")
    assert kept.summary() == direct.summary()
    assert kept.assessment == direct.assessment
    assert summary["headline"] == direct.headline
    assert summary["probability_of_damage"] == direct.probability_of_damage
    assert summary["probability_elsewhere"] == 0.0
    assert summary["chi_square"] == direct.chi_square
    first = summary["hypotheses"][0]
    assert first["elements"] == [4]
    assert first["probability"] == direct.hypotheses[0].probability
    assert (first["low_90"], first["high_90"]) == tuple([v] for v in direct.interval[4])
    row = next(row for row in summary["elements"] if row["element"] == 4)
    assert (row["low_90"], row["high_90"]) == direct.interval[4]
    assert row["probability"] == direct.probability[4]
    assert set(summary["inputs"]) == {"job.toml", "measured.json", "intact.json"}


@pytest.fixture
def records(tmp_path):
    made = {"excitation": 0, "fs_hz": 25.0, "duration_s": 400.0, "damping_ratio": 0.01, "noise": 1e-3}
    for rng, (name, spring) in enumerate({"intact": 450.0, "intact_2": 450.0, "damaged": 337.5}.items(), 1):
        model = chain(np.array([500.0, spring, 520.0]))
        ar.write_npz(tmp_path / f"{name}.npz", model.simulate(**made, rng=rng))
    return tmp_path


def intact(folder, baseline, text=FOUR):
    (folder / "job.toml").write_text(text.replace('"intact.npz"', json.dumps(baseline)), encoding="utf-8")
    job = read_job(folder / "job.toml")
    return baseline_of(job, model_of(job))


def test_several_files_are_several_tests_and_a_pattern_is_one(records):
    two = intact(records, ["intact.npz", "intact_2.npz"])
    assert [each.file.name for each in two] == ["intact.npz", "intact_2.npz"]
    one = intact(records, "intact*.npz")
    assert len(one) == 1
    assert [path.name for path in one[0].repeats] == ["intact_2.npz"]
    both = [ar.read_npz(records / name) for name in ("intact.npz", "intact_2.npz")]
    assert one[0].found == ar.identify_antiresonances(both, excitation=0, band_hz=BAND, max_order=30)
    two[0].found.save(records / "intact.json")
    assert intact(records, "intact.json")[0].found == two[0].found


def test_what_does_not_fit_is_named_where_it_stands(records):
    with pytest.raises(InvalidInputError, match=r"line 15, .damage. baseline\[1\]: got \"miss_\*.npz\""):
        intact(records, ["intact.npz", "miss_*.npz"])
    exact(chain()).save(records / "now.json")
    typed = FOUR.replace('"damaged.npz"\nexcitation = 0\nband_hz = [0.8, 9.0]', '"now.json"')
    for same, text in (("damaged.npz", FOUR), ("*d*.npz", FOUR), ("now.json", typed)):
        refused(r"baseline: got .*, which is .data. itself; wanted a meas", intact, records, same, text)
    said = r"line 13, .damage. baseline: got \"intact.npz\", a meas.*Ide"
    refused(said, intact, records, "intact.npz", typed)
    both = FOUR.replace("[data]", "[[data]]") + FOUR[: FOUR.index("[model]")].replace("[data]", "[[data]]")
    refused(r"baseline: got 1 of them; wanted 2, one for each \[\[dat", intact, records, "intact.npz", both)
    assert len(intact(records, ["intact.npz", "intact_2.npz"], both)) == 2


def test_an_assessment_that_was_interrupted_is_begun_anew(tmp_path, monkeypatch, capsys):
    write_states(tmp_path)
    (tmp_path / "job.toml").write_text(WITH)
    interrupt_assessments(monkeypatch)
    assert cli.main(["damage", str(tmp_path / "job.toml")]) == 130
    assert "begin anew with: antires damage" in capsys.readouterr().err
    assert cli.main(["resume", str(tmp_path / "job.toml")]) == 2
    said = capsys.readouterr().err
    assert "kept no checkpoint; wanted a search that is kept on disk. Begin anew with 'antires damage" in said
    monkeypatch.undo()
    assert cli.main(["damage", str(tmp_path / "job.toml")]) == 0
    assert cli.main(["resume", str(tmp_path / "job.toml")]) == 0
    assert "this search has finished (judged)" in capsys.readouterr().err


def test_what_may_differ_between_the_tests(tmp_path):
    """Springs 1 % stiffer, and one lost."""
    rng, chain, sets = np.random.default_rng(4), ar.cases.chain8().model, []
    springs = ar.stiffness_factor(range(7), bounds=(0.1, 2.0))
    for factors in (np.ones(7), np.where(np.arange(7) == 4, 0.8, 1.01)):
        model = chain.with_parameters(springs, factors)
        found = {dof: model.antiresonances(dof, 0) * (1.0 + 1e-4 * rng.standard_normal()) for dof in range(4)}
        sets.append(ar.AntiresonanceSet(0, found, std_hz={dof: 1e-4 * f for dof, f in found.items()}))
    for name, one in zip(("intact", "measured"), sets, strict=True):
        one.save(tmp_path / f"{name}.json")
    summary = run(tmp_path, WITH.replace("[search]", 'environment = "temperature"\n\n[search]'))
    assert set(losses(summary)) == {"spring 4"}
    kept = ar.DamageResult.load(tmp_path / "job_results" / "result.npz")
    assert kept.options["environment"] == ["temperature"]
    run(tmp_path, WITH.replace("[search]", "environment = []\n\n[search]"))  # nothing else may
    assert ar.DamageResult.load(tmp_path / "job_results" / "result.npz").options["environment"] == []

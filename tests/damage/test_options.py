"""Options of an assessment: said once, kept in the result, and still taken flat."""

import pytest

import antires_rs as ar
from tests.support.wrong_chains import NOMINAL, chain, measured, truth

RNG, FACTORS = truth(7)
BEFORE, NOW = measured(chain(FACTORS), RNG), measured(chain(FACTORS, (0, 0.4, 0, 0, 0)), RNG)


def test_flat_options_of_before_work_and_warn(tmp_path):
    options = ar.SearchOptions(false_alarm_rate=0.05)
    new = ar.assess_damage(NOMINAL, NOW, baseline=BEFORE, search=options, rng=1)
    with pytest.warns(FutureWarning, match=r"search=SearchOptions\(false_alarm_rate=") as caught:
        old = ar.assess_damage(NOMINAL, NOW, baseline=BEFORE, false_alarm_rate=0.05, rng=1)
    assert caught[0].filename == __file__
    assert old.assessment.threshold == new.assessment.threshold is not None
    with pytest.warns(FutureWarning, match="Assessor: std_common") as caught:
        ar.Assessor(NOMINAL, baseline=BEFORE, std_common=1e-3, search=options)
    assert caught[0].filename == __file__
    with pytest.raises(TypeError, match="gamma3"):
        ar.assess_damage(NOMINAL, NOW, gamma3=1.0)
    new.save(tmp_path / "new.npz")
    kept = ar.DamageResult.load(tmp_path / "new.npz").options
    assert kept == new.options == old.options
    assert (kept["false_alarm_rate"], kept["std_common"], kept["prior"]["one"]) == (0.05, 5e-4, 0.36)
    paper = ar.assess_damage(NOMINAL, NOW, search=ar.SearchOptions(gamma1=0.1), rng=0)
    assert (paper.options["gamma1"], paper.options["snap"]) == (0.1, 1e-3)
    assert "islands" in paper.options
    assert "std_common" not in paper.options


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("search", {"search": {"gamma1": 0.1}}),
        ("gamma1", {"search": ar.SearchOptions(gamma1=0.1)}),
        ("reduction", {"search": ar.SearchOptions(reduction="always")}),
        ("optimizer", {"optimizer": ar.IslandGA()}),
    ],
)
def test_what_has_no_effect_or_no_meaning_is_refused(name, given):
    with pytest.raises(ar.InvalidInputError, match=name):
        ar.assess_damage(NOMINAL, NOW, baseline=BEFORE, **given)

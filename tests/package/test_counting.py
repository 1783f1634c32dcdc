"""One number for one thing: what is printed, drawn or saved is the index that arguments take."""

import re

import numpy as np

import antires_rs as ar
from antires_rs import figures as plotting
from antires_rs.figures.report import write_report
from tests.support.four_masses import exact

HIT, LOSS = 2, 0.4


def named(text, what):
    return {int(number) for number in re.findall(rf"\b{what}s? (\d+)", text, re.IGNORECASE)}


def test_a_spring_has_one_number_in_all_that_is_said_and_drawn(tmp_path, quick_pictures):
    springs = np.full(5, 500.0)
    weaker = springs * np.where(np.arange(5) == HIT, 1.0 - LOSS, 1.0)
    model, damaged = (ar.MassSpringChain(np.ones(6), each) for each in (springs, weaker))
    found = ar.assess_damage(model, exact(damaged), baseline=exact(model))
    name = f"spring {HIT}"
    assert found.damaged == [HIT]
    assert named(found.headline, "spring") == {HIT}
    assert found.hypotheses[0].elements == (HIT,)
    assert str(found.hypotheses).splitlines()[1].split(maxsplit=1)[1].startswith(name)
    assert name in found.summary()
    assert found.problem.names[HIT] == f"stiffness loss of {name}"
    assert tuple(found.hypotheses.to_dataframe().iloc[0]["elements"]) == (HIT,)
    assert found.plot().get_xticklabels()[HIT].get_text() == name
    drawn = plotting.plot_chain(model, {HIT: 100.0 * LOSS})
    assert [text.get_text() for text in drawn.texts] == [str(e) for e in range(5)]
    html = write_report(found, tmp_path / "r.html").read_text(encoding="utf-8")
    assert named(re.search(r'<p class="answer">(.*?)</p>', html)[1], "spring") == {HIT}
    assert re.search(rf'<tr class="hit">.*?<th [^>]*>(<span[^>]*>)?{name}<', html, re.DOTALL)

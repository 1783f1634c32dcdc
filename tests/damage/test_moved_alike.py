"""Values that have all moved alike, as at another temperature, are no damage: judged on seeds drawn here."""

import numpy as np
import pytest

import antires_rs as ar
from tests.support.wrong_chains import NOMINAL, N, chain, measured, truth


def frame(stiffness):
    nodes = [(0, 0), (0, 0.4), (0, 0.8), (0.4, 0.8), (0.8, 0.8), (0.8, 0.4), (0.8, 0), (1.2, 0.8)]
    beams = [(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 6), (4, 7)]
    bars = {str(n): ar.Rectangle(0.03, 0.006, 7e10 * k, 2700.0) for n, k in enumerate(stiffness)}
    return ar.FrameModel(nodes, [(a, b, str(n)) for n, (a, b) in enumerate(beams)], bars, fixed=[0, 6])


def shifted(sets, by):
    return [
        ar.AntiresonanceSet(
            s.excitation, {d: s[d] * (1.0 + by) for d in s}, std_hz={d: s.std_hz[d] for d in s}
        )
        for s in sets
    ]


def of_frame(model, rng, std=3e-4):
    force = model.dof(2, "u")
    dofs = [model.dof(*at) for at in ((1, "u"), (2, "u"), (3, "v"), (5, "u"), (7, "v"), (4, "u"))]
    exact = model.antiresonances(dofs, force, f_max_hz=400.0)
    freq = {
        dof: f[f > 2.0] * (1.0 + std * rng.standard_normal((f > 2.0).sum()))
        for dof, f in zip(dofs, exact, strict=True)
    }
    return [ar.AntiresonanceSet(force, freq, std_hz={dof: std * f for dof, f in freq.items()})]


@pytest.mark.parametrize("by", [-0.008, 0.005])
def test_an_intact_frame_at_another_temperature(by):
    for seed in range(2):
        rng = np.random.default_rng([72, seed])
        true = frame(np.exp(rng.uniform(-0.04, 0.04, 7)))
        before, now = of_frame(true, rng), shifted(of_frame(true, rng), by)
        result = ar.assess_damage(frame(np.ones(7)), now, baseline=before)
        assert result.damaged == []
        assert result.hypotheses[0].unknown
        (note,) = (each for each in result.notes if each.startswith("All values are"))
        told = float(note.split()[3])
        assert abs(told - 100.0 * abs(by)) < 0.03
        way = "higher" if by > 0.0 else "lower"
        assert way in note
        assert result.headline.startswith("No damage found: all values are 0.")
        assert f"{way} than in the intact state, as another temperature or sampling clock" in result.headline
        assert "none of the candidates" not in result.headline


def test_damage_is_no_common_shift():
    rng, factors = truth(81)
    losses = np.full(N - 1, 0.0)
    losses[2] = 0.2
    now, before = measured(chain(factors, losses), rng), measured(chain(factors), rng)
    result = ar.assess_damage(NOMINAL, now, baseline=before)
    assert result.damaged == [2]
    assert not any(note.startswith("All values") for note in result.notes)
    moved = ar.assess_damage(NOMINAL, shifted(before, -0.01), baseline=before)
    assert moved.damaged == []
    assert any(note.startswith("All values are 1 % lower") for note in moved.notes)

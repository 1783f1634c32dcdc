"""The sentence on the test that would separate what is left."""

import numpy as np

import antires_rs as ar

INTACT = np.array([500.0, 450.0, 520.0, 480.0])


def chain(springs):
    return ar.MassSpringChain([1.0] * 4, springs[1:], ground_first_n_per_m=springs[0])


def measured(springs, dofs, rng):
    exact = chain(springs).antiresonances(dofs, 1)
    freq = {
        d: np.sort(f * (1.0 + 2e-4 * rng.standard_normal(f.size))) for d, f in zip(dofs, exact, strict=True)
    }
    return ar.AntiresonanceSet(1, freq, std_hz={dof: 2e-4 * f for dof, f in freq.items()})


def test_it_names_no_sensor_that_would_leave_a_damage_unseen():
    now = INTACT * [1.0, 1.0, 0.7, 1.0]  # spring 1, between masses 1 and 2

    def assessed(dofs):
        rng = np.random.default_rng(1)
        before, after = (measured(springs, dofs, rng) for springs in (INTACT, now))
        return ar.assess_damage(chain([500.0] * 4), after, baseline=before, workers=1, progress=False)

    one = assessed([3])
    assert one.damaged == []
    # In the band of its one value a sensor at mass 2 would see spring 2, but none would see spring 1.
    assert "no further sensor or place of the force would in the band of these values" in one.separating_test
    assert one.separating_test in one.notes
    assert assessed([3, 1]).damaged == [1]  # whose values lie beside that band
    assert assessed([3, 1]).separating_test == ""


def test_values_without_standard_deviation_have_it_too():
    bar = ar.Rectangle(0.04, 0.008, 7.0e10, 2700.0)
    nodes, beams = [(0.1 * i, 0.0) for i in range(7)], [(i, i + 1) for i in range(6)]
    beam = ar.FrameModel(nodes, beams, bar, fixed=[0, 6])  # symmetric
    middle = beam.dof(3, "v")
    states = (beam, beam.with_parameters(ar.stiffness_reduction(1), [0.3]))
    before, after = (
        ar.AntiresonanceSet(middle, {middle: one.antiresonances(middle, middle, f_max_hz=1500.0)})
        for one in states
    )
    found = ar.assess_damage(beam, after, baseline=before, workers=1, progress=False)
    assert found.separating_test.startswith("To tell element")
    assert "element 4" in found.summary()

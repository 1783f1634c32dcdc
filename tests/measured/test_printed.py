"""A printed set: frequency, deviation, grade and doubts."""

import antires_rs as ar
from antires_rs.identification.scores import graded
from antires_rs.measured.antiresonance_set import doubts_of
from antires_rs.measured.response_table import ResponseTable


def table():
    made = ResponseTable.of_sweep(
        [8.7, 23.9, 31.0],
        [0.01, 0.01, 0.01],
        [0.004, 0.005, 0.2],
        rows=[45, 30, 5],
        spread=[1e-5, 4e-3, 4e-3],
        dominance=[1.0, 1.0, 0.5],
        how=["chain", "chain", "persistent"],
    )
    return graded(made.with_scores(residual=[0.01, 0.01, 0.2], prominence_db=[15.0, 2.0, 2.0]))


class Other:
    def is_confirmed(self, dof, freq_hz):
        return {8.7: True, 23.9: None, 31.0: False}[freq_hz]


def test_a_set_has_a_line_a_value_with_its_doubts_in_words():
    found = ar.AntiresonanceSet.from_tables(0, {"tip": table(), 7: table().take([])}).add("tip", 50.0)
    weak = "does not stand still, few orders, unsteady, owns little of its curve, poor fit, no clear peak"
    assert str(found).splitlines()[1:-1] == [
        "dof  freq_hz  std_hz  grade  doubts",
        "tip   8.7000  0.0040  sure",
        "     23.9000  0.0050  fair   unsteady, no clear peak",
        f"     31.0000  0.2000  weak   {weak}",
        "     50.0000       -         added by hand",
        "  7        -",
    ]
    words = doubts_of(0, table(), Other())
    assert words == [[], ["unsteady", "no clear peak"], [*weak.split(", "), "not confirmed"]]

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


def test_doubts_in_words():
    assert doubts_of(0, table(), Other()) == [
        [],
        ["unsteady", "no clear peak"],
        [
            "does not stand still",
            "few orders",
            "unsteady",
            "owns little of its curve",
            "poor fit",
            "no clear peak",
            "not confirmed",
        ],
    ]


def test_a_printed_set_has_a_line_a_value_in_columns():
    found = ar.AntiresonanceSet.from_tables(0, {"tip": table(), 7: table().take([])}).add("tip", 50.0)
    lines = str(found).splitlines()
    assert lines[1].split() == ["dof", "freq_hz", "std_hz", "grade", "doubts"]
    assert [line.split()[-1] for line in lines[2:7]] == ["sure", "peak", "peak", "hand", "-"]
    ends = [lines[1].index("freq_hz") + 7] + [line.index(".") + 5 for line in lines[2:6]]
    assert len(set(ends)) == 1
    starts = {line.index(word) for line, word in zip(lines[1:4], ("grade", "sure", "fair"), strict=True)}
    assert len(starts) == 1
    assert all(line == line.rstrip() for line in lines)

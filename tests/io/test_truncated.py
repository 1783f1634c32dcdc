"""Row 3 of the files' bar on a few cuts of each format; benchmarks/truncated_files.py takes 300."""

import pytest

from reference import truncation

pytest.importorskip("h5py")
pytest.importorskip("pyuff")


@pytest.mark.parametrize("name", truncation.FORMATS)
def test_no_cut_goes_unnoticed(tmp_path, name):
    counts, bad = truncation.judged(name, tmp_path, 12 if name.startswith("MAT") else 40)
    assert bad == []
    # Nearly all cuts lose something, and then an error is the rule.
    errors = sum(n for (where, what), n in counts.items() if what == "error" and "partial" not in where)
    told = sum(n for (where, what), n in counts.items() if what == "warning" and "partial" not in where)
    inside = sum(n for (where, what), n in counts.items() if where == "inside")
    assert errors + told >= 0.9 * inside


def test_silence_is_where_it_is_documented(tmp_path):
    """On a boundary of formats that do not state their size, and nowhere else."""
    counts, _ = truncation.judged("UFF 58b, other", tmp_path, 10)
    assert counts["boundary", "silence"] == 6
    counts, _ = truncation.judged("UFF 58b, ours", tmp_path, 10)
    assert counts["boundary", "error"] == 6
    assert counts["boundary, partial", "warning"] == 6


@pytest.mark.parametrize("name", ["UFF 58b, ours", "UFF 58b, other", "UFF 58, ours"])
def test_every_byte_around_a_boundary(tmp_path, name):
    """A marker is seven bytes, five of them blanks: random cuts seldom fall among them."""
    form = truncation.FORMATS[name]
    path = tmp_path / "whole"
    form.write(path)
    data, whole = path.read_bytes(), form.read(path)
    ends = form.ends(data)
    for position in range(ends[1] - 90, ends[1] + 90):
        path.write_bytes(data[:position])
        found = truncation.outcome(form, path, whole)
        silent = not form.states_size and position in ends
        assert found == ("silence" if silent else "error"), position - ends[1]
    path.write_bytes(data[:-1])
    assert truncation.outcome(form, path, whole) == "whole"

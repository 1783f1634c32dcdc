"""Readers, whatever is in a file and wherever it was cut: a signal, or an error of ours."""

from __future__ import annotations

import warnings
import zipfile

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

import antires_rs as ar
from reference import truncation
from reference.io_signals import differences
from reference.mutant_kinds import FUZZED, KINDS, of_input, outcome
from reference.truncation import FORMATS
from tests.support.campaign import examples
from tests.support.mutations import any_bytes, mutated
from tests.support.paths import ROOT

#: Formats read in this process, without compression, so that a change gets past the checksum of an archive.
READ_HERE = ["UFF 58b, ours", "UFF 58, ours", "UFF 58b, other", "UFF 58, other", "CSV, ours", "CSV, other"]
READ_HERE += ["Matrix Market", "AntiresonanceSet"]
for _package in ("pyuff", "h5py"):
    pytest.importorskip(_package)
ONE_FILE = settings(
    deadline=20_000, max_examples=examples(60), suppress_health_check=[HealthCheck.function_scoped_fixture]
)
DOFS = st.one_of(  #: Dofs as files may hold them; control characters are refused by name.
    st.integers(0, 10**6),
    st.text(st.characters(codec="utf-8", exclude_categories=["C", "Z"]), min_size=1, max_size=12),
)


def read(form, path, content, **options):
    path.write_bytes(content)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", ar.AntiresWarning)
        try:
            return form.read(path, **options)
        except ar.AntiresError:
            return None


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder, made = tmp_path_factory.mktemp("whole"), {}

    def make(name):
        if name not in made:
            path = folder / f"whole{FORMATS[name].ending}"
            FORMATS[name].write(path)
            made[name] = path.read_bytes()
        return made[name]

    return make


@pytest.mark.parametrize("name", READ_HERE)
@ONE_FILE
@given(content=any_bytes)
def test_any_bytes(tmp_path, name, content):
    read(FORMATS[name], tmp_path / f"any{FORMATS[name].ending}", content)


@pytest.mark.parametrize("name", READ_HERE)
@ONE_FILE
@given(data=st.data())
def test_a_good_file_gone_wrong(tmp_path, whole, name, data):
    form = FORMATS[name]
    options = {"partial": True} if form.partial and data.draw(st.booleans(), label="partial") else {}
    read(form, tmp_path / f"any{form.ending}", data.draw(mutated(whole(name))), **options)


@st.composite
def recordings(draw):
    """Recordings of any dofs and values that are finite, from a billionth to a billion."""
    dofs = draw(st.lists(DOFS, min_size=1, max_size=4, unique_by=str))
    n = draw(st.integers(len(dofs) + 1, 30))
    value = st.floats(-1e9, 1e9, allow_subnormal=False).filter(lambda v: v == 0.0 or abs(v) > 1e-9)
    rows = draw(st.lists(st.lists(value, min_size=n, max_size=n), min_size=len(dofs), max_size=len(dofs)))
    return ar.Recording(np.array(rows), draw(st.sampled_from([1.0, 512.0, 1000.0 / 7.0])), dofs)


@pytest.mark.parametrize("kind", ["csv", "uff", "npz"])
@settings(ONE_FILE, max_examples=examples(30))
@given(record=recordings())
def test_what_was_written_is_read(tmp_path, kind, record):
    path = tmp_path / f"any.{kind}"
    refused = None
    try:
        getattr(ar, f"write_{kind}")(path, record)
    except ar.InvalidInputError as exc:
        refused = exc
    if refused is None:
        assert differences(record, getattr(ar, f"read_{kind}")(path))["responses"] == 0.0
    else:
        assert refused.argument == "dofs"


#: What needs no child process; benchmarks/mutant_files.py reads many more, of every kind.
CHILDREN = ("hdf5", "mat5", "mat ", "tdms", "wav", "excel", "parquet", "conditions parquet", "miniseed")
CHILDREN += ("series parquet",)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if not kind.startswith(CHILDREN)])
def test_mutants(tmp_path, kind):
    whole = KINDS[kind].make(tmp_path)
    assert outcome(kind, whole) == ("read", "")
    good, path = whole.read_bytes(), tmp_path / f"mutant{KINDS[kind].ending}"
    for number in range(12):
        path.write_bytes(KINDS[kind].mutate(good, np.random.default_rng([7, number])))
        assert outcome(kind, path)[0] in ("read", "ours"), (number, outcome(kind, path))


def test_what_fuzzing_found(tmp_path):
    """benchmarks/fuzz_files.py begins with these, and finds more."""
    good = {kind: KINDS[kind].make(tmp_path).read_bytes() for kind in FUZZED}
    with zipfile.ZipFile(ROOT / "reference" / "fuzz_corpus.zip") as corpus:
        for name in corpus.namelist():
            found = of_input(corpus.read(name), good, tmp_path)
            assert found[0] != "RAW", (name, found)


# -- Cuts: row 3 of the files' bar on a few of each format; benchmarks/truncated_files.py takes 300
@pytest.mark.parametrize("name", FORMATS)
def test_no_cut_goes_unnoticed(tmp_path, name, own_process):
    counts, bad = truncation.judged(name, tmp_path, 5 if name.startswith(("MAT", "HDF5")) else 40)
    assert bad == []
    # Nearly all cuts lose something, and then an error is the rule.
    errors = sum(n for (where, what), n in counts.items() if what == "error" and "partial" not in where)
    told = sum(n for (where, what), n in counts.items() if what == "warning" and "partial" not in where)
    assert errors + told >= 0.9 * sum(n for (where, what), n in counts.items() if where == "inside")


@pytest.mark.parametrize("name", ["UFF 58b, ours", "UFF 58b, other", "UFF 58, ours"])
def test_every_byte_around_a_boundary(tmp_path, name):
    """A marker is seven bytes, five of them blanks: random cuts seldom fall among them."""
    form = FORMATS[name]
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

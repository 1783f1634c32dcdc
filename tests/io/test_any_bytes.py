"""Readers of text and binary files, whatever is in them: a signal, or an error of ours."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

import antires_rs as ar
from reference.io_signals import differences
from reference.mutant_kinds import KINDS, mutant, outcome
from reference.truncation import FORMATS
from tests.support.campaign import examples
from tests.support.mutations import any_bytes, mutated

#: Formats read in this process, without compression, so that a change gets past the checksum of an archive.
READ_HERE = (
    "UFF 58b, ours",
    "UFF 58, ours",
    "UFF 58b, other",
    "UFF 58, other",
    "CSV, ours",
    "CSV, other",
    "Matrix Market",
    "AntiresonanceSet",
)
ONE_FILE = settings(
    deadline=20_000, max_examples=examples(60), suppress_health_check=[HealthCheck.function_scoped_fixture]
)
#: Dofs as files may hold them; control characters are refused by name.
DOFS = st.one_of(
    st.integers(0, 10**6),
    st.text(st.characters(codec="utf-8", exclude_categories=["C", "Z"]), min_size=1, max_size=12),
)


def read(form, path, content, **options):
    """What the reader makes of the content: None where it refuses it in its own words."""
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
    """Bytes of a good file, by format."""
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


@pytest.mark.parametrize("sizes", ["2 3", "3 2", "2 2_0", "-2 -2", "0 0"])
@pytest.mark.parametrize("symmetry", ["symmetric", "skew-symmetric", "general"])
def test_a_matrix_that_is_not_square_ends_no_process(tmp_path, sizes, symmetry):
    """Found at random: SciPy wrote beyond its memory at a symmetric array of two rows and three columns."""
    text = f"%%MatrixMarket matrix array real {symmetry}\n{sizes}\n" + "1.0\n" * 3
    assert read(FORMATS["Matrix Market"], tmp_path / "any.mtx", text.encode()) is None


@pytest.mark.parametrize("entry", ["0\0", "0x", "1 2", "", "nan-", "1e", "--1"])
def test_an_entry_that_is_no_number_ends_no_process(tmp_path, entry):
    """Found at random: SciPy ended the process at a NUL behind a number of a symmetric array."""
    lines = ["%%MatrixMarket matrix array real symmetric", "40 40", *["0"] * 177, entry, *["0"] * 642, ""]
    assert read(FORMATS["Matrix Market"], tmp_path / "any.mtx", "\n".join(lines).encode()) is None


@st.composite
def recordings(draw):
    """Recordings of any dofs and values that are finite, from a billionth to a billion."""
    dofs = draw(st.lists(DOFS, min_size=1, max_size=4, unique_by=str))
    n = draw(st.integers(len(dofs) + 1, 30))
    value = st.floats(-1e9, 1e9, allow_subnormal=False).filter(lambda v: v == 0.0 or abs(v) > 1e-9)
    rows = draw(st.lists(st.lists(value, min_size=n, max_size=n), min_size=len(dofs), max_size=len(dofs)))
    return ar.Recording(np.array(rows), draw(st.sampled_from([1.0, 512.0, 1000.0 / 7.0])), dofs)


@pytest.mark.parametrize(
    ("write", "read", "ending"),
    [
        (ar.write_csv, ar.read_csv, ".csv"),
        (ar.write_uff, ar.read_uff, ".uff"),
        (ar.write_npz, ar.read_npz, ".npz"),
    ],
)
@ONE_FILE
@given(record=recordings())
def test_what_was_written_is_read(tmp_path, write, read, ending, record):
    """Every bit of the values; names that a format cannot hold are refused when they are written."""
    path = tmp_path / f"any{ending}"
    refused = ""
    try:
        write(path, record)
    except ar.InvalidInputError as exc:
        refused = str(exc)
    if refused:
        assert refused.startswith("dofs: ")
        return
    assert differences(record, read(path))["responses"] == 0.0


#: Formats that need no child process; benchmarks/mutant_files.py reads many more, of every kind.
CHILDREN = ("hdf5", "mat", "tdms", "wav", "excel", "parquet", "miniseed")
QUICK = [kind for kind in KINDS if not kind.startswith(CHILDREN)]


@pytest.mark.parametrize("kind", QUICK)
def test_mutants(tmp_path, kind):
    if kind.startswith("uff"):
        pytest.importorskip("pyuff")
    whole = KINDS[kind].make(tmp_path)
    assert outcome(kind, whole) == ("read", "")
    good, path = whole.read_bytes(), tmp_path / f"mutant{KINDS[kind].ending}"
    for number in range(12):
        path.write_bytes(mutant(good, np.random.default_rng([7, number])))
        assert outcome(kind, path)[0] in ("read", "ours"), (number, outcome(kind, path))

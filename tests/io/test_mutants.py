"""Some mutants of each kind of file that needs no child process: a result or an error of ours.

benchmarks/mutant_files.py reads many more, of every kind, with limits on time and memory.
"""

import numpy as np
import pytest

from reference.mutant_kinds import KINDS, mutant, outcome

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

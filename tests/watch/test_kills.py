"""A kill before any change on the disk: the series goes on to the same file, and leaves nothing of its own.

test_store.py tears the log of the database; benchmarks/series_kills.py kills at random times.
"""

import json
import os
import subprocess
import sys

import pytest

from tests.support.paths import ROOT

pytest.importorskip("pyarrow")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork and SIGKILL")
def test_killed_before_any_change_on_the_disk(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "tests.support.series_kills", tmp_path],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["points"] >= 14
    assert found["wrong"] == []

"""A Dask cluster that loses its scheduler."""

import subprocess
import sys

import pytest

pytest.importorskip("distributed")


@pytest.mark.parametrize(
    ("scheduler", "said"), [("restarted", "all right"), ("gone", "a Dask client that has lost its scheduler")]
)
def test_a_run_goes_on_with_a_scheduler_that_comes_back_and_says_so_where_none_does(scheduler, said):
    command = [sys.executable, "-m", "tests.support.dask_scheduler", scheduler]
    found = subprocess.run(command, capture_output=True, text=True, timeout=150, check=True)
    assert said in found.stdout, found.stdout + found.stderr
    if scheduler == "gone":
        assert "call again" in found.stdout

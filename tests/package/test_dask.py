"""A Dask cluster that loses its scheduler."""

import subprocess
import sys

import pytest

import antires_rs as ar
from antires_rs.support.workers import Dask, in_order

distributed = pytest.importorskip("distributed")


@pytest.mark.parametrize(
    ("scheduler", "said"), [("restarted", "all right"), ("gone", "a Dask client that has lost its scheduler")]
)
def test_a_run_goes_on_with_a_scheduler_that_comes_back_and_says_so_where_none_does(scheduler, said):
    command = [sys.executable, "-m", "tests.support.dask_scheduler", scheduler]
    found = subprocess.run(command, capture_output=True, text=True, timeout=150, check=True)
    assert said in found.stdout, found.stdout + found.stderr
    if scheduler == "gone":
        assert "call again" in found.stdout


def test_a_cluster_without_workers_is_told_and_not_waited_for_for_ever(monkeypatch):
    monkeypatch.setattr(Dask, "ask_s", 0.05)
    monkeypatch.setattr(Dask, "warn_s", 0.2)
    monkeypatch.setattr(Dask, "patience_s", 0.6)
    with (
        distributed.LocalCluster(n_workers=0, processes=False, dashboard_address=":0") as cluster,
        distributed.Client(cluster) as client,
    ):
        with (
            pytest.warns(ar.AntiresWarning, match="no worker"),
            pytest.raises(ar.InvalidInputError, match="no worker for 1 s"),
        ):
            list(in_order(abs, range(3), client))
        cluster.scale(1)
        assert list(in_order(abs, range(-3, 0), client)) == [3, 2, 1]

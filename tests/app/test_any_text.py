"""Jobs, whatever is in them: read, or refused in words of ours that name a line."""

from __future__ import annotations

import tomllib
import warnings

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

import antires_rs as ar
from antires_rs.app.arguments import model_of, parameters_of
from antires_rs.app.job import lines_of, read_job
from antires_rs.app.keys import template
from tests.support.campaign import examples
from tests.support.job_files import DAMAGE, UPDATE
from tests.support.mutations import any_bytes, mutated

ONE_FILE = settings(
    deadline=20_000, max_examples=examples(100), suppress_health_check=[HealthCheck.function_scoped_fixture]
)
TEMPLATES = {
    f"{task} of a {model}": template(task, model, data="record.npz")
    for task, model in (("damage", "chain"), ("update", "frame"), ("update", "matrices"))
}
GOOD = {"damage": DAMAGE, "update": UPDATE} | TEMPLATES


def taken(path, content):
    """The job in the file, with its model and parameters made; None where it is refused."""
    path.write_bytes(content)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", ar.AntiresWarning)
        try:
            job = read_job(path)
            model = model_of(job)
            if job.task == "update":
                parameters_of(job, model)
        except ar.AntiresError:
            return None
    return job


@ONE_FILE
@given(content=any_bytes)
def test_any_bytes(tmp_path, content):
    assert taken(tmp_path / "job.toml", content) is None


@pytest.mark.parametrize("name", GOOD)
@ONE_FILE
@given(data=st.data())
def test_a_good_job_gone_wrong(tmp_path, name, data):
    content = data.draw(mutated(GOOD[name].encode()))
    job = taken(tmp_path / "job.toml", content)
    if job is not None:
        text = content.decode()
        lines = lines_of(text)
        assert set(tomllib.loads(text)) <= {path[0] for path in lines}
        assert all(1 <= line <= text.count("\n") + 1 for line in lines.values())

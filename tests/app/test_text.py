"""The text of jobs: lines of keys, the template, the defaults it states; and any text at all."""

import inspect
import json
import tomllib
import warnings

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

import antires_rs as ar
from antires_rs.app.arguments import model_of, parameters_of
from antires_rs.app.job import parsed, read_job
from antires_rs.app.keys import SECTIONS, TASKS, template
from tests.support.campaign import examples
from tests.support.job_files import DAMAGE, UPDATE
from tests.support.mutations import any_bytes, mutated
from tests.support.refusals import refused


def places(value, path=()):
    """Every key of parsed TOML, but for those of tables in lists."""
    for name, item in value.items() if isinstance(value, dict) else ():
        yield (*path, name)
        yield from places(item, (*path, name))


NAMES = st.text("abcXYZ0189_-", min_size=1, max_size=6)
VALUES = st.recursive(
    st.integers(-9, 9)
    | st.booleans()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text("ab\"'#]}=,.[{ \t\\é", max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(NAMES, inner, max_size=3),
    max_leaves=8,
)


def toml(value, newline):
    if isinstance(value, list):
        return f"[{newline}" + f",{newline}".join(toml(v, newline) for v in value) + f"{newline}]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {toml(v, newline)}" for k, v in value.items()) + " }"
    return json.dumps(value, ensure_ascii=False)


@settings(max_examples=examples(60), deadline=None)
@given(
    st.dictionaries(NAMES, st.dictionaries(NAMES, VALUES, max_size=4), min_size=1, max_size=3),
    st.sampled_from(["", " ", "\n", " # ]\n"]),
)
def test_every_key_of_any_text_is_found(tables, newline):
    text = "".join(
        f"[{name}]\n" + "".join(f"{key} = {toml(value, newline)}\n" for key, value in table.items())
        for name, table in tables.items()
    )
    (found, lines), rows = parsed("job.toml", text), text.splitlines()
    assert found == tables
    for path in places(tables):
        assert path in lines
    for name, table in tables.items():
        assert rows[lines[name,] - 1] == f"[{name}]"
        for key in table:
            assert rows[lines[name, key] - 1].startswith(f"{key} = ")


@pytest.mark.parametrize("model", ["chain", "frame", "matrices", "result"])
@pytest.mark.parametrize("task", TASKS)
def test_the_template_is_a_valid_job_with_every_key(tmp_path, task, model):
    text = template(task, model, data="record.npz")
    file = tmp_path / "job.toml"
    file.write_text(text, encoding="utf-8")
    job = read_job(file)
    assert job.task == task
    assert max(map(len, text.splitlines())) <= 110
    kinds = {} if task == "series" else {"data": "npz", "model": model}
    if task == "update":
        kinds["parameters"] = job.parameters[0]["kind"]
    for section in TASKS[task]:
        for key in SECTIONS[section].keys:
            if not key.of or kinds.get(section, key.of[0]) in key.of:
                assert f"\n{key.name} = " in text or f"\n# {key.name} =" in text, (section, key.name)


def test_defaults_in_the_template_are_those_in_force():
    """Those that are not taken from the declaration of an option: of the search, and the misfit."""
    options = ar.IslandGA().options
    for key in SECTIONS["search"].keys:
        if key.name in options and key.default:
            value = tomllib.loads(f"x = {key.default}")["x"]
            assert options[key.name] == value or (key.name, value) == ("polish", True), key.name
    (misfit,) = [key for key in SECTIONS["updating"].keys if key.default]
    assert misfit.default == f'"{inspect.signature(ar.UpdatingProblem).parameters["misfit"].default}"'


def test_dots_and_brackets_in_texts_and_comments_are_no_nesting():
    deep = ".".join(["a"] * 60)
    text = f'note = """\n{deep} = 1\n{"[" * 60}\n"""\nb = "x] \\" [["\n# {deep}, {deep}.\n'
    text += f"c = '''\n{deep}.\n'''\n"
    assert list(parsed("job.toml", text)[0]) == ["note", "b", "c"]
    for nested in (f"{deep} = 1", "x = " + "[" * 60, '"a".' * 50 + "b = 1", f"t = {{ {deep} = 1 }}"):
        refused("line 10: got .* more than 40 deep", parsed, "job.toml", f"{text}{nested}\n")


@pytest.mark.parametrize("part", ['"\\\\', "'", '"""\\\\', "'''a", '"\\\\\n'])
def test_texts_without_an_end_are_refused(part):
    # Of this length only a search that is linear comes to its end.
    refused("no TOML", parsed, "job.toml", part * 40_000)


ONE_FILE = settings(
    deadline=20_000, max_examples=examples(50), suppress_health_check=[HealthCheck.function_scoped_fixture]
)
TEMPLATES = {
    f"{task} of a {model}": template(task, model, data="record.npz")
    for task, model in (("damage", "chain"), ("update", "frame"), ("update", "matrices"))
}
GOOD = {"damage": DAMAGE, "update": UPDATE} | TEMPLATES


def taken(path, content):
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
        tables, lines = parsed("job.toml", text)
        assert set(tables) <= {path[0] for path in lines}
        assert all(1 <= line <= text.count("\n") + 1 for line in lines.values())

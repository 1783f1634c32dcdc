"""What a run keeps beside its result, so that ``antires report`` shows what the run's own report did."""

import json
import re

import numpy as np
import pytest
from matplotlib.figure import Figure

import antires_rs as ar
from antires_rs.app import main as cli
from antires_rs.app.run import FORMAT, VERSION, Evidence
from antires_rs.io.archive import Store, read_store, write_store
from tests.support.job_files import DAMAGE
from tests.support.pictures import drawn_quickly

pytestmark = pytest.mark.usefixtures("quick_pictures")

JOB = DAMAGE.replace(
    'file = "measured.json"',
    """file = "record.npz"
excitation = 0
band_hz = [3, 130]

[identification]
max_order = 24
dofs = [0, 4]""",
).replace("report = false", 'title = "A chain"')


def section(html, heading):
    part = re.search(rf"<h2>{heading}.*?</section>", html, re.S)[0]
    return re.sub(r"\d{4}-\d\d-\d\d \d\d:\d\d UTC", "", part)


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    record = ar.cases.chain8().experiment(1, noise=0.01, duration_s=64.0, rng=1)
    ar.write_npz(folder / "record.npz", record)
    (folder / "job.toml").write_text(JOB, encoding="utf-8")
    with drawn_quickly():
        assert cli.main(["damage", str(folder / "job.toml")]) == 0
    return folder


def test_a_report_drawn_again_is_the_same(ran, capsys):
    results = ran / "job_results"
    again = ran / "again.html"
    assert cli.main(["report", str(results), "--out", str(again)]) == 0
    first, second = ((results / "report.html").read_text(), again.read_text())
    headings = re.findall(r"<h2>(.*?)</h2>", first)
    assert re.findall(r"<h2>(.*?)</h2>", second) == headings
    for heading in headings:
        mine, other = (section(html, re.escape(heading)) for html in (first, second))
        if "before and after" in heading:  # curves are kept in half the digits
            mine, other = (re.sub(r"[A-Za-z0-9+/=]{400,}", "", text) for text in (mine, other))
        assert mine == other, heading
    assert second.count("Stabilization diagram of dof") == first.count("Stabilization diagram of dof") == 4
    assert "Transmissibilities over dof 0" in second
    assert again.stat().st_size < 1e6


def test_the_report_names_what_was_measured_and_how_and_what_repeats_it(ran):
    html = (ran / "job_results" / "report.html").read_text()
    assert "<h1>A chain</h1>" in html
    wanted = "8 responses: 0, 1, 2, 3, 4, 5, 6, 7|64 s at 512 Hz, 32,768 samples a channel|3 to 130 Hz"
    wanted += "|2 to 24|formulation auto|fitted numerators|estimator rank1|freq_tol 0.01, damping_tol 0.1"
    wanted += "|min_rows 10|window hann|independent averages|<p>antires damage job.toml</p>"
    for said in wanted.split("|"):
        assert said in html, said
    recorded = json.loads((ran / "job_results" / "run.json").read_text())
    for file, digest in recorded["inputs"].items():
        assert f"{file}  {digest}" in html
    assert recorded["versions"].keys() == {"antires_rs", "numpy", "scipy", "python", "system"}


def test_evidence_of_version_0_1_0_is_read(ran, tmp_path):
    """It has no values that were not accepted, no unexplained peaks, and says no kind of response."""
    _, data = read_store(ran / "job_results" / "evidence.npz", FORMAT, VERSION, "evidence")
    store = Store()

    def older(value):
        newer = ("left_out", "unexplained_hz", "kind", "sha256")
        if isinstance(value, dict):
            return {key: older(item) for key, item in value.items() if key not in newer}
        if isinstance(value, list):
            return list(map(older, value))
        return store.put(value) if isinstance(value, np.ndarray) else value

    write_store(tmp_path / "evidence.npz", older(data), store)
    read, now = (Evidence.load(folder / "evidence.npz") for folder in (tmp_path, ran / "job_results"))
    assert read.response.kind == "transmissibility"
    assert read.diagrams[0][0].accepted.same_as(now.diagrams[0][0].accepted)
    assert not len(read.diagrams[0][0].left_out)
    read.diagrams[0][0].plot(ax=Figure().subplots())


def test_damaged_evidence_costs_the_diagrams_and_not_the_report(ran, tmp_path, capsys):
    results = tmp_path / "results"
    results.mkdir()
    for name in ("result.npz", "run.json", "evidence.npz"):
        (results / name).write_bytes((ran / "job_results" / name).read_bytes())
    (results / "evidence.npz").write_bytes((results / "evidence.npz").read_bytes()[:5000])
    assert cli.main(["report", str(results)]) == 0
    assert "antires: warning: the report has no diagrams: " in capsys.readouterr().err
    assert "No stabilization diagram can be shown" in (results / "report.html").read_text()


def test_every_warning_of_a_run_is_in_its_report_and_summary(tmp_path, capsys):
    record = ar.cases.chain8().experiment(1, noise=0.01, duration_s=64.0, rng=1)
    clipped = np.array(record.responses)
    clipped[3] = np.clip(clipped[3], -0.5 * clipped[3].std(), 0.5 * clipped[3].std())
    ar.write_npz(tmp_path / "record.npz", ar.Recording(clipped, record.fs_hz))
    (tmp_path / "job.toml").write_text(JOB, encoding="utf-8")
    assert cli.main(["damage", str(tmp_path / "job.toml")]) == 0
    warned = [line.removeprefix("antires: warning: ") for line in capsys.readouterr().err.splitlines()]
    assert warned
    html = (tmp_path / "job_results" / "report.html").read_text()
    shown = re.findall(r"<li>(.*?)</li>", section(html, "Warnings of the run"))
    plain = [text.replace("&#39;", "'").replace("&lt;", "<").replace("&gt;", ">") for text in shown]
    assert plain == warned
    summary = json.loads((tmp_path / "job_results" / "summary.json").read_text())
    assert any("clipped" in text.lower() for text in summary["warnings"])


def test_two_positions_of_the_force_keep_both_diagrams(tmp_path):
    model, data = ar.cases.chain8().true_model(1), ""
    made = {"fs_hz": 512.0, "duration_s": 64.0, "damping_ratio": 0.01, "noise": 1e-3}
    for force in (0, 7):
        ar.write_npz(tmp_path / f"force{force}.npz", model.simulate(excitation=force, **made, rng=force))
        data += f'[[data]]\nfile = "force{force}.npz"\nexcitation = {force}\nband_hz = [3, 130]\n\n'
    job = re.sub(r"\[data\].*?\n\n", data, JOB, count=1, flags=re.S)
    job = job.replace("[0, 4]", "[0, 7]").replace("pictures = false", "")
    (tmp_path / "job.toml").write_text(job, encoding="utf-8")
    assert cli.main(["damage", str(tmp_path / "job.toml")]) == 0
    drawn = {file.stem for file in (tmp_path / "job_results" / "pictures").iterdir()}
    diagrams = {f"stabilization_dof_{dof}_force_at_dof_{force}" for dof in (0, 7) for force in (0, 7)}
    assert drawn == diagrams | {"convergence", "damage", "differences", "model", "response"}
    html = (tmp_path / "job_results" / "report.html").read_text()
    assert "Stabilization diagram of dof 0, force at dof 7" in html
    assert "<h3>Measurement 2</h3>" in html

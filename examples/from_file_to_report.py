"""From a file to a report: a universal file of a shaker test, a job, the damaged spring.

What a newcomer does on the command line, step by step; only the file of the test is made here, from a
simulated record of the eight-mass chain with a damaged spring.

Run: ``python examples/from_file_to_report.py [FOLDER]``
"""

import sys
import webbrowser
from pathlib import Path

import antires_rs as ar
from antires_rs.app.main import main as antires


def write_test(file: Path) -> None:
    """The test: eight accelerometers at nodes 1 to 8, in +Z, 1 % noise; spring 4 has lost 55 %."""
    record = ar.cases.chain8().experiment(level=1, noise=0.01, rng=1)
    named = ar.Recording(record.responses, record.fs_hz, [f"{node}+Z" for node in range(1, 9)], record.force)
    ar.write_uff(file, named)


def edit(job: Path) -> None:
    """Fill in where the channels are and the model, as one would in an editor."""
    text = job.read_text(encoding="utf-8")
    for old, new in (
        *((f'"{node}+Z" = "?"', f'"{node}+Z" = {node - 1}') for node in range(1, 9)),
        ('excitation = "?"', "excitation = 0"),
        ("masses_kg = [1.0, 1.0, 1.0]", f"masses_kg = [0.5593{', 0.4194' * 7}]"),
        ("springs_n_per_m = [50e3, 50e3]", f"springs_n_per_m = [56.7e3{', 56.7e3' * 6}]"),
        ("# title =", 'title = "Eight-mass chain, test of today"'),
    ):
        assert old in text
        text = text.replace(old, new)
    job.write_text(text, encoding="utf-8")


def main(folder: Path) -> Path:
    """Each step as it would be typed."""

    def step(*command: str) -> None:
        print("\n$ antires", *command)
        if antires(command) != 0:
            raise SystemExit(1)

    folder.mkdir(parents=True, exist_ok=True)
    write_test(folder / "test.uff")
    job = folder / "damage.toml"
    step("identify", str(folder / "test.uff"), "--band", "3", "130", "--excitation", "1+Z")
    step("init", str(job), "--data", str(folder / "test.uff"), "--overwrite")
    print("\n... dofs, masses and springs filled in")
    edit(job)
    step("damage", str(job))
    return folder / "damage_results" / "report.html"


if __name__ == "__main__":
    report = main(Path(sys.argv[1] if len(sys.argv) > 1 else "from_file_to_report"))
    print(f"\nThe report: {report}")
    if sys.stdout.isatty():
        webbrowser.open(report.absolute().as_uri())

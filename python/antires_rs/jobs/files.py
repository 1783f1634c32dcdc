"""The folder of a run: what is in it, what was left by one that was killed."""

from __future__ import annotations

import hashlib
import json
import os
import re
from pathlib import Path
from typing import Any

from ..support.files import write_atomically
from .job import Job

__all__ = ["RunFolder", "picture_name", "sha256_of"]


class RunFolder:
    """Names and places of everything that a run writes.

    Attributes
    ----------
    folder, result, summary, report, pictures, checkpoint, record, evidence : pathlib.Path
        ``record`` says which job runs here, from the beginning of the search on.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.result, self.summary = folder / "result.npz", folder / "summary.json"
        self.report, self.pictures = folder / "report.html", folder / "pictures"
        self.checkpoint, self.record = folder / "search.ckpt", folder / "run.json"
        self.evidence = folder / "evidence.npz"

    @classmethod
    def of(cls, job: Job) -> RunFolder:
        """The folder that a job names; ``<job>_results`` beside it by default."""
        name = job.section("output").get("folder")
        return cls(job.file(name) if name else job.path.with_name(f"{job.path.stem}_results"))

    def antiresonances(self, number: int) -> Path:
        """File of the identified set of one [data], numbered from 0."""
        return self.folder / (f"antiresonances_{number}.json" if number else "antiresonances.json")

    def baseline(self, number: int) -> Path:
        """File of a set of the intact structure, numbered from 0."""
        return self.folder / (f"baseline_{number}.json" if number else "baseline.json")

    def prepare(self) -> None:
        """Make the folder; remove what a process that was killed left half-written."""
        self.folder.mkdir(parents=True, exist_ok=True)
        for folder in (self.folder, self.pictures):
            if folder.is_dir():
                for file in folder.iterdir():
                    if _HALF_WRITTEN.fullmatch(file.name):
                        file.unlink(missing_ok=True)

    @property
    def unfinished(self) -> bool:
        """Whether a search waits here to be taken up again."""
        return self.checkpoint.exists() or self._previous.exists()

    @property
    def state(self) -> str | None:
        """How the last run ended, or "searching"; None where none has begun."""
        return (self.read_record() or {}).get("state")

    @property
    def _previous(self) -> Path:
        return self.checkpoint.with_name(self.checkpoint.name + ".previous")

    def forget_search(self) -> None:
        """Remove the checkpoint; the result holds all of it."""
        for file in (self._previous, self.checkpoint):  # a kill in between leaves the later one
            file.unlink(missing_ok=True)

    def forget_record(self) -> None:
        """Remove the record: another run begins, and until it has its own, nothing here speaks for it."""
        self.record.unlink(missing_ok=True)

    def forget_results(self) -> None:
        """Remove what an earlier run drew, so that nothing stale stands beside a new result."""
        pictures = [file for file in self.pictures.glob("*.png") if _PICTURE.fullmatch(file.name)]
        for file in (self.result, self.summary, self.report, *pictures):
            file.unlink(missing_ok=True)

    def write_json(self, file: Path, data: dict[str, Any]) -> None:
        """Write as JSON; numbers that JSON does not know must be null already."""
        write_atomically(file, (json.dumps(data, indent=1, allow_nan=False) + "\n").encode())

    def read_record(self) -> dict[str, Any] | None:
        """What runs or ran here; None where no job did."""
        try:
            data = json.loads(self.record.read_text(encoding="utf-8"))
        except (FileNotFoundError, NotADirectoryError):
            return None
        except ValueError:
            return {}
        return data if isinstance(data, dict) else {}

    def job_path(self, record: dict[str, Any]) -> Path:
        """The job file of a record: relative to the folder, so that both may be moved together."""
        return Path(os.path.normpath(self.folder / str(record.get("job", ""))))


#: As write_atomically and Checkpoint name what is not whole yet.
_HALF_WRITTEN = re.compile(
    r"\.((antiresonances|baseline)(_\d+)?\.json|(result|evidence)\.npz|(summary|run)\.json|"
    r"report\.html|\w+\.png)\.\d+\.tmp|search\.ckpt\.tmp"
)
_PICTURE = re.compile(r"(differences|convergence|damage|hypotheses|model|response|stabilization_.*)\.png")


def picture_name(name: str) -> str:
    """File of a picture; names of channels may hold what no file's may.

    Examples
    --------
    >>> picture_name("stabilization_node 4 v, force at node 0 v")
    'stabilization_node_4_v_force_at_node_0_v.png'
    """
    return re.sub(r"[^\w.+-]+", "_", name) + ".png"


def sha256_of(file: Path) -> str:
    """Checksum of a file's bytes."""
    with open(file, "rb") as opened:
        return hashlib.file_digest(opened, "sha256").hexdigest()

"""What an identification leaves beside its values: diagrams and curves, so that a report can be drawn again.

``evidence.npz`` of a run's folder, version 1: the stabilization diagrams of each [data] by dof, and the
transmissibilities that the report draws. Nothing is computed from it; without it a report has fewer pictures.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import UnsuitableDataError
from ..io._store import Store, read_store, write_store
from ..order_sweep.diagram import StabilizationDiagram
from ..order_sweep.table import ResponseTable
from ..report.facts import of_evidence, of_identification, of_signal
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from .job import Job
from .measured import Measured

__all__ = ["Evidence", "evidence_of", "heard", "measurement_of"]

FORMAT, VERSION = "antires_rs.evidence", 1
_ROWS = ("freq_hz", "damping_ratio", "stable")
_COLUMNS = ("freq_hz", "damping_ratio", "std_hz")
_CURVES = ("orders", "background_freq_hz", "background")
_TABLES = ("accepted", "left_out")


@dataclass(frozen=True)
class Evidence:
    """Pictures' numbers of a run.

    Attributes
    ----------
    diagrams : tuple of mapping of dof to StabilizationDiagram
        One mapping for each [data].
    response : FrequencyResponse or None
        Transmissibilities over the first response that has antiresonances; of measured FRFs themselves.
    """

    diagrams: tuple[Mapping[Any, StabilizationDiagram], ...] = ()
    response: FrequencyResponse | None = field(default=None)

    def __bool__(self) -> bool:
        return self.response is not None or any(self.diagrams)

    def save(self, path: Path) -> None:
        """Write it, whole or not at all."""
        store = Store()
        data = {
            "format": FORMAT,
            "version": VERSION,
            "diagrams": [
                [[dof, _described(diagram, store)] for dof, diagram in table.items()]
                for table in self.diagrams
            ],
            "response": None,
        }
        if self.response is not None:
            r = self.response
            # Drawn in decibels: half the digits are more than the eye can see.
            data["response"] = {
                "freq_hz": store.put(r.freq_hz),
                "dofs": list(r.dofs),
                "values": store.put(r.values.astype(np.complex64)),
                "kind": r.kind,
                "reference": r.reference,
            }
        write_store(path, data, store)

    @classmethod
    def load(cls, path: Path) -> Evidence:
        """Read it.

        Raises
        ------
        UnsuitableDataError
            The file is damaged, of another kind, or of a newer version.
        """
        _, data = read_store(path, FORMAT, VERSION, "the evidence.npz of a run")
        tables = tuple({dof: _made(diagram) for dof, diagram in table} for table in data["diagrams"])
        r = data["response"]
        return cls(
            tables,
            None
            if r is None
            else FrequencyResponse(
                r["freq_hz"], r["values"], r["dofs"], r.get("kind", "transmissibility"), r["reference"]
            ),
        )


def evidence_of(job: Job, measured: list[Measured]) -> Evidence:
    """What the sets of a run carry."""
    return Evidence(tuple(m.found.diagrams for m in measured), _response(job, measured))


def measurement_of(job: Job, measured: list[Measured]) -> list[dict[str, list[str]]]:
    """What was measured and how it was identified, in words, for each measurement."""
    facts = []
    for each in measured:
        table = each.table
        own = {"File": [path.name for path in (each.file, *each.repeats)]}
        if isinstance(table.get("dofs"), dict):
            own["Dofs"] = [
                f"{name} = {'left out' if dof is False else dof}" for name, dof in table["dofs"].items()
            ]
        if each.signal is not None:
            own |= of_signal(each.signal)
            own["Unit"] = [
                f"{table['unit']} in the file, here SI"
                if table.get("unit")
                else "SI (m/s2 for accelerations); what the file names otherwise was converted"
            ]
            own |= of_identification(each.signal, each.found, table["band_hz"], job.section("identification"))
        facts.append(own | of_evidence(each.found))
    return facts


@contextmanager
def heard() -> Iterator[list[str]]:
    """Every warning that is raised inside, while it is shown as ever."""
    said: list[str] = []
    with warnings.catch_warnings():
        show = warnings.showwarning

        def keep(message: Warning | str, *rest: Any, **named: Any) -> None:
            if str(message) not in said:
                said.append(str(message))
            show(message, *rest, **named)

        warnings.showwarning = keep
        yield said


def _described(diagram: StabilizationDiagram, store: Store) -> dict[str, Any]:
    """A diagram as arrays: the rows of all orders in one."""
    return {
        "band_hz": list(diagram.band_hz),
        "counts": store.put(np.array([len(row) for row in diagram.freq_hz], dtype=np.int64)),
        **{name: store.put(np.concatenate([np.empty(0), *getattr(diagram, name)])) for name in _ROWS},
        **{name: store.put(getattr(diagram, name)) for name in _CURVES},
        **{
            table: {name: store.put(values) for name, values in _columns(getattr(diagram, table)).items()}
            for table in _TABLES
        },
        "unexplained_hz": store.put(diagram.unexplained_hz),
    }


def _columns(table: ResponseTable) -> dict[str, Any]:
    return {**{name: getattr(table, name) for name in _COLUMNS}, **table.scores}


def _made(data: dict[str, Any]) -> StabilizationDiagram:
    ends = np.cumsum(data["counts"])[:-1]
    freq, damping, stable = (tuple(np.split(data[name], ends)) for name in _ROWS)
    low, high = data["band_hz"]
    # Files of older versions do not have what was not accepted.
    accepted, left_out = (_table(data[name]) if name in data else ResponseTable([]) for name in _TABLES)
    return StabilizationDiagram(
        data["orders"],
        freq,
        damping,
        tuple(row.astype(bool) for row in stable),
        accepted,
        data["background_freq_hz"],
        data["background"],
        (low, high),
        left_out,
        data.get("unexplained_hz", np.empty(0)),
    )


def _table(columns: Mapping[str, Any]) -> ResponseTable:
    scores = dict(columns)
    hz, zeta, std = (scores.pop(name) for name in _COLUMNS)
    return ResponseTable(hz, zeta, std, scores)


def _response(job: Job, measured: list[Measured]) -> FrequencyResponse | None:
    """Transmissibilities over the first response that has antiresonances, where they can be had."""
    first = measured[0]
    if isinstance(first.signal, FrequencyResponse):
        return _inside(first.signal, *job.data[0]["band_hz"])
    dof = next((dof for dof, values in first.found.items() if values.size), None)
    if not isinstance(first.signal, Recording) or dof is None or first.signal.n_channels < 2:
        return None
    from ..signals.segment_length import choose_nperseg
    from ..signals.transfer_functions import transmissibility

    try:
        length = job.section("identification").get("nperseg") or choose_nperseg(
            first.signal, job.data[0]["band_hz"]
        )
        whole = transmissibility(first.signal, dof, nperseg=length, estimator="rank1")
    except UnsuitableDataError:  # a single impact has no averages
        return None
    return _inside(whole, *job.data[0]["band_hz"])


def _inside(whole: FrequencyResponse, low: float, high: float) -> FrequencyResponse:
    """The band that was searched."""
    keep = (whole.freq_hz >= low) & (whole.freq_hz <= high)
    return FrequencyResponse(
        whole.freq_hz[keep], whole.values[:, keep], whole.dofs, whole.kind, whole.reference
    )

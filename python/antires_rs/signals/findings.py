"""What a data check says: findings with their numbers and advice."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from ..support.checks import FloatArray
from ..support.messages import some
from ..support.values import ReadOnly
from ..views import Viewed

Severity = Literal["fatal", "warning", "note"]
#: From the one that forbids to the one that informs.
SEVERITIES: tuple[Severity, ...] = ("fatal", "warning", "note")
BRIEFS = 4  # of a finding at many channels so many are described


@dataclass(frozen=True)
class Finding:
    """One thing seen in the data.

    Attributes
    ----------
    name : str
        Of the test: "one_force", "dead_channel", ...; see :func:`~antires_rs.check_data`.
    severity : {"fatal", "warning", "note"}
        "fatal": values identified from these data would mislead. "warning": they may be incomplete or less
        accurate. "note": worth knowing.
    where : tuple
        Dofs concerned, empty if all are.
    value, limit : float
        What was measured, and where the finding begins.
    text : str
        What was seen, with its numbers.
    advice : str
        What can be done about it.
    brief : str
        What was seen of these dofs in a few words, for a line about several of them.

    Examples
    --------
    >>> from antires_rs import Finding
    >>> seen = Finding("dead_channel", "fatal", (3,), 0.0, 0.1, "Channel 3 is constant.", "Leave it out.")
    >>> print(seen)
    fatal: Channel 3 is constant. Leave it out.
    """

    name: str
    severity: Severity
    where: tuple[Any, ...]
    value: float
    limit: float
    text: str
    advice: str
    brief: str = ""

    def __str__(self) -> str:
        return f"{self.severity}: {self.text} {self.advice}"


def one_of_a_kind(found: Iterable[Finding]) -> tuple[Finding, ...]:
    """Findings worst first, those of one kind over several channels made one."""
    kinds: dict[tuple[str, str], list[Finding]] = {}
    for finding in sorted(found, key=lambda each: SEVERITIES.index(each.severity)):
        alone = () if finding.where else (len(kinds),)  # what concerns all channels stands for itself
        kinds.setdefault((finding.name, finding.severity, *alone), []).append(finding)
    return tuple(_as_one(of_kind) for of_kind in kinds.values())


def _as_one(findings: list[Finding]) -> Finding:
    """One finding of several; its value is that farthest beyond the limit."""
    if len(findings) == 1:
        return findings[0]
    worst = max(findings, key=lambda each: abs(each.value - each.limit))
    dofs = tuple(dict.fromkeys(dof for each in findings for dof in each.where))
    said = dict.fromkeys(each.brief or each.text.rstrip(".") for each in findings)
    first = findings[:BRIEFS]
    if len(said) == 1:
        what = next(iter(said))
    else:
        what = "; ".join(f"{_listed(each.where)}: {each.brief or each.text.rstrip('.')}" for each in first)
        more = len(findings) - len(first)
        what += f"; and {more} more" if more else ""
    return replace(worst, where=dofs, text=f"Dofs {_listed(dofs)}: {what}.", brief="")


def _listed(dofs: Iterable[Any]) -> str:
    return ", ".join(str(dof) for dof in dofs)


@dataclass(frozen=True)
class NotTested:
    """A test that could not be made, and why."""

    name: str
    why: str


CheckResults = list[Finding | NotTested]  # what a test returns


def rounded(value: float) -> str:
    """Two digits, without an exponent where it can be helped."""
    return f"{float(f'{value:.2g}'):g}"


@dataclass(frozen=True, eq=False, repr=False)
class DataCheck(ReadOnly, Viewed):
    """Whether data are fit for identification, and what is wrong with them.

    Attributes
    ----------
    findings : tuple of Finding
        Worst first.
    not_tested : mapping of str to str
        Names of the tests that could not be made, and why.
    dofs : tuple
        The channels whose spectra were used: those that are not constant.
    excitation : int, str, tuple or None
        The stated dof of the force, or of several forces.
    band_hz : (low, high)
    freq_hz : (n_freq,) or None
        Lines in the band; None where the data do not allow a spectrum at all.
    eigenvalues : (n_freq, n_channels) or None
        Of the spectral matrix, largest first, with the channels scaled to equal noise: in units of the noise
        power. None for measured frequency responses.
    second_expected : (n_freq,) or None
        What noise and leakage make the second eigenvalue under one force, on average.
    coherence : (n_channels, n_freq) or None
        Highest ordinary coherence of each channel with any other; for a FrequencyResponse its own.
    n_averages : float or None
        Effective number of independent averages.
    nperseg : int or None
        Samples per segment of the spectra, where segments were used.
    n_forces : int or None
        How many uncorrelated forces stand above noise and leakage; None where that cannot be told.

    Examples
    --------
    >>> import antires_rs as ar
    >>> case = ar.cases.chain8()
    >>> checked = ar.check_data(case.experiment(noise=0.01, rng=1), excitation=0, band_hz=(3, 130))
    >>> checked.ok, checked.eigenvalues.shape[1]
    (True, 8)
    """

    findings: tuple[Finding, ...]
    not_tested: Mapping[str, str]
    dofs: tuple[Any, ...]
    excitation: Any | None
    band_hz: tuple[float, float]
    freq_hz: FloatArray | None = None
    eigenvalues: FloatArray | None = None
    second_expected: FloatArray | None = None
    coherence: FloatArray | None = None
    n_averages: float | None = None
    nperseg: int | None = None
    n_forces: int | None = None

    @property
    def ok(self) -> bool:
        """True if nothing was found beyond notes."""
        return all(finding.severity == "note" for finding in self.findings)

    @property
    def fatal(self) -> bool:
        """True if values identified from these data would mislead."""
        return any(finding.severity == "fatal" for finding in self.findings)

    @property
    def warnings(self) -> list[str]:
        """One line for each finding but notes, worst first: ``name: what was seen. advice``."""
        return [f"{f.name}: {f.text} {f.advice}" for f in self.findings if f.severity != "note"]

    @property
    def cautions(self) -> list[str]:
        """A line for each fatal finding: what is not to be trusted, all if nothing is named, and why.

        >>> import antires_rs as ar
        >>> rec = ar.cases.chain8().experiment(noise=0.01, rng=1)
        >>> ar.check_data(rec, excitation=4, band_hz=(3, 130)).cautions[0][:30]
        'do not trust the place of the '
        """
        told = []
        for f in self.findings:
            if f.severity == "fatal":
                # What is wrong with single channels leaves the others; the force has one place.
                of = " the place of the force" if f.name == "force_location" else ""
                of = of or (f" dof {some(f.where)}" if f.where else "")
                told.append(f"do not trust{of} ({f.name}): {f.text}")
        return told

    def named(self, name: str) -> tuple[Finding, ...]:
        """Findings of one test, worst first."""
        return tuple(finding for finding in self.findings if finding.name == name)

    def plot(self, ax: Any | None = None) -> Any:
        """Draw the eigenvalues of the spectral matrix by line with matplotlib; returns the axes."""
        return self._view("plot")(self, ax=ax)

    def __repr__(self) -> str:
        counts = ", ".join(f"{sum(f.severity == s for f in self.findings)} {s}" for s in SEVERITIES)
        return f"DataCheck({counts}; {len(self.not_tested)} not tested)"

    def __str__(self) -> str:
        low, high = self.band_hz
        lines = [
            f"data check, {low:g}-{high:g} Hz"
            + ("" if self.n_averages is None else f", {self.n_averages:.1f} independent averages")
        ]
        if not self.findings:
            lines.append("nothing found")
        lines += [f"{f.severity:8s} {f.name}: {f.text} {f.advice}" for f in self.findings]
        lines += [f"{'untested':8s} {name}: {why}" for name, why in self.not_tested.items()]
        return "\n".join(lines)

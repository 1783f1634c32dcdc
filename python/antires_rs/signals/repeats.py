r"""Several measurements of one test as one source: records are pooled, curves averaged.

The mean of R curves scatters by

    std^2 = sum_r abs(H_r - mean)^2 / (2 R (R - 1))

in its real and imaginary part alike; with few curves that is averaged over as many neighbouring lines as give
it some twenty degrees of freedom (of transmissibilities relative to the whole vector). FRFs are averaged as
they are. Transmissibilities have poles where their reference has an antiresonance, and a mean of quotients
follows the worst of them: the average is the dominant eigenvector of all response vectors instead, the
direction that all records agree on best.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..exceptions import Argument, reject
from ..support.checks import ComplexArray, FloatArray
from ..support.values import frozen
from .frequency_response import FrequencyResponse
from .recording import Recording
from .spectra import pooled

# Degrees of freedom that the scatter of a mean should have, a line of one curve giving two.
FREEDOM = 20.0


class AveragedResponse(FrequencyResponse):
    """The average of several curves of one test, which it holds too.

    Attributes
    ----------
    runs : (R, n, n_freq) complex
        In the order given, rows as those of ``values``.
    """

    runs: ComplexArray

    def __init__(self, runs: ComplexArray, *parts: Any, **named: Any) -> None:
        super().__init__(*parts, **named)
        object.__setattr__(self, "runs", frozen(runs))


def one_source(source: Any, name: str = "source") -> Any:
    """A list of records or of responses as one of them; anything else as it is."""
    if not isinstance(source, list | tuple):
        return source
    if not source:
        reject(name, "an empty list", "one measurement or more", "Name the records of the test.")
    kind = type(source[0]) if isinstance(source[0], FrequencyResponse) else Recording
    for i, one in enumerate(source):
        if not isinstance(one, kind):
            reject(
                Argument(name).item(i),
                type(one).__name__,
                "records, or responses, of one test: all of one kind",
                "Identify them apart.",
            )
    return pooled(source, name) if kind is Recording else averaged(source, name)


def averaged(responses: Sequence[FrequencyResponse], name: str = "source") -> FrequencyResponse:
    """The average of repeated FRFs or transmissibilities, with the scatter of that average as ``std``.

    Of two or more it is an :class:`AveragedResponse`: the scatter line by line does not hold what moves the
    whole curve of a test, a clamp that was set again, and this the runs tell.
    """
    first = responses[0]
    if len(responses) == 1:
        return first
    rows = [_as_first(first, one, Argument(name).item(i)) for i, one in enumerate(responses)]
    values = np.stack(rows)
    if first.reference is None:
        mean = np.asarray(values.mean(axis=0), dtype=np.complex128)
    else:
        mean = _direction(values, first.dofs.index(first.reference))
    size = 1.0 if first.reference is None else np.sum(np.abs(mean) ** 2, axis=0)
    std = np.sqrt(size * _smoothed(_scatter(values, mean) / size, len(values)))
    return AveragedResponse(
        values,
        first.freq_hz,
        mean,
        first.dofs,
        first.kind,
        first.reference,
        n_averages=float(len(responses)),
        std=std,
    )


def _direction(values: ComplexArray, reference: int) -> ComplexArray:
    """Dominant vector of all records' vectors by line, over its entry at the reference, (n, n_freq)."""
    vectors = values / np.linalg.norm(values, axis=1, keepdims=True)
    by_line = vectors.transpose(2, 1, 0)
    left = np.linalg.svd(by_line, full_matrices=False)[0][:, :, 0].T
    own = left[reference]
    return np.asarray(left / np.where(np.abs(own) < 1e-12, 1e-12, own), dtype=np.complex128)


def _scatter(values: ComplexArray, mean: ComplexArray) -> FloatArray:
    """Variance of the mean in its real part, (n, n_freq)."""
    count = len(values)
    return np.asarray(np.sum(np.abs(values - mean) ** 2, axis=0) / (2.0 * count * (count - 1.0)))


def _smoothed(power: FloatArray, count: int) -> FloatArray:
    """Running mean over the lines that few curves need."""
    width = min(int(np.ceil(FREEDOM / (2.0 * (count - 1.0)))), power.shape[1])
    kernel = np.ones(width)
    lines = np.convolve(np.ones(power.shape[1]), kernel, "same")
    return np.array([np.convolve(row, kernel, "same") / lines for row in power])


def _as_first(first: FrequencyResponse, one: FrequencyResponse, name: Argument) -> ComplexArray:
    """Values with their rows in the order of the first response's."""
    for what in ("kind", "reference"):
        if getattr(one, what) != getattr(first, what):
            reject(
                name,
                f"{what} {getattr(one, what)!r}",
                f"that of the first response, {getattr(first, what)!r}",
                "Average responses of one kind, to one reference.",
            )
    if one.freq_hz.shape != first.freq_hz.shape or not np.allclose(one.freq_hz, first.freq_hz, rtol=1e-9):
        reject(
            name,
            f"{one.n_freq} lines from {one.freq_hz[0]:g} to {one.freq_hz[-1]:g} Hz",
            f"the lines of the first response, {first.n_freq} from {first.freq_hz[0]:g} to "
            f"{first.freq_hz[-1]:g} Hz",
            "Estimate all with the same segments.",
        )
    if set(one.dofs) != set(first.dofs):
        reject(
            name,
            f"responses at dofs {one.dofs}",
            f"the dofs of the first response, {first.dofs}",
            "Identify setups with sensors at other places apart, and join the sets by merge_setups.",
        )
    return one.values[[one.dofs.index(dof) for dof in first.dofs]]

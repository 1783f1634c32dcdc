"""WAV files of sound cards and recorders, whole numbers or floats, through SciPy."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import reject
from ..signals.recording import Recording
from ..support.checks import real_array
from ._child import Answer, answer, room
from .channels import Channel, Dofs, Reading, stated_recording
from .child_process import Limits, channels_of_child
from .common import existing_file, unsuitable

_WANTED = "a whole WAV file (RIFF) of whole numbers or floats"


def read_wav(
    path: str | os.PathLike[str],
    *,
    full_scale: Any = None,
    responses: Any = None,
    dofs: Dofs = None,
    force: Any = "auto",
    unit: str | None = None,
    time_limit_s: float = 60.0,
    memory_limit_gb: float = 8.0,
) -> Recording:
    """Read a WAV file: 8 to 32 bit whole numbers, 32 and 64 bit floats, any number of channels.

    Parameters
    ----------
    path : path-like
    full_scale : float or sequence of float, optional
        What full scale stands for in ``unit`` (of the force: N), one number or one for each channel. Whole
        numbers are shares of full scale, -1 to 1; floats are multiplied too. 1 by default.
    responses : str or sequence of str, optional
        Names of the response channels, ``channel 1``, ``channel 2``, ...; ``*`` for any text; all by default.
    dofs : sequence, mapping or callable, optional
        Dof of each response: in order, by name, or a function of the name; None leaves one out. Default: the
        names.
    force : str or None
        Name of the force channel; "auto" and None: there is none.
    unit : str, optional
        Unit of the responses: ``'m/s2'``, ``'g'`` and the like. The format has none.
    time_limit_s, memory_limit_gb : float
        Limits of the child process that reads (the memory's where the system has such limits).

    Returns
    -------
    Recording
        In SI.

    Raises
    ------
    UnsuitableDataError
        A cut or damaged file, compressed sound.
    InvalidInputError
        Options that do not fit the file.
    FileNotFoundError
        There is none.

    Warns
    -----
    AntiresWarning
        Without ``unit``: the format has none.

    Examples
    --------
    >>> import tempfile, numpy as np, antires_rs as ar
    >>> from scipy.io import wavfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     wavfile.write(folder + "/a.wav", 8000, np.array([[0, 16384], [8192, -16384]], dtype=np.int16))
    ...     record = ar.read_wav(folder + "/a.wav", full_scale=10.0, unit="m/s2")
    >>> record.fs_hz, record.responses.tolist()
    (8000.0, [[0.0, 2.5], [5.0, -5.0]])
    """
    file, given = existing_file(path), Reading.of(locals())
    _check_length(file)
    entries, _ = channels_of_child(channels_of_wav, file, _WANTED, Limits(time_limit_s, memory_limit_gb))
    channels = [
        Channel(e["name"], e["values"] * scale, "N" if e["name"] == force else "", e["step_s"])
        for e, scale in zip(entries, _scales(full_scale, len(entries)), strict=True)
    ]
    return stated_recording(file, channels, given)


def channels_of_wav(path: str, request: dict[str, Any]) -> Answer:
    """Channels of a WAV file; whole numbers become shares of full scale."""
    import numpy as np
    from scipy.io import wavfile

    rate, values = wavfile.read(path)
    values = values[:, None] if values.ndim == 1 else values
    room(values.size, request)
    if values.dtype == np.uint8:
        values = (values.astype(np.float64) - 128.0) / 128.0
    elif values.dtype.kind == "i":
        values = values / 2.0 ** (8 * values.dtype.itemsize - 1)
    return answer(
        [
            {"name": f"channel {i + 1}", "values": np.float64(column), "unit": "", "step_s": 1.0 / rate}
            for i, column in enumerate(values.T)
        ]
    )


def _scales(full_scale: Any, count: int) -> list[float]:
    if full_scale is None:
        return [1.0] * count
    given = np.atleast_1d(
        real_array("full_scale", full_scale, ndim=None, wanted="a number, or one for each channel")
    )
    if given.size not in (1, count) or (given == 0.0).any():
        reject(
            "full_scale",
            full_scale,
            f"one number, or {count}, one for each channel, none of them 0",
            "Give what 0 dB of full scale stands for.",
        )
    return [float(x) for x in np.broadcast_to(given, count)]


def _check_length(file: Path) -> None:
    """Walk the chunks: each states its length, and the one of the samples must be whole."""
    size = file.stat().st_size
    with open(file, "rb") as opened:
        head = opened.read(12)
        if head[:4] not in (b"RIFF", b"RIFX", b"RF64") or head[8:12] != b"WAVE":
            unsuitable(file, "which has no RIFF header", _WANTED, "It is another file, or was cut.")
        order: Any = "big" if head[:4] == b"RIFX" else "little"
        at = 12
        while at + 8 <= size:
            opened.seek(at)
            chunk = opened.read(8)
            length = int.from_bytes(chunk[4:8], order)
            if chunk[:4] == b"data":
                if head[:4] != b"RF64" and at + 8 + length > size:
                    unsuitable(
                        file,
                        f"with {size - at - 8} of {length} bytes of samples",
                        _WANTED,
                        "It was cut: copy it again.",
                    )
                return
            at += 8 + length + length % 2
    unsuitable(file, "without samples (no data chunk)", _WANTED, "It was cut: copy it again.")

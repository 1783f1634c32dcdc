"""Signals of every kind that files hold, and how near two of them are."""

import numpy as np

import antires_rs as ar


def recording(*, force=True, dofs=(0, "tip", "12+Z"), n=257, fs_hz=512.0, seed=0):
    rng = np.random.default_rng(seed)
    # Six orders of magnitude, so that a format that keeps few digits is found out.
    rows = rng.standard_normal((len(dofs), n)) * 10.0 ** rng.uniform(-3, 3, (len(dofs), n))
    return ar.Recording(rows, fs_hz, dofs, rng.standard_normal(n) if force else None)


def response(
    *, kind="frf", coherence=True, averages=25.5, std=False, even=True, dofs=(0, "tip", "12+Z"), n=129, seed=0
):
    rng = np.random.default_rng(seed)
    values = rng.standard_normal((len(dofs), 2 * n)).view(np.complex128) * 10.0 ** rng.uniform(
        -3, 3, (len(dofs), n)
    )
    if kind == "transmissibility":
        values[1] = 1.0
    freq = np.arange(n) * 0.3 if even else np.cumsum(rng.uniform(0.1, 0.2, n))
    return ar.FrequencyResponse(
        freq,
        values,
        dofs,
        kind,
        dofs[1] if kind == "transmissibility" else None,
        rng.uniform(0.5, 1.0, values.shape) if coherence else None,
        averages,
        rng.uniform(0.0, 1.0, values.shape) if std else None,
    )


#: Every kind of data; names as in the table of docs/files.md.
KINDS = {
    "recording": lambda: recording(force=False),
    "recording with force": recording,
    "rate that no fraction is": lambda: recording(fs_hz=1000.0 / 7.0),
    "one channel": lambda: recording(dofs=("tip",)),
    "FRF": lambda: response(coherence=False, averages=None),
    "FRF with coherence": lambda: response(averages=None),
    "FRF with coherence and averages": response,
    "FRF on uneven lines": lambda: response(even=False),
    "transmissibility": lambda: response(kind="transmissibility"),
    "response with deviations": lambda: response(kind="transmissibility", std=True),
}


def differences(a, b):
    """Largest relative difference of each array of two signals of one class; labels must be equal."""
    assert type(a) is type(b)
    assert (a.dofs, [type(d) for d in a.dofs]) == (b.dofs, [type(d) for d in b.dofs])
    if isinstance(a, ar.Recording):
        names, plain = ("responses", "force"), ("fs_hz",)
    else:
        names, plain = ("freq_hz", "values", "coherence", "std"), ("kind", "reference", "n_averages")
    assert {n: getattr(a, n) for n in plain} == {n: getattr(b, n) for n in plain}
    found = {}
    for name in names:
        left, right = getattr(a, name), getattr(b, name)
        if left is None or right is None:
            found[name] = 0.0 if left is right else np.inf
        else:
            assert left.shape == right.shape
            assert left.dtype == right.dtype
            found[name] = float(np.max(np.abs(left - right) / np.maximum(np.abs(left), 1e-300)))
    return found

"""sdypy-EMA: least-squares complex frequency, and rational fraction polynomials by segments of the band."""

from __future__ import annotations

import numpy as np

from .method import Method, transmissibilities
from .rule import Rule

PAIRS = 40
RFP_WIDTH_HZ, RFP_ORDER = 60.0, 20


def lscf(source, highest, estimator, nperseg=1024, pairs=PAIRS):
    """All T_pj of one j in one model; its own table of poles for each order.

    Its orders count pairs, and 30 of them give too few rows for the rule: 40 find more.
    """
    from sdypy import EMA

    freq, tables = transmissibilities(source, nperseg, estimator)
    sweeps = []
    for values in tables:
        model = EMA.Model(
            frf=values,
            freq=freq,
            lower=source.low_hz,
            upper=source.high_hz,
            frf_form="receptance",
            pol_order_high=min(pairs, highest),
        )
        model.get_poles(method="lscf", show_progress=False)
        sweeps.append(model.all_poles)
    return sweeps


def rfp(source, highest, estimator, nperseg=2048, width_hz=RFP_WIDTH_HZ):
    """Windows that overlap by half, each answering for its middle half; orders of a window side by side.

    Windows of 60 Hz find twice as much as those of 30 Hz or as the whole band.
    """
    from sdypy import EMA

    freq, tables = transmissibilities(source, nperseg, estimator)
    starts = np.arange(source.low_hz, source.high_hz - width_hz / 2, width_hz / 2)
    sweeps = []
    for values in tables:
        orders = [np.zeros(0, dtype=complex)] * min(RFP_ORDER, highest)
        for start in starts:
            stop = min(start + width_hz, source.high_hz)
            inside = freq <= stop
            model = EMA.Model(
                frf=values[:, inside],
                freq=freq[inside],
                lower=start,
                upper=stop,
                frf_form="receptance",
                pol_order_high=min(RFP_ORDER, highest),
            )
            model.get_poles(method="rfp", show_progress=False)
            low = start + width_hz / 4 if start > starts[0] else source.low_hz
            high = start + 3 * width_hz / 4 if start < starts[-1] else source.high_hz
            for i, poles in enumerate(model.all_poles):
                own = np.abs(poles) / (2 * np.pi)
                orders[i] = np.concatenate([orders[i], poles[(own >= low) & (own < high)]])
        sweeps.append(orders)
    return sweeps


#: Found less false of 168: 152, by the common rule 135.
OWN = Rule(freq_tol=0.003, damping_tol=0.10, max_damping=0.02)

METHODS = (
    Method(
        "sdypy-EMA LSCF",
        "sdypy-EMA",
        "T",
        f"1-{PAIRS} pole pairs: 30 are too few orders for the rule; segments of 2 s",
        lscf,
        OWN,
    ),
    Method(
        "sdypy-EMA RFP",
        "sdypy-EMA",
        "T",
        f"orders 1-{RFP_ORDER}, its limit, in windows of {RFP_WIDTH_HZ:g} Hz; segments of 4 s",
        rfp,
    ),
)

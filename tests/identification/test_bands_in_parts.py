"""A band of so many lines that it is swept in windows: each may need other orders."""

import numpy as np

from antires_rs import stabilization
from antires_rs.identification.stabilization import Window, join


def test_windows_of_other_orders_make_one_diagram():
    """One mode below the cut, three above it."""
    freq = np.linspace(2.0, 42.0, 1600)
    modes = [(8.0, 1.0), (26.0, 0.5), (30.0, -0.7), (36.0, 0.4)]
    curve = np.abs(sum(a * f0**2 / (f0**2 - freq**2 + 0.02j * f0 * freq) for f0, a in modes))
    cut = [Window(0, 800, (2.0, 22.0), (2.0, 22.0)), Window(800, 1600, (22.0, 42.0), (22.0, 42.0))]
    parts = [
        stabilization(freq[w.first : w.last], curve[w.first : w.last], max_order=most)
        for w, most in zip(cut, (14, 22), strict=True)
    ]
    assert parts[0].orders.size < parts[1].orders.size
    for order in (parts, parts[::-1]):
        windows = cut if order is parts else cut[::-1]
        one = join(order, windows, (2.0, 42.0), 0.01)
        assert one.orders.tolist() == parts[1].orders.tolist()
        assert [f.size for f in one.freq_hz] == [s.size for s in one.stable]
        last = one.freq_hz[-1]  # an order that only the second window has
        assert last.size > 0
        assert last.min() >= 22.0
        for f0, _ in modes[1:]:
            assert min(np.abs(f / f0 - 1.0).min(initial=1.0) for f in one.freq_hz) < 5e-3

"""What speaks for an antiresonance is said as it is."""

import numpy as np
import pytest

from antires_rs.identification.selection import _table
from antires_rs.measured.response_table import ResponseTable


def roots(*hz):
    return 2 * np.pi * np.array(hz) * (-0.01 + 1j * np.sqrt(1 - 0.01**2))


def test_a_chain_a_majority_of_orders_and_the_likeliest_order_alone_have_names_of_their_own():
    chains = ResponseTable.of_sweep(
        [10.01], [0.01], [np.nan], rows=[30], spread=[1e-4], dominance=[1.0], how="chain"
    )
    zeros = roots(10.0, 20.0, 30.0)
    seen = [[], [125.0, 126.0, 127.0], []]
    ones = np.ones(3)
    table = _table(zeros, ones, 0.01 * ones, seen, np.array([False, True, False]), chains, 0.0)
    assert table.how.tolist() == ["chain", "persistent", "likeliest order"]
    assert table.rows.tolist() == [30, 3, 0]
    assert np.isnan(table.spread[2])
    assert table.freq_hz == pytest.approx([10.0, 20.0, 30.0])

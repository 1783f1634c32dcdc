"""Sets of antiresonances that are the same in all that a file keeps, beyond ``==``."""

import numpy as np


def assert_same_set(one, other):
    assert one == other
    assert (one.sees, one.channels, one.excitation) == (other.sees, other.channels, other.excitation)
    assert getattr(one.data_check, "findings", None) == getattr(other.data_check, "findings", None)
    np.testing.assert_equal(dict(one.unexplained_hz), dict(other.unexplained_hz))
    for tables, others in ((one.tables, other.tables), (one.left_out, other.left_out)):
        assert list(tables) == list(others)
        for dof, table in tables.items():
            assert table.same_as(others[dof])
            assert table.by_hand.tolist() == others[dof].by_hand.tolist()
            np.testing.assert_equal(dict(table.scores), dict(others[dof].scores))
            kinds = [[values.dtype.kind for values in each.scores.values()] for each in (table, others[dof])]
            assert kinds[0] == kinds[1]

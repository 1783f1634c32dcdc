"""Universal files as another program writes them, by pyuff."""

from types import SimpleNamespace

import numpy as np
import pytest

pyuff = pytest.importorskip("pyuff")

TIME, FREQUENCY, ACCELERATION, FORCE = 17, 18, 12, 13


USUAL = {"kind": 1, "node": 1, "direction": 3, "reference": (0, 0), "step": 1 / 512, "unit": "m/s^2"}
USUAL |= {"per": "NONE", "data_type": ACCELERATION, "binary": 1, "x": None, "even": 1}


def dataset(values, **changes):
    """A dataset 58 for pyuff to write, another program's file: as usual, but for the changes."""
    values, own = np.asarray(values), SimpleNamespace(**USUAL | changes)
    made = {"type": 58, "func_type": own.kind, "rsp_node": own.node, "rsp_dir": own.direction}
    made |= {"ref_node": own.reference[0], "ref_dir": own.reference[1], "data": values, "binary": own.binary}
    made |= {"x": np.arange(values.size) * own.step if own.x is None else own.x}
    made |= {"abscissa_spacing": own.even, "abscissa_spec_data_type": TIME if own.kind == 1 else FREQUENCY}
    made |= {"ordinate_spec_data_type": own.data_type, "ordinate_axis_units_lab": own.unit}
    return made | {"orddenom_spec_data_type": 0, "orddenom_axis_units_lab": own.per}


def written(path, *sets):
    pyuff.UFF(str(path)).write_sets(list(sets), mode="add")
    return path


NOISE = np.random.default_rng(1).standard_normal((4, 400))
LINES = np.random.default_rng(2).standard_normal((3, 200)).view(np.complex128)

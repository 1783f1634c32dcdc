"""Universal files as another program writes them, by pyuff."""

import numpy as np
import pytest

pyuff = pytest.importorskip("pyuff")

TIME, FREQUENCY, ACCELERATION, FORCE = 17, 18, 12, 13


def dataset(
    values,
    *,
    kind=1,
    node=1,
    direction=3,
    reference=(0, 0),
    step=1 / 512,
    unit="m/s^2",
    per="NONE",
    data_type=ACCELERATION,
    binary=1,
    x=None,
    even=1,
):
    """A dataset 58 for pyuff to write: another program's file."""
    values = np.asarray(values)
    return {
        "type": 58,
        "func_type": kind,
        "rsp_node": node,
        "rsp_dir": direction,
        "ref_node": reference[0],
        "ref_dir": reference[1],
        "x": np.arange(values.size) * step if x is None else x,
        "data": values,
        "binary": binary,
        "abscissa_spacing": even,
        "abscissa_spec_data_type": TIME if kind == 1 else FREQUENCY,
        "ordinate_spec_data_type": data_type,
        "ordinate_axis_units_lab": unit,
        "orddenom_spec_data_type": 0,
        "orddenom_axis_units_lab": per,
    }


def written(path, *sets):
    pyuff.UFF(str(path)).write_sets(list(sets), mode="add")
    return path


NOISE = np.random.default_rng(1).standard_normal((4, 400))
LINES = np.random.default_rng(2).standard_normal((3, 200)).view(np.complex128)

"""Published measurements, where they are there: in ANTIRES_DATA, or in shared/data beside the checkout."""

import os
from pathlib import Path

import numpy as np
import pytest

import antires_rs as ar
from tests.support.paths import ROOT

DATA = Path(os.environ.get("ANTIRES_DATA", ROOT.parent / "shared" / "data"))
SOUTHAMPTON, BRAKE_REUSS = DATA / "southampton_3storey", DATA / "brake_reuss_beam"
#: Files of the three-storey frame; the force is at the floor of the same index.
FLOORS = ("Experimental.csv", "test_2.csv", "test_3.csv")


def _needs(folder):
    return pytest.mark.skipif(not folder.is_dir(), reason=f"{folder.name} absent; set ANTIRES_DATA")


needs_southampton, needs_brake_reuss = _needs(SOUTHAMPTON), _needs(BRAKE_REUSS)
needs_plates, needs_shake_table = _needs(DATA / "iqs_plates"), _needs(DATA / "shake_table")
needs_hits = _needs(DATA / "frame3_hits")


def southampton(name):
    """FRFs of the three floors, from one file."""
    table = np.loadtxt(SOUTHAMPTON / name, delimiter=";", dtype=complex)
    return ar.FrequencyResponse(table[:, 0].real, table[:, 1:].T)

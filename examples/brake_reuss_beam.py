"""Antiresonances of the Brake-Reuss beam from one hammer impact whose force was not recorded.

Three accelerometers on a bolted, free-free beam; one impact; time histories only. The force is not needed: it
cancels in the quotients of the responses, and so do the resonances. What remains are the antiresonances.

Data: HammerImpact.mat of M. Cenedese, BRBtesting (GPL-3.0), see Jin et al., MSSP 166 (2022) 108402. The
folder that holds ``brake_reuss_beam/`` is taken from the environment variable ANTIRES_DATA, or is
../shared/data beside this repository.

Run: ``python examples/brake_reuss_beam.py``
"""

from __future__ import annotations

import os
from pathlib import Path

import antires_rs as ar


def data_file() -> Path:
    """Where the record should be."""
    beside = Path(__file__).resolve().parents[2] / "shared" / "data"
    return Path(os.environ.get("ANTIRES_DATA", beside)) / "brake_reuss_beam" / "HammerImpact.mat"


def main() -> ar.AntiresonanceSet | None:
    """From time histories to antiresonances; None where the data are absent."""
    path = data_file()
    if not path.is_file():
        print(f"The record {path} is not here. Set ANTIRES_DATA to the folder that holds brake_reuss_beam/.")
        return None
    record = ar.read_mat(path)  # three accelerometers, m/s^2 at 12.8 kHz
    print(record)
    # The impact is recognised from the energy profile; its place has no channel, so it gets a name.
    found = ar.identify_antiresonances(record, excitation="hammer", band_hz=(60.0, 1200.0))
    print(found)
    return found


if __name__ == "__main__":
    main()

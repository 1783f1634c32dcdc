"""A measured three-storey frame with one storey softened exactly, against its baseline, on a nominal chain.

The measured matrix of accelerances (``reference/measured.py``) is changed by a spring of minus 10, 25 or 40
% of the storey's measured stiffness (``reference/modified.py``); model: the frame's nominal masses and legs,
20 to 40 % too stiff. Forces at all three floors, and at one.

    python -m benchmarks.frame_baseline                   # a minute
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import warnings

import numpy as np

import antires_rs as ar
from reference.measured import structures
from reference.modified import softened

#: Stiffness of the storeys as measured, and the nominal frame.
MEASURED_N_PER_M = (36.2e3, 42.4e3, 44.2e3)
MASS_KG, STOREY_N_PER_M = 5.201, 52.5e3
#: Stiffness terms of the chain by storey: the spring to ground comes after those between masses.
TERMS = (2, 0, 1)


def identified(freq_hz, accelerance):
    """A set for each position of the force."""
    sets = []
    for force in range(3):
        curves = ar.FrequencyResponse(freq_hz, accelerance[:, :, force].T, dofs=[0, 1, 2])
        sets.append(ar.identify_antiresonances(curves, excitation=force, band_hz=(5, 32), check="off"))
    return sets


def main():
    """Print what is found."""
    warnings.simplefilter("ignore")
    columns = [s for s in structures() if s.name == "Southampton frame"]
    if len(columns) != 3:
        print("the measured frame is not here: set ANTIRES_DATA")
        return
    freq_hz = columns[0].frfs.freq_hz
    keep = (freq_hz > 3.0) & (freq_hz < 40.0)
    freq_hz = freq_hz[keep]
    accelerance = np.stack([c.frfs.values[:, keep].T for c in columns], axis=-1)
    model = ar.MassSpringChain([MASS_KG] * 3, [STOREY_N_PER_M] * 2, ground_first_n_per_m=STOREY_N_PER_M)
    before = identified(freq_hz, accelerance)
    states = [(0, 0.0), *((storey, loss) for storey in range(3) for loss in (0.10, 0.25, 0.40))]
    measured = {
        state: identified(
            freq_hz, softened(freq_hz, accelerance, state[0], state[1] * MEASURED_N_PER_M[state[0]])
        )
        for state in states
    }
    print("forces    storey  loss  found (storey: loss %)  probability of the truth  elsewhere")
    for forces in ((0, 1, 2), (0,), (1,), (2,)):
        for storey, loss in states:
            now = [measured[storey, loss][k] for k in forces]
            result = ar.assess_damage(model, now, baseline=[before[k] for k in forces], elements=list(TERMS))
            found = {TERMS.index(e) + 1: f"{100 * result.severity[e]:.1f}" for e in result.damaged}
            right = (TERMS[storey],) if loss else ()
            share = sum(h.probability for h in result.hypotheses if h.elements == right)
            words = ", ".join(f"{k}: {v}" for k, v in found.items()) or "nothing"
            print(
                f"{forces!s:9s} {storey + 1:6d}  {100 * loss:4.0f}  {words:22s}  {share:24.3f}  "
                f"{result.probability_elsewhere:9.3f}"
            )


if __name__ == "__main__":
    main()

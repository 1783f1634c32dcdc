"""Records of three masses that are identified in some 40 ms: for what is about many of them."""

import antires_rs as ar
from reference.virtual_records import chain_matrices, random_record

OPTIONS = {"excitation": 0, "band_hz": (0.8, 8.0), "max_order": 16}
MASSES, SPRINGS = [1.0, 1.2, 1.0], [500.0, 450.0]


def record(seed=0, *, duration_s=240.0):
    """Under a random force at the first mass, with 1 % noise."""
    responses, _ = random_record(
        *chain_matrices(MASSES, SPRINGS),
        fs_hz=32.0,
        duration_s=duration_s,
        noise=0.01,
        seed=seed,
        f_max_hz=14.0,
    )
    return ar.Recording(responses, 32.0)


def dead(seed=0, dofs=(1,)):
    """The same with sensors that are out."""
    made = record(seed)
    responses = made.responses.copy()
    responses[list(dofs)] = 0.0
    return ar.Recording(responses, 32.0)

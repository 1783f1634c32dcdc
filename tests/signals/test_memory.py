"""A long record is worked on a piece at a time: what is needed beside it is less than the record."""

import tracemalloc

import numpy as np

import antires_rs as ar


def record(n_samples):
    """Twelve channels of a chain under noise, all of it from one draw of the force."""
    rng = np.random.default_rng(5)
    chain = ar.MassSpringChain(
        1.0 + 0.1 * np.cos(np.arange(12.0)), np.full(11, 3e4), ground_first_n_per_m=4e4
    )
    duration = n_samples / 256.0
    return chain.simulate(
        excitation=0, fs_hz=256.0, duration_s=duration, damping_ratio=0.01, noise=0.01, rng=rng
    )


def test_averages_and_their_check_need_less_than_the_record_beside_it():
    # The fit's own memory depends on its lines and orders, not on the length of the record.
    long = record(1 << 18)
    asked = {"excitation": 0, "band_hz": (5.0, 60.0), "nperseg": 2048}
    ar.check_data(record(1 << 13), **asked)  # imports
    tracemalloc.start()
    ar.check_data(long, **asked)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # Segments from 5 to 60 of 128 Hz, half overlapping, in single precision, take 0.43 of it.
    assert peak < long.responses.nbytes

"""A year of hourly records of a structure in the weather, damaged on the way; any hour can be made alone.

The structure is an eight-mass chain whose masses and springs are within 2 % of the nominal ones (those of
``ar.cases.chain8``), which is all that an assessment may know. Temperature moves the stiffness of every
spring, by 3 % over the span of the year for the most sensitive one and by 1.8 % for the least. It is
measured with an error. Each sensor of each record is out with a probability of 2 %: dead from the beginning,
or from somewhere inside the record on. From day 300 on an element has lost 1.5 times its a90.

Records are synthesised by SciPy alone (:mod:`reference.virtual_records`).
"""

import numpy as np

import antires_rs as ar
from reference.virtual_records import (
    CHAIN8_MASSES,
    CHAIN8_SPRINGS,
    chain_matrices,
    random_record,
    true_antiresonances,
)

HOURS = 8760
FS_HZ, DURATION_S, NOISE = 512.0, 32.0, 0.01
EXCITATION, BAND_HZ = 0, (3.0, 130.0)
#: Celsius: mean, amplitude over the year and over the day, of weather that changes within days.
MEAN_C, YEAR_C, DAY_C, WEATHER_C = 10.0, 9.0, 4.0, 4.0
#: Lowest to highest of the year, over which the most sensitive spring moves by MOVED.
SPAN_C, MOVED = 36.0, 0.03
#: Standard deviation of the thermometer. It moves frequencies by 1.8e-4, the records' own errors are 7e-5.
THERMOMETER_C = 0.4
#: Of each sensor in each record.
DROPOUT = 0.02
DAMAGE_DAY, DAMAGED_ELEMENT = 300, 4
#: ar.detectability(chain8().model, excitation=0, std=2e-4, band_hz=(3, 130), rng=0).a90[4] is 0.0043.
A90 = 0.0043
SEVERITY = 1.5 * A90


def _drawn(stream, hour=None):
    """Random numbers of one purpose, the same for every year, or of one hour."""
    return np.random.default_rng([2026, stream] if hour is None else [2026, stream, hour])


def true_temperature_c(hour):
    """Of the structure, (…)-shaped as ``hour``: seasons, days, and weather of many periods."""
    hour = np.asarray(hour, dtype=float)
    day = hour / 24.0
    season = -np.cos(2 * np.pi * (day - 15.0) / 365.0)
    daily = -np.cos(2 * np.pi * (day - 4.0 / 24.0)) * (1.0 + 0.4 * season)
    rng = _drawn(0)
    periods, phases = np.geomspace(2.0, 20.0, 24), rng.uniform(0.0, 2 * np.pi, 24)
    waves = np.cos(2 * np.pi * day[..., None] / periods + phases).sum(axis=-1) * np.sqrt(2 / 24)
    return MEAN_C + YEAR_C * season + DAY_C * daily + 0.5 * WEATHER_C * waves


def structure(temperature_c, damaged):
    """Stiffness and mass matrices."""
    rng = _drawn(1)
    masses = CHAIN8_MASSES * (1.0 + 0.02 * rng.uniform(-1, 1, 8))
    springs = CHAIN8_SPRINGS * (1.0 + 0.02 * rng.uniform(-1, 1, 7))
    moved = MOVED * rng.uniform(0.6, 1.0, 7) / SPAN_C
    springs = springs * (1.0 - moved * (temperature_c - MEAN_C))
    if damaged:
        springs[DAMAGED_ELEMENT] *= 1.0 - SEVERITY
    return chain_matrices(masses, springs)


def is_damaged(hour):
    """Whether it is damaged at that hour."""
    return hour >= 24 * DAMAGE_DAY


def exact_hz(hour):
    """The true antiresonances by dof."""
    matrices = structure(true_temperature_c(hour), is_damaged(hour))
    return {dof: true_antiresonances(*matrices, dof, EXCITATION, BAND_HZ[1]) for dof in range(8)}


def dropped(hour):
    """By dof of the sensors that are out: the sample from which on there is nothing."""
    rng = _drawn(2, hour)
    out = np.flatnonzero(rng.random(8) < DROPOUT)
    count = round(DURATION_S * FS_HZ)
    return {int(dof): int(rng.choice([0, rng.integers(1, count)])) for dof in out}


def conditions_of(hour):
    """What is measured beside the record of that hour."""
    error = THERMOMETER_C * _drawn(3, hour).standard_normal()
    return {"hour": float(hour), "temperature_c": float(true_temperature_c(hour) + error)}


def hour_of_tests(hour, *, dropouts=True):
    """(Recording, conditions) of one hour of the year, 0 to 8759."""
    matrices = structure(true_temperature_c(hour), is_damaged(hour))
    responses, _ = random_record(
        *matrices,
        excitation=EXCITATION,
        fs_hz=FS_HZ,
        duration_s=DURATION_S,
        noise=NOISE,
        seed=int(_drawn(4, hour).integers(2**31)),
    )
    for dof, first in dropped(hour).items() if dropouts else ():
        responses[dof, first:] = 0.0
    return ar.Recording(responses, FS_HZ), conditions_of(hour)


def hours(chosen=range(HOURS)):
    """(name, Recording, conditions) of each hour, one at a time: sources of ``ar.identify_series``."""
    for hour in chosen:
        record, conditions = hour_of_tests(hour)
        yield f"hour {hour:04d}", record, conditions

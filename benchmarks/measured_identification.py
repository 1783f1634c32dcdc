"""Identification of measured structures against the dips that an eye finds in their curves.

The settings are the defaults everywhere. Dips, clear (12 dB within 5 %) and faint (3 dB within 3 %), are told
by ``reference/measured.py``, which knows nothing of rational functions; a value without even a
faint dip counts as false. Nothing was tuned on the frame and the beam; what was tuned on the plates is in
``identification/windows.py`` and ``identification/selection.py``.

    python -m benchmarks.measured_identification                    # all parts, some minutes
    python -m benchmarks.measured_identification --only plates
    python -m benchmarks.measured_identification --only edges --bands 20
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy

import argparse
import time
import warnings

import numpy as np
from scipy.stats import t as student

import antires_rs as ar
from reference.measured import (
    DATA,
    REFERENCE,
    STATES,
    Counted,
    Measured,
    as_transmissibilities,
    counted,
    dips_hz,
    plate,
    structures,
)

#: Values of two tests are the same antiresonance within this share.
RECURS = 0.015


def identified(source, measured, band_hz=None, **options):
    """Values with the defaults, and CPU seconds."""
    start = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ar.exceptions.AntiresWarning)
        found = ar.identify_antiresonances(
            source, excitation=measured.excitation, band_hz=band_hz or measured.band_hz, **options
        )
    return found, time.process_time() - start


def unmatched(one, other, tol=0.005):
    """(dof, Hz) of ``one`` that ``other`` lacks."""
    return [
        (dof, float(f)) for dof in one for f in one[dof] if not np.any(np.abs(other[dof] / f - 1.0) <= tol)
    ]


def plates():
    """Row 1: found, false, both kinds of input, time."""
    print("plates: found of clear dips, values without a dip; FRFs, transmissibilities; CPU s")
    total = [Counted(), Counted()]
    for state in STATES:
        measured = plate(state)
        frf, seconds = identified(measured.frfs, measured)
        other, more = identified(as_transmissibilities(measured.frfs, REFERENCE), measured)
        counts = counted(measured, frf), counted(measured, other)
        total = [a + b for a, b in zip(total, counts, strict=True)]
        extra = unmatched(other, frf)
        marked = {dof: table.freq_hz for dof, table in frf.left_out.items()}
        unmarked = [(d, f) for d, f in extra if not np.any(np.abs(marked[d] / f - 1.0) <= 0.005)]
        lost = unmatched(frf, other)
        print(
            f"{state}: {counts[0]}; {counts[1]}; {len(extra)} seen by transmissibilities only, of which not "
            f"so marked with FRFs {len(unmarked)}; lost {len(lost)}; {seconds:.1f}, {more:.1f} s"
        )
    print(f"all: {total[0]}; {total[1]}")


def presets():
    """Item 7: what presets and grades mean on the plates."""
    print("plates by preset: found of clear dips, values without a dip; by grade: values, without a dip")
    for preset in (None, "strict", "sensitive"):
        total, by_grade = Counted(), {name: [0, 0] for name in ("sure", "fair", "weak")}
        for state in STATES:
            measured = plate(state)
            found = identified(measured.frfs, measured, preset=preset)[0]
            total += counted(measured, found)
            for name, pair in by_grade.items():
                chosen = {
                    dof: table.freq_hz[table.scores["grade"] == name] for dof, table in found.tables.items()
                }
                one = counted(measured, chosen)
                pair[0] += one.values
                pair[1] += one.false
        print(f"{preset or 'default'}: {total}; {by_grade}")


def pair():
    """Row 2: two columns, the upper dip of the first."""
    print("pair (0,0)/(4,4): upper dip of (0,0) from FRFs and from transmissibilities, dips of 8 dB")
    for state in STATES:
        measured = plate(state, (0, REFERENCE))
        freq, values = measured.frfs.freq_hz, measured.frfs.values
        upper = dips_hz(freq, values[0], measured.band_hz, 8.0, 0.05)[-1]
        for source in (measured.frfs, as_transmissibilities(measured.frfs, REFERENCE)):
            found = identified(source, measured)[0]
            near = found[0][np.argmin(np.abs(found[0] - upper))]
            print(
                f"{state} {source.kind}: dip at {upper:.1f} Hz, identified {near:.2f} Hz; "
                f"{found[0].size} in all"
            )


def repeats():
    """Row 3: the intact plate tested three times."""
    sets = [identified(plate(state).frfs, plate(state))[0] for state in STATES[:3]]
    values = recurring = 0
    groups = []
    for i, one in enumerate(sets):
        others = [sets[k] for k in range(3) if k != i]
        for dof in one:
            for f, std in zip(one[dof], one.tables[dof].std_hz, strict=True):
                near = [o[dof][np.abs(o[dof] / f - 1.0) <= RECURS] for o in others]
                values += 1
                if all(n.size for n in near):
                    recurring += 1
                    if i == 2:
                        groups.append((f, *(n[np.argmin(np.abs(n - f))] for n in near), std))
    print(f"recur in both other tests within {100 * RECURS:g} %: {recurring} of {values}")
    table = np.array(groups)
    first, two = table[:, 0], table[:, 1:3]
    scatter = np.std(table[:, :3] / table[:, :3].mean(axis=1, keepdims=True), axis=1, ddof=1)
    print(
        f"scatter between tests, median {100 * np.median(scatter):.3f} %; over the stated deviation, median "
        f"{np.median(scatter * first / table[:, 3]):.1f}"
    )
    # Scatter pooled over all values: the relative difference of the two tests has twice its variance.
    relative = (two[:, 0] - two[:, 1]) / two.mean(axis=1)
    pooled = np.sqrt(np.mean(relative**2) / 2.0)
    reach = student.ppf(0.95, len(table)) * pooled * np.sqrt(1.5) * two.mean(axis=1)
    inside = np.abs(first - two.mean(axis=1)) <= reach
    print(f"90 % prediction intervals of the third test cover {inside.sum()} of {inside.size}")


def frames():
    """Row 4, first half: every structure, FRFs and transmissibilities."""
    print("frames and beam: found of clear dips (8 dB), values without a dip")
    for measured in structures():
        if measured.name == "plate":
            continue
        for source in (measured.frfs, as_transmissibilities(measured.frfs, measured.frfs.dofs[0])):
            found, seconds = identified(source, measured)
            values = {dof: found[dof].round(2).tolist() for dof in found}
            print(f"{measured.name}, {source.kind}: {counted(measured, found)}; {values}; {seconds:.1f} s")
    beam = impact()
    if beam is not None:
        found, seconds = identified(beam.frfs, beam)
        print(f"{beam.name}: { ({dof: found[dof].round(1).tolist() for dof in found}) }; {seconds:.1f} s")


def impact():
    """The single impact on the beam; None where it is absent."""
    path = DATA / "brake_reuss_beam" / "HammerImpact.mat"
    if not path.is_file():
        return None
    from scipy.io import loadmat

    data = loadmat(path, squeeze_me=True, struct_as_record=False)["HIdata"]
    record = ar.Recording([data.acc1, data.acc2, data.acc3], 12800.0, dofs=[1, 2, 3])
    return Measured("beam, one impact", record, "hammer", (60.0, 1200.0))


def edges(bands):
    """Row 4, second half: values that stay while both edges move by up to a tenth."""
    rng = np.random.default_rng(0)
    cases = [m for m in structures() if m.name != "plate"] + [m for m in (impact(),) if m is not None]
    cases += [plate(STATES[0])]
    for measured in cases:
        whole, _ = identified(measured.frfs, measured)
        stays = asked = new = 0
        for _ in range(bands):
            low, high = np.array(measured.band_hz) * (1.0 + 0.1 * rng.uniform(-1.0, 1.0, 2))
            if isinstance(measured.frfs, ar.FrequencyResponse):
                high = min(high, measured.frfs.freq_hz[-1])
            found, _ = identified(measured.frfs, measured, (float(low), float(high)))
            inside = {dof: f[(f > low) & (f < high)] for dof, f in whole.items()}
            asked += sum(f.size for f in inside.values())
            stays += sum(f.size for f in inside.values()) - len(unmatched(inside, found, 0.003))
            known = {
                dof: f[(f > measured.band_hz[0]) & (f < measured.band_hz[1])] for dof, f in found.items()
            }
            new += len(unmatched(known, whole, 0.003))
        print(
            f"{measured.name}: {stays} of {asked} stay ({100 * stays / asked:.1f} %), {new} new, "
            f"{bands} bands"
        )


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", choices=("plates", "presets", "pair", "repeats", "frames", "edges"))
    parser.add_argument("--bands", type=int, default=20)
    args = parser.parse_args()
    if not DATA.is_dir():
        print(f"no measured structures in {DATA.name}: set ANTIRES_DATA")
        return
    parts = {"plates": plates, "presets": presets, "pair": pair, "repeats": repeats, "frames": frames}
    parts["edges"] = lambda: edges(args.bands)
    for name, part in parts.items():
        if args.only in (None, name):
            part()


if __name__ == "__main__":
    main()

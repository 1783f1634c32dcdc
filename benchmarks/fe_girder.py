"""A welded plane girder of OpenSeesPy with rigid gussets, on which nothing of the library was adjusted.

The model has two Euler beams a member; what is measured has four Timoshenko beams a member, gussets
that are not rigid, chords 3 % stiffer, braces 3 % softer and a deck 2 % heavier. Used by
benchmarks/fe_cases.py; also the script that ``read_model`` runs, so that it imports only OpenSees at its top.
"""

import openseespy.opensees as ops

PANELS, PANEL_M, HEIGHT_M, GUSSET_M, E_PA = 6, 2.0, 1.6, 0.10, 2.1e11
CHORDS = [f"bottom_{k}" for k in range(1, PANELS + 1)]
BRACES = [f"brace_{k}" for k in range(1, PANELS + 1)]
CANDIDATES = [*CHORDS, *BRACES]
#: Bottom nodes are 1, 2, ..., top nodes 11, 12, ...
SENSORS = {f"deck {k}": (k, 2) for k in range(2, PANELS + 1)}
SENSORS |= {f"top {k}": (10 + k, 2) for k in (1, 3, 6)} | {"top 4 x": (14, 1), "deck 3 x": (3, 1)}
FORCE, BAND_HZ = "deck 3", (5.0, 105.0)
AREA_M2, INERTIA_M4, SHEAR_M2 = 3.0e-3, 6.0e-6, 1.4e-3


def members():
    """Name, group and nodes of each member."""
    for k in range(1, PANELS + 1):
        yield f"bottom_{k}", (k, k + 1)
        yield f"brace_{k}", (k, 10 + k)
        yield f"brace_{k}", (10 + k, k + 1)
        if k < PANELS:
            yield "top", (10 + k, 11 + k)


def build(
    bottom_1=E_PA, bottom_2=E_PA, bottom_3=E_PA, bottom_4=E_PA, bottom_5=E_PA, bottom_6=E_PA,
    brace_1=E_PA, brace_2=E_PA, brace_3=E_PA, brace_4=E_PA, brace_5=E_PA, brace_6=E_PA,
    top=E_PA, deck_kg=350.0, parts=2, measured=False,
):  # fmt: skip
    """Young's moduli of chords and of the two braces of each panel; ``parts`` elements a member."""
    moduli = dict(locals())
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    for k in range(1, PANELS + 2):
        ops.node(k, (k - 1) * PANEL_M, 0.0)
        if k <= PANELS:
            ops.node(10 + k, (k - 0.5) * PANEL_M, HEIGHT_M)
            ops.mass(10 + k, 25.0, 25.0, 0.0)
        ops.mass(k, deck_kg * (1.0 + 0.06 * k), deck_kg * (1.0 + 0.06 * k), 4.0)
    ops.fix(1, 1, 1, 0)
    ops.fix(PANELS + 1, 0, 1, 0)
    for nth, (name, (i, j)) in enumerate(members(), 1):
        ends = [complex(*ops.nodeCoord(n)) for n in (i, j)]
        along = (ends[1] - ends[0]) / abs(ends[1] - ends[0])
        length = abs(ends[1] - ends[0])
        inner = [GUSSET_M + (length - 2 * GUSSET_M) * p / parts for p in range(parts + 1)]
        stations = [0.0, *inner, length] if measured else [0.0, *inner[1:-1], length]
        chain = [i, *(100 * nth + p for p in range(1, len(stations) - 1)), j]
        for number, at in zip(chain[1:-1], stations[1:-1], strict=True):
            place = ends[0] + at * along
            ops.node(number, place.real, place.imag)
        last = len(chain) - 2
        for p in range(last + 1):
            tag, where, e = 100 * nth + p, (100 * nth + p, *chain[p : p + 2]), moduli[name]
            mass = ("-mass", 7850.0 * AREA_M2, "-cMass")
            if measured:  # gussets are stiff pieces with a mass
                e *= 30.0 if p in (0, last) else 1.0
                ops.geomTransf("Linear", tag)
                own = (e, e / 2.6, AREA_M2, INERTIA_M4, SHEAR_M2)
                ops.element("ElasticTimoshenkoBeam", *where, *own, tag, *mass)
                continue
            near, far = GUSSET_M * along * (p == 0), -GUSSET_M * along * (p == last)
            ops.geomTransf("Linear", tag, "-jntOffset", near.real, near.imag, far.real, far.imag)
            ops.element("elasticBeamColumn", *where, AREA_M2, e, INERTIA_M4, tag, *mass)


def model(folder):
    """The model with a group for each chord and pair of braces, and its dofs by the names of the sensors."""
    import antires_rs as ar

    read = ar.read_model(f"{__file__}:build", groups=[*CANDIDATES, "top"], out=folder / "girder.npz")
    return read, {name: read.dof(f"{node}:{'XY'[axis - 1]}") for name, (node, axis) in SENSORS.items()}


def record(folder, damage, seed):
    """Of the girder as it is, with factors on the moduli of damaged members."""
    import records_of_codes as codes

    import antires_rs as ar

    off = {"b": 0.97, "t": 1.03}
    values = {name: E_PA * (1.03 if name in CHORDS else off[name[0]]) for name in [*CANDIDATES, "top"]}
    values |= {name: values[name] * factor for name, factor in damage.items()}
    build(**values, deck_kg=1.02 * 350.0, parts=4, measured=True)
    squared = ops.eigen("-genBandArpack", 30)
    shapes = [[ops.nodeEigenvector(node, r + 1, axis) for node, axis in SENSORS.values()] for r in range(30)]
    modes = ar.ModalSet([value**0.5 / 6.283185307179586 for value in squared], shapes, dofs=list(SENSORS))
    return codes.record_of(modes, FORCE, seed, 240.0, 2.8 * BAND_HZ[1])


def parameters():
    """What is updated: chords and braces, each kind as one."""
    import antires_rs as ar

    return [
        ar.stiffness_factor(kind, bounds=(0.8, 1.25), together=True) for kind in (CHORDS, BRACES, ["top"])
    ]

"""Frame matrices against an independent finite-element package, PyNiteFEA (row 2).

Skipped where it is not installed; it is in the dependency group "test". Both sides have
the consistent mass of Euler-Bernoulli beams; PyNiteFEA takes the torsion constant for the polar moment, so
the sections here have both alike, as tubes do.
"""

import numpy as np
import pytest
import scipy.linalg

import antires_rs as ar
from tests.support.tolerances import FRAME_PACKAGE_ENTRIES, FRAME_PACKAGE_HZ

pynite = pytest.importorskip("Pynite", reason="PyNiteFEA is not installed")

E, NU, RHO = 2.1e11, 0.3, 7850.0
#: A, I_y, I_z (m2, m4) by name; the torsion constant is their sum.
SECTIONS = {"pipe": (1.72e-4, 2.87e-8, 2.87e-8), "beam": (9.0e-4, 1.2e-7, 3.1e-7)}
PLANE = "0 0  0 0.9  0.7 1.2  1.5 1.2  1.9 0.8  1.9 0  0.4 1.7  2.3 1.4"
SPACE = "0 0 0  1.2 0.1 0  1.2 0 1.5  0 0 1.4  0 1 0  1.1 1.1 0.2  1.2 1 1.5  0.1 0.9 1.3  0.6 1.6 0.7"
PLANE_NODES = np.array(PLANE.split(), dtype=float).reshape(-1, 2)
SPACE_NODES = np.array(SPACE.split(), dtype=float).reshape(-1, 3)


def elements(beams, pipes):
    sections = [(beams, "beam"), (pipes, "pipe")]
    return [(int(a), int(b), section) for pairs, section in sections for a, b in pairs.split()]


PLANE_ELEMENTS = elements("01 45 37", "12 23 34 26")
SPACE_ELEMENTS = elements("04 15 26 37 56 74", "45 67 48 68")
MASS_NODE, MASS_KG = 2, 3.4


def theirs(nodes, elements, fixed):
    """K and M of the free dofs by PyNiteFEA; nodes in space, its y axis is up."""
    model = pynite.FEModel3D()
    model.add_material("steel", E, E / (2 * (1 + NU)), NU, RHO)
    for name, (area, i_y, i_z) in SECTIONS.items():
        model.add_section(name, area, i_y, i_z, i_y + i_z)
    for i, node in enumerate(nodes):
        model.add_node(f"N{i}", *node)
    for i, (a, b, section) in enumerate(elements):
        model.add_member(f"M{i}", f"N{a}", f"N{b}", "steel", section)
    model.add_member_self_weight("FY", -1.0, "mass")
    model.add_node_load(f"N{MASS_NODE}", "FY", MASS_KG, "mass")
    model.add_load_combo("mass", {"mass": 1.0})
    from Pynite.Analysis import _prepare_model

    _prepare_model(model)
    order = [6 * model.nodes[f"N{i}"].ID + d for i in range(len(nodes)) for d in range(6)]
    free = [order[6 * i + d] for i in range(len(nodes)) for d in range(6) if (i, d) not in fixed]
    stiffness = model.Ke("mass", check_stability=False, sparse=False)
    return [np.asarray(a)[np.ix_(free, free)] for a in (stiffness, model.M("mass", "Y", 1.0, sparse=False))]


def upright(nodes, elements):
    """The reference direction that PyNiteFEA takes: global y, and -x or x for elements along it."""
    rows = []
    for a, b, _ in elements:
        along = np.subtract(nodes[b], nodes[a])
        rows.append((-np.sign(along[1]), 0.0, 0.0) if np.allclose(along[[0, 2]], 0.0) else (0.0, 1.0, 0.0))
    return rows


def ours(nodes, elements, fixed, **options):
    sections = {
        name: ar.Section(area, i_z, E, RHO, inertia_y_m4=i_y, torsion_m4=i_y + i_z, poisson=NU)
        for name, (area, i_y, i_z) in SECTIONS.items()
    }
    masses = [ar.PointMass(MASS_NODE, MASS_KG)]
    return ar.FrameModel(nodes, elements, sections, fixed=fixed, point_masses=masses, **options)


@pytest.mark.parametrize("space", [False, True])
def test_a_frame_has_the_matrices_and_frequencies_of_pynite(space):
    if space:
        nodes, elements, feet, out_of_plane = SPACE_NODES, SPACE_ELEMENTS, [0, 1, 2, 3], set()
        model = ours(nodes, elements, feet, orientation=upright(nodes, elements))
    else:
        nodes, elements, feet = np.c_[PLANE_NODES, np.zeros(len(PLANE_NODES))], PLANE_ELEMENTS, [0, 5]
        out_of_plane = {(node, d) for node in range(len(nodes)) for d in (2, 3, 4)}
        model = ours(PLANE_NODES, elements, feet)
    stiffness, mass = theirs(nodes, elements, out_of_plane | {(node, d) for node in feet for d in range(6)})
    for own, other in ((model.stiffness(), stiffness), (model.mass(), mass)):
        assert np.abs(own - other).max() < FRAME_PACKAGE_ENTRIES * np.abs(other).max()
    reference = np.sqrt(scipy.linalg.eigh(stiffness, mass, eigvals_only=True)[:10]) / (2 * np.pi)
    np.testing.assert_allclose(model.modes(10).freq_hz, reference, rtol=FRAME_PACKAGE_HZ)

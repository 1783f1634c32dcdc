"""Meshes and groups of terms: what does not fit is refused where it is given."""

from functools import partial

import numpy as np
import pytest

import antires_rs as ar
from tests.support.refusals import refused

PLACES = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
QUAD = {"nodes": np.arange(1, 5), "coordinates": PLACES, "elements": np.array([7]), "kinds": ("S4",)}
QUAD |= {"connectivity": np.array([[1, 2, 3, 4]]), "kind": np.array([0])}
SPRING = np.eye(2)


def group(name="web", term=0):
    return ar.TermGroup(name, "density", 1.0, ((term, 1),))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"nodes": np.array([1, 2, 3, 3])}, "nodes: got 3 twice"),
        ({"nodes": [1.5, 2.0, 3.0, 4.0]}, "nodes: got an array"),
        ({"nodes": np.array([-1, 2, 3, 4])}, "nodes: got node -1"),
        ({"coordinates": PLACES[:, :2]}, "coordinates: got an array of shape"),
        ({"coordinates": PLACES * np.nan}, "coordinates: got 12 NaN"),
        ({"connectivity": np.array([[1, 2, 3, 9]])}, "connectivity: got node 9"),
        ({"connectivity": np.array([1, 2])}, "connectivity: got an array of shape"),
        ({"connectivity": np.array([[1, -1, 3, 4]])}, "connectivity: got .* of element 7"),
        ({"connectivity": np.array([[-1, -1, -1, -1]])}, "connectivity: got .* of element 7"),
        ({"kind": np.array([1])}, "kind: got"),
        ({"kinds": "S4"}, "kind: got"),
    ],
)
def test_a_mesh_that_does_not_fit_is_refused(given, said):
    assert ar.Mesh(**QUAD).place(2).tolist() == [1.0, 0.0, 0.0]
    refused(said, ar.Mesh, **QUAD | given)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("", "density", 1.0), "name: got ''"),
        (("web", "mass", 1.0), "quantity: got 'mass'"),
        (("web", "density", np.nan), "value: got"),
        (("web", "density", 1.0, ((0, 1), (0, 2))), "stiffness_powers: got"),
        (("web", "density", 1.0, (0, 1)), "stiffness_powers: got"),
        (("web", "density", 1.0, (), ((-1, 1),)), r"mass_powers\[0\]: got -1"),
        (("web", "density", 1.0, ((0, 0.5),)), r"stiffness_powers\[0\]: got 0.5"),
        (("web", "density", 1.0, (), (), np.array([3, 3])), "elements: got 3 twice"),
    ],
)
def test_a_group_that_cannot_be_is_refused(given, said):
    refused(said, ar.TermGroup, *given)


def test_groups_have_terms_of_the_model_and_names_of_their_own():
    made = partial(ar.MatrixModel, SPRING, SPRING, stiffness_terms=[SPRING, SPRING])
    of_mass = ar.TermGroup("web", "density", 1.0, (), ((0, 1),))
    assert list(made(groups=[group()]).groups) == ["web"]
    refused("'web'.: got stiffness term 2", made, groups=[group(term=2)])
    refused("'web'.: got mass term 0", made, groups=[of_mass])
    refused("a second 'web'", made, groups=[group(), group(term=1)])
    refused("'skin'.: got stiffness term 0, which 'web' has too", made, groups=[group(), group("skin")])
    refused("groups.1.: got int", made, groups=[group(), 3])
    refused("mesh: got int", made, mesh=3)

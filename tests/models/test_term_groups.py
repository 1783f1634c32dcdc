"""Meshes and groups of terms: what does not fit is refused where it is given."""

import numpy as np
import pytest

import antires_rs as ar

QUAD = {
    "nodes": np.arange(1, 5),
    "coordinates": np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]),
    "elements": np.array([7]),
    "connectivity": np.array([[1, 2, 3, 4]]),
    "kinds": ("S4",),
    "kind": np.array([0]),
}
SPRING = np.eye(2)


def group(name="web", term=0):
    return ar.TermGroup(name, "density", 1.0, ((term, 1),))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"nodes": np.array([1, 2, 3, 3])}, "nodes: got 3 twice"),
        ({"nodes": [1.5, 2.0, 3.0, 4.0]}, "nodes: got an array"),
        ({"nodes": np.array([-1, 2, 3, 4])}, "nodes: got node -1"),
        ({"coordinates": QUAD["coordinates"][:, :2]}, "coordinates: got an array of shape"),
        ({"coordinates": QUAD["coordinates"] * np.nan}, "coordinates: got 12 NaN"),
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
    with pytest.raises(ar.InvalidInputError, match=said):
        ar.Mesh(**(QUAD | given))


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
    with pytest.raises(ar.InvalidInputError, match=said):
        ar.TermGroup(*given)


@pytest.mark.parametrize(
    ("groups", "said"),
    [
        ([group(term=2)], "'web'.: got stiffness term 2"),
        ([ar.TermGroup("web", "density", 1.0, (), ((0, 1),))], "'web'.: got mass term 0"),
        ([group(), group(term=1)], "a second 'web'"),
        ([group(), group("skin")], "'skin'.: got stiffness term 0, which 'web' has too"),
        ([group(), 3], "groups.1.: got int"),
    ],
)
def test_groups_have_terms_of_the_model_and_names_of_their_own(groups, said):
    terms = {"stiffness_terms": [SPRING, SPRING]}
    assert list(ar.MatrixModel(SPRING, SPRING, groups=[group()], **terms).groups) == ["web"]
    with pytest.raises(ar.InvalidInputError, match=said):
        ar.MatrixModel(SPRING, SPRING, groups=groups, **terms)
    with pytest.raises(ar.InvalidInputError, match="mesh: got int"):
        ar.MatrixModel(SPRING, SPRING, mesh=3)

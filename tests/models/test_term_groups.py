"""Meshes and groups of terms: what does not fit is refused where it is given."""

import numpy as np

import antires_rs as ar
from tests.support.snapshots import refusals

PLACES = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
QUAD = {"nodes": np.arange(1, 5), "coordinates": PLACES, "elements": np.array([7]), "kinds": ("S4",)}
QUAD |= {"connectivity": np.array([[1, 2, 3, 4]]), "kind": np.array([0])}
SPRING = np.eye(2)
OF_MASS = ar.TermGroup("web", "density", 1.0, (), ((0, 1),))


def mesh(**given):
    return ar.Mesh(**QUAD | given)


def group(*given):
    return ar.TermGroup(*given)


def web(name="web", term=0):
    return ar.TermGroup(name, "density", 1.0, ((term, 1),))


def model(**given):
    return ar.MatrixModel(SPRING, SPRING, stiffness_terms=[SPRING, SPRING], **given)


def test_what_does_not_fit_is_refused():
    assert ar.Mesh(**QUAD).place(2).tolist() == [1.0, 0.0, 0.0]
    assert list(model(groups=[web()]).groups) == ["web"]
    refusals(__file__, "wrong_groups.txt", globals())

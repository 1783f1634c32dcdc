"""Dofs with next to no mass are as those without: little rotary inertia moves no root."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp

import antires_rs as ar
from reference.meshes import MESHES, frame, lumped


def condensed_zeros_hz(stiffness, mass, dof):
    """Zeros of H at ``dof`` with the massless dofs condensed: eigenvalues with the dof held."""
    k, m = stiffness.toarray(), mass.diagonal()
    kept = [i for i in np.flatnonzero(m > 0) if i != dof]
    rest = np.flatnonzero(m == 0)
    own = k[np.ix_(kept, kept)] - k[np.ix_(kept, rest)] @ np.linalg.solve(
        k[np.ix_(rest, rest)], k[np.ix_(rest, kept)]
    )
    return np.sqrt(scipy.linalg.eigh(own, np.diag(m[kept]), eigvals_only=True)) / (2 * np.pi)


@pytest.mark.parametrize(("kind", "n_dof"), [("tower", 300), ("grillage", 200), ("lattice", 300)])
@pytest.mark.parametrize("rotary", [0.0, 1e-14, 1e-11, 1e-9, 1e-8, 1e-7])
def test_roots_do_not_hang_on_how_little_it_is(kind, n_dof, rotary):
    mesh = frame(MESHES[kind](n_dof))
    stiffness, mass = sp.csc_array(mesh.stiffness()), lumped(mesh.mass())
    none = mass.diagonal() == 0
    dof = int(np.flatnonzero(~none)[0])
    exact = condensed_zeros_hz(stiffness, mass, dof)
    wanted = exact[:20]
    model = ar.MatrixModel(stiffness, mass + sp.diags_array(np.where(none, rotary, 0.0)))
    found = model.antiresonances(dof, dof, f_max_hz=0.5 * (exact[19] + exact[20]))
    assert len(found) == len(wanted)
    # The inertia itself moves them by its share of the rotations' stiffness.
    np.testing.assert_allclose(found, wanted, rtol=1e-8 + 10.0 * rotary)

"""A solid block of hexahedra by scikit-fem: three dofs a node, each joined to 81."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

#: Young's modulus (Pa), Poisson's ratio and density (kg/m3) of steel; edges of the block, m, all unlike.
STEEL_PA, POISSON, STEEL_KG_PER_M3 = 2.1e11, 0.3, 7850.0
EDGES_M = (1.0, 0.83, 0.24)


def block(n_dof: int) -> tuple[Any, Any]:
    """Stiffness and mass of the free dofs of a thick plate, clamped along one edge face."""
    from skfem import Basis, BilinearForm, ElementHex1, ElementVector, MeshHex
    from skfem.helpers import dot
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    size = (n_dof / 3 * EDGES_M[0] ** 2 / (EDGES_M[1] * EDGES_M[2])) ** (1 / 3) / EDGES_M[0]
    counts = [max(2, round(size * edge)) for edge in EDGES_M]
    axes = [np.linspace(0.0, edge, count + 1) for edge, count in zip(EDGES_M, counts, strict=True)]
    mesh = MeshHex.init_tensor(*axes)
    # Moved by up to 3 % of a cell, so that the block has no plane of symmetry.
    moved = 0.03 * np.sin(1.7 * np.arange(mesh.p.size).reshape(mesh.p.shape) + 0.3)
    moved[0, mesh.p[0] < 1e-9] = 0.0
    mesh = MeshHex(
        mesh.p + moved * [[edge / count] for edge, count in zip(EDGES_M, counts, strict=True)], mesh.t
    )
    basis = Basis(mesh, ElementVector(ElementHex1()))
    stiffness = linear_elasticity(*lame_parameters(STEEL_PA, POISSON)).assemble(basis)
    mass = STEEL_KG_PER_M3 * BilinearForm(lambda u, v, _: dot(u, v)).assemble(basis)
    held = basis.get_dofs(lambda x: x[0] < 1e-9).flatten()
    free = np.setdiff1d(np.arange(basis.N), held)
    # Assembly leaves the two triangles apart by rounding.
    whole = [sp.csr_array(a)[free][:, free] for a in (stiffness, mass)]
    k, m = (sp.csc_array(0.5 * (a + a.T)) for a in whole)
    return k, m

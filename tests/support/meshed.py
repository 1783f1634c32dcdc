"""The eight-mass chain as matrices with a mesh, as a finite-element code would give it."""

import numpy as np

import antires_rs as ar


def meshed_chain(name="spring {}"):
    """Masses in a row in space, a line element and a group for each spring."""
    chain = ar.cases.chain8().model
    k, n = chain.stiffness(), chain.n_dof
    terms, groups = {}, []
    for i in range(n - 1):
        own = np.zeros((n, n))
        own[i : i + 2, i : i + 2] = -k[i, i + 1] * np.array([[1.0, -1.0], [-1.0, 1.0]])
        called = name.format(i)
        terms[called] = own
        groups.append(ar.TermGroup(called, "youngs_modulus", 1.0, ((i, 1),), (), np.array([10 + i])))
    places = np.column_stack([np.arange(n), 0.3 * np.arange(n) ** 1.5, np.zeros(n)])
    ends = np.column_stack([np.arange(1, n), np.arange(2, n + 1)])
    mesh = ar.Mesh(
        np.arange(1, n + 1), places, 10 + np.arange(n - 1), ends, ("T3D2",), np.zeros(n - 1, dtype=int)
    )
    dofs = [f"{i + 1}:Z" for i in range(n)]
    return ar.MatrixModel(k, chain.mass(), stiffness_terms=terms, groups=groups, mesh=mesh, dofs=dofs)

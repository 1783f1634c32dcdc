r"""Structural models: stiffness and mass, what may change in them, and virtual tests.

.. math:: K(p)\,\varphi = \omega^2 M(p)\,\varphi, \qquad \det(K_{ik} - \omega_A^2 M_{ik}) = 0

where row i and column k are deleted in the second: its roots are the antiresonances of :math:`H_{ik}`.
Chains, frames, and matrices of other programs; only the virtual test makes a record, none is read.

Reference: W. D'Ambrogio and A. Fregolent, J. Sound Vib. 236 (2000) 227-243.
"""

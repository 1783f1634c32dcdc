r"""Structural models: stiffness and mass, what may change in them, and virtual tests.

Knows chains, frames, matrices of other programs and their parameters. Uses ``support``, the Rust core, and
``measured.modal_set`` for modes; never a record, but for ``simulation``, which makes one.

.. math:: K(p)\,\varphi = \omega^2 M(p)\,\varphi, \qquad \det(K_{ik} - \omega_A^2 M_{ik}) = 0

where row i and column k are deleted in the second: its roots are the antiresonances of :math:`H_{ik}`.

Reference: W. D'Ambrogio and A. Fregolent, J. Sound Vib. 236 (2000) 227-243.
"""

r"""Rational functions of frequency: fitted, evaluated, their poles and zeros found.

Knows curves and polynomials only, neither records nor stabilization. Uses ``signals`` (the check of a
frequency axis) and ``support``.

.. math:: H(s) = \frac{\sum_k a_k P_k(s)}{\sum_k b_k Q_k(s)}

with P and Q orthogonal on the lines (Forsythe), so that the normal equations are well conditioned at any
order. ``vector_fitting`` and ``aaa`` are the independent methods of the cross-check.

References: M. H. Richardson and D. L. Formenti, Proc. IMAC 1 (1982) 167-181; B. Gustavsen and A. Semlyen,
IEEE Trans. Power Delivery 14 (1999) 1052-1061; Y. Nakatsukasa, O. Sete and L. N. Trefethen, SIAM J. Sci.
Comput. 40 (2018) A1494-A1522.
"""

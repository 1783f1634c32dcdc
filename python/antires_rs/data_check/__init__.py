r"""Data check: what measured data can bear, and what is wrong with them, before anything is fitted.

Knows what one force does to a spectral matrix and what faulty channels do to it. Uses ``signals`` and
``support``; it fits nothing and never sees a model. A file holds one family of tests, ``check`` their order.

Under one force the matrix of all responses has rank one but for noise,

.. math:: S(\omega) = S_{FF}\, H_k H_k^* + N, \qquad \lambda_2 / \lambda_1 \ll 1

and at the driving point the zeros of :math:`H_{kk}` and the poles alternate.

Reference: J. S. Bendat and A. G. Piersol, Random Data, 4th ed., 2010.
"""

from .check import check_data
from .findings import DataCheck, Finding

__all__ = ["DataCheck", "Finding", "check_data"]

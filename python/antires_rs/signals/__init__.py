r"""Records, spectra and what can be estimated from them line by line.

Knows recordings, frequency responses, Welch spectra, impacts, the noise of channels. Uses ``support``; never
a rational function, never a model.

With the spectral matrix :math:`S_{ab} = \overline{A^* B}` of the responses, the transmissibility of p to j is

.. math:: T_{pj} = X_p / X_j = H_{pk} / H_{jk}

by H1 :math:`S_{jp}/S_{jj}`, H2 :math:`S_{pp}/S_{pj}`, Hv (total least squares on the pair) or the dominant
eigenvector of the whole matrix ("rank1").

References: P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70-73; J. S. Bendat and A. G. Piersol,
Random Data, 4th ed., 2010.
"""

from .data_check import check_data
from .one_force import DataCheck, Finding

# -- Data check: what measured data can bear, and what is wrong with them, before anything is fitted
#
# Knows what one force does to a spectral matrix and what faulty channels do to it. Uses ``signals`` and
# ``support``; it fits nothing and never sees a model. A file holds one family of tests, ``check`` their
# order.
#
# Under one force the matrix of all responses has rank one but for noise,
#
# .. math:: S(\omega) = S_{FF}\, H_k H_k^* + N, \qquad \lambda_2 / \lambda_1 \ll 1
#
# and at the driving point the zeros of :math:`H_{kk}` and the poles alternate.
#
# Reference: J. S. Bendat and A. G. Piersol, Random Data, 4th ed., 2010.


__all__ = ["DataCheck", "Finding", "check_data"]

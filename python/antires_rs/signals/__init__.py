r"""Records, spectra, and whether the data are fit for identification.

With the spectral matrix :math:`S_{ab} = \overline{A^* B}` of the responses, the transmissibility of p to j is

.. math:: T_{pj} = X_p / X_j = H_{pk} / H_{jk}

by H1 :math:`S_{jp}/S_{jj}`, H2 :math:`S_{pp}/S_{pj}`, Hv (total least squares on the pair) or the dominant
eigenvector of the whole matrix ("rank1"). Under one force that matrix has rank one but for noise, which is
what the data check asks first:

.. math:: S(\omega) = S_{FF}\, H_k H_k^* + N, \qquad \lambda_2 / \lambda_1 \ll 1

References: P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70-73; J. S. Bendat and A. G. Piersol,
Random Data, 4th ed., 2010.
"""

from .data_check import check_data
from .one_force import DataCheck, Finding

__all__ = ["DataCheck", "Finding", "check_data"]

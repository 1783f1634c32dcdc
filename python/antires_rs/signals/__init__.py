r"""Records, spectra, and whether the data are fit for identification.

Under one force the matrix of all spectra has rank one but for noise, which the data check asks first:

.. math:: S(\omega) = S_{FF}\, H_k H_k^* + N, \qquad \lambda_2 / \lambda_1 \ll 1
"""

from .data_check import check_data
from .findings import DataCheck, Finding

__all__ = ["DataCheck", "Finding", "check_data"]

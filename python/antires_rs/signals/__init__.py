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

r"""Fits of all numerators over many overlapping windows, and what most of them see.

A measured curve is not a rational function plus white noise: resonances move a little between the tests that
make up a set of FRFs, leakage ripples around sharp peaks, joints slip. One fit of a whole band spends its
orders on that, and its roots hang on the edges of the band. Over a window of a fifth to a half of the
frequency the same curves are nearly exact, so the band is covered by overlapping windows whose places do not
depend on it (:mod:`.grid`); in each the likeliest numerators are fitted, the order following from the data
(:mod:`.fit`); a root counts where the fitted curve has a visible dip (:mod:`.sightings`); and an
antiresonance is what most of the fits that could see it do see (:mod:`.consensus`).

References: L. Breiman, Machine Learning 24 (1996) 123-140 (estimates by repetition over parts of the data);
the fit itself as in :mod:`~antires_rs.identification.numerators`.
"""

r"""From records or measured curves to antiresonances, and to modes.

Knows how the responses at a line hang together; uses ``data_check``, ``measured``, ``order_sweep``,
``rational``, ``signals`` and ``support``; never a model.

Under one force at k all responses are :math:`X_p = N_{pk} F / D`: the zeros of the numerators are the
antiresonances, and they are the poles of every :math:`T_{pj} = N_{pk} / N_{jk}`.

- ``identify``: the public call and its one pass: spectra, check, fit, selection, set
- ``numerators``, ``likelihood``, ``selection``, ``uncertainty``: all numerators in one fit, for averaged
  records
- ``formulations``, ``power``: a fit for each response, for impacts and given curves
- ``cross_check``: the same antiresonances by an independent method
- ``modes``: resonances and shapes

Reference: V. Meruane, J. Sound Vib. 332 (2013) 807-820, section 3.
"""

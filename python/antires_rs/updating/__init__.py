r"""Model updating and damage assessment: models, measured values and the search meet here.

Knows the objective, what came out, and what the data do not tell. Uses ``models``, ``measured``, ``optimize``
and ``support``; never a record or a spectrum.

.. math:: J = \sum \left|\frac{\omega_A^2}{\omega_E^2} - 1\right|
          + \gamma_1 \sum \beta_i + \gamma_2\,\mathrm{count}(\beta_i > 0)

with A analytic and E measured, and damage :math:`K_d = \sum (1 - \beta_i) K_i`.

- ``problem``: model, unknowns, measured values; ``targets`` and ``weights`` of the residuals; ``penalty`` of
  damage
- ``search``, ``damage``: the two public calls
- ``results``, ``tables``, ``identifiability``: what came out

Reference: V. Meruane, J. Sound Vib. 332 (2013) 807-820, Eqs. 11-18.
"""

r"""Model updating: models, measured values and the search meet here.

.. math:: J = \sum \left|\frac{\omega_A^2}{\omega_E^2} - 1\right|
          + \gamma_1 \sum \beta_i + \gamma_2\,\mathrm{count}(\beta_i > 0)

with A analytic and E measured, and damage :math:`K_d = \sum (1 - \beta_i) K_i`. ``problem`` states
it, ``update`` is the call; what the data tell about the parameters, and what not, stands beside the result.

Reference: V. Meruane, J. Sound Vib. 332 (2013) 807-820, Eqs. 11-18.
"""

r"""Damage against a baseline, quickly: all that does not depend on the new test is prepared.

Knows: tables of the model's antiresonances over the severity of each element, between which they are
interpolated; which sets of elements a new test is judged by. Uses: ``damage``, whose likelihood and evidence
these are. With :math:`u = -\ln(1 - \beta)`, the antiresonances at several severities are

.. math:: \ln r(u) = \ln r(0) + \sum_e [\ln r(u_e) - \ln r(0)] + \sum_{a<b} I_{ab}(u_a, u_b),

with I, the part that two severities have in common, from their sensitivities at each other's severities. The
antiresonances of the answer are computed exactly and compared.
"""

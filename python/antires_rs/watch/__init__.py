r"""A structure watched over many tests: which differ from the baseline, at a stated rate of false alarms.

The logarithms y of a test's antiresonances follow

.. math:: y_t = B g(c_t) + e_t, \qquad e_t \sim (0, D^{1/2} R D^{1/2}),

with the conditions c (temperature), a basis g that the baseline supports, and the scatter from test to test.
B, D and R are learned from the baseline; limits of the charts come from baseline tests left out in turn. A
series holds the tests, in order; sensors that fail are told from damage.
"""

r"""Before a test: where to measure and to shake, and which damage the test would show.

An antiresonance of response i is a value with d ln f / d beta = a, known with the relative standard deviation
sigma. A test of the sensors S, intact and later, tells of the severities

.. math:: I(S) = \sum_{i \in S} \sum_m \frac{w_m a_m a_m^T}{2 \sigma_m^2},

w being 0 for roots that transmissibilities do not show because all of S share them. ``placement`` looks for
the S of most information; ``detectability`` says how probably each severity would be found.

Uses: damage, updating, models, measured, optimize, support, the core.
"""

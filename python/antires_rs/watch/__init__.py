r"""A structure watched over many tests: which of them differ from the baseline, at a stated rate of false
alarms.

The logarithms y of a test's antiresonances follow

.. math:: y_t = B g(c_t) + e_t, \qquad e_t \sim (0, D^{1/2} R D^{1/2}),

with the conditions c (temperature), a basis g that the baseline supports, and the scatter from test to test.
B, D and R are learned from the baseline; limits of the charts come from baseline tests left out in turn.

- ``association``: which antiresonance of a test is which of the baseline
- ``regression``, ``basis``: values on conditions; ``normal`` (variances, tails), ``correlation``: their
  scatter
- ``learned`` holds them, ``nuisance`` is what may be added for conditions out of range or not known
- ``distance`` (Hotelling), ``ewma``, ``events`` (values that vanish or appear) are the charts, ``limits``
  their limits
- ``faults``: sensors told from damage; ``runs``: damage assessed where alarms stand together
- ``monitor`` is the call, ``watched`` its answer

Uses: series, damage, measured, models, support. The signal side knows nothing of it.
"""

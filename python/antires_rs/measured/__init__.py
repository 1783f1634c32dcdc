"""What a test gave: antiresonances by response, or resonances with their shapes.

The values in which the signal side and the models meet: identification makes them, updating takes them. Knows
tables, edits by hand and their file. Uses ``order_sweep`` (the columns of what was accepted) and ``support``;
it knows no record and no structure.

- ``antiresonance_set``: :math:`\\omega_A` of every H_jk under one force at k
- ``modal_set``: resonances, damping ratios, shapes
"""

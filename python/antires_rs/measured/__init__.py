"""What a test gave: antiresonances by response, or resonances with their shapes.

The values in which the signal side and the models meet: identification makes them, updating takes them. Knows
tables, edits by hand and their file. Uses ``order_sweep`` (the table of what was accepted) and ``support``;
it knows no record and no structure.

- ``antiresonance_set``: :math:`\\omega_A` of every H_jk under one force at k, one ``ResponseTable`` for each j; on
  ``response_tables`` (the mapping and its columns), ``edited_tables`` and ``edits`` (what a person dropped and
  added), ``tables`` (what a caller gives, checked), ``set_file`` (JSON), ``evidence`` (what it asks of its checks)
- ``modal_set``: resonances, damping ratios, shapes
"""

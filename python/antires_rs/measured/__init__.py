"""What a test gave: antiresonances by response, or resonances with their shapes.

The values in which the signal side and the models meet: identification makes them, updating takes them. Knows
tables, edits by hand and their file. Uses ``order_sweep`` (the table of what was accepted) and ``support``;
it knows no record and no structure.

- ``antiresonance_set``: :math:`\\omega_A` of every H_jk under one force at k, a ``ResponseTable`` for each j
- ``response_tables``, ``edited_tables``: what it stands on, the mapping with its columns, and edits on record
- ``tables``, ``edits``, ``set_file``, ``evidence``: what a caller gives, checked; a drop or add; its JSON;
  what a set asks of its data check and cross-check
- ``compare``, ``track`` with ``tracks``, ``merge`` with ``joined``: several sets; on ``matching``, who is
  whose partner, ``significance``, is it more than the errors, ``repeatability``, the scatter of repeats, and
  ``layout``, tables as text
- ``modal_set``: resonances, damping ratios, shapes
"""

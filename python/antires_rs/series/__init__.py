"""Many tests of one structure, in order: their antiresonances, names and conditions.

Knows the order of the tests and what is kept of each; uses ``io``, ``identification``, ``measured`` and
``support``; never a model.

- ``series``: the value, :class:`antires_rs.Series`, on ``kept_tests``; in words ``printed``, in rows
  ``frames``
- ``conditions``: what was measured beside the tests, in any table, as arrays in their order
- ``kept``: what is kept of a test
"""

"""Many tests of one structure, in order: their antiresonances, names and conditions.

Knows the order of the tests and what is kept of each; uses ``io``, ``identification``, ``measured`` and
``support``; never a model.

- ``series``: the value, :class:`antires_rs.Series`, on ``kept_tests``; in words ``printed``, in rows
  ``frames``
- ``identify_series``: the call, on ``sources``, ``condition_table``, ``reading_options`` and ``store``
- ``one_test``: a source to plain data (``encoded``), by workers (``computed``)
- ``kept``: what is kept of a test; on disk while a series runs in a ``journal``, then in a ``parquet_file``
"""

"""Keys of [series]."""

from __future__ import annotations

from .key import Key, Section

__all__ = ["SERIES"]

SERIES = Section(
    "series",
    'Many tests of one structure: [data] names a folder, or a pattern such as "records/*.npz".',
    (
        Key(
            "conditions",
            "text",
            "A CSV or Parquet file with what was measured beside: a row a test, in their order, or with "
            'their names in a column "name"; a column "time" dates them.',
        ),
        Key(
            "over",
            "text",
            "The condition over which the pictures draw the antiresonances; by default the tests in order.",
        ),
        Key("workers", "whole", "Processes that identify; by default one. No number depends on it."),
    ),
)

"""Refusals: errors that name the argument, what was got and what was wanted."""

import re

import pytest

import antires_rs as ar


def each_of(wrong):
    """Rows for ``parametrize``: every argument with each of the values that it cannot have."""
    return [(argument, value) for argument, values in wrong.items() for value in values]


def assert_refused(argument, call, *given, **options):
    with pytest.raises(ar.InvalidInputError, match=rf"(?s)^{re.escape(argument)}: got .*; wanted "):
        call(*given, **options)


def refused(words, call, *given, **options):
    """The call ends in an InvalidInputError whose text has these words."""
    with pytest.raises(ar.InvalidInputError, match=words):
        call(*given, **options)


def unsuitable(words, call, *given, **options):
    """The same with an UnsuitableDataError."""
    with pytest.raises(ar.UnsuitableDataError, match=words):
        call(*given, **options)

"""Presets: what they hold, and that what is given wins."""

import pytest

from antires_rs import FitOptions
from antires_rs.exceptions import InvalidInputError
from antires_rs.identification.options import PRESETS, CallOptions, options_of


@pytest.mark.parametrize("preset", [None, *PRESETS])
def test_what_is_given_wins(preset):
    held = FitOptions(min_rows=3, persistent=False).under(preset)
    assert (held.min_rows, held.persistent) == (3, False)
    assert held.damping_tol == FitOptions().under(preset).damping_tol
    assert held.given == {"min_rows", "persistent"}


@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset_is_a_set_of_options(preset):
    assert options_of(CallOptions(preset=preset), FitOptions()).rule == FitOptions().under(preset).checked()


def test_presets_cannot_be_changed_by_accident():
    with pytest.raises(TypeError):
        PRESETS["paper"]["min_rows"] = 1


def test_unknown_names_are_told():
    with pytest.raises(InvalidInputError, match="^preset: got 'loose'; wanted one of None, 'paper'"):
        options_of(CallOptions(preset="loose"), FitOptions())
    with pytest.raises(TypeError, match="rows"):
        FitOptions(rows=3)

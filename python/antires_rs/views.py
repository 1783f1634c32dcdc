"""Where outer rooms draw, write and tabulate the values of inner ones: the only door upwards.

A value says what it can be asked for, with a docstring; the function that does it is named here and imported
when it is asked for. So no room imports one above it, and nobody waits for matplotlib who wants no picture.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

VIEWS = {  # By class and verb: the function, in "room.module:function".
    ("AntiresonanceSet", "look"): "figures.page:of_set",
    ("AntiresonanceSet", "plot"): "figures.identification:plot_stabilization",
    ("AntiresonanceSet", "to_dataframe"): "io.data_frames:to_dataframe",
    ("AntiresonanceSet", "to_xarray"): "io.data_frames:to_xarray",
    ("Assessor", "load"): "io.archive:load_assessor",
    ("Assessor", "save"): "io.archive:save_assessor",
    ("BoxIdentifiability", "plot"): "figures.updating:plot_identifiability",
    ("Comparison", "plot"): "figures.sets:plot_comparison",
    ("Comparison", "to_dataframe"): "io.data_frames:comparison_frame",
    ("Comparison", "to_xarray"): "io.data_frames:comparison_dataset",
    ("DamageResult", "plot"): "figures.damage:plot_damage",
    ("DamageResult", "separating_test"): "planning.separation:separating_test",
    ("DataCheck", "plot"): "figures.identification:plot_singular_values",
    ("DetectionCurves", "plot"): "figures.planning:plot_detectability",
    ("FrameModel", "plot"): "figures.structure:plot_frame",
    ("FrequencyResponse", "to_dataframe"): "io.data_frames:to_dataframe",
    ("FrequencyResponse", "to_xarray"): "io.data_frames:to_xarray",
    ("Hypotheses", "plot"): "figures.damage:plot_hypotheses",
    ("Hypotheses", "to_dataframe"): "io.data_frames:hypotheses_frame",
    ("MatrixModel", "plot"): "figures.mesh:plot_mesh",
    ("ParameterIntervals", "to_dataframe"): "io.data_frames:intervals_frame",
    ("Recording", "to_dataframe"): "io.data_frames:to_dataframe",
    ("Recording", "to_xarray"): "io.data_frames:to_xarray",
    ("SensorPlan", "plot"): "figures.planning:plot_plan",
    ("StabilizationDiagram", "plot"): "figures.identification:plot_stabilization",
    ("Tracks", "plot"): "figures.sets:plot_tracks",
    ("Tracks", "to_dataframe"): "io.data_frames:tracks_frame",
    ("Tracks", "to_xarray"): "io.data_frames:tracks_dataset",
    ("UpdateResult", "load"): "io.archive:load_result",
    ("UpdateResult", "plot"): "figures.updating:plot_differences",
    ("UpdateResult", "report"): "figures.report:write_report",
    ("UpdateResult", "save"): "io.archive:save_result",
    ("Watched", "plot"): "figures.sets:plot_monitor",
    ("Watched", "report"): "figures.report:write_monitor_report",
}


class Viewed:
    """A value of which :data:`VIEWS` has functions; a class has those of its bases, too."""

    __slots__ = ()

    @classmethod
    def _view(cls, verb: str) -> Any:
        for each in cls.__mro__:
            if (each.__name__, verb) in VIEWS:
                module, function = VIEWS[each.__name__, verb].split(":")
                return getattr(import_module(f"{__package__}.{module}"), function)
        raise AttributeError(f"{cls.__name__} has no view {verb!r}")

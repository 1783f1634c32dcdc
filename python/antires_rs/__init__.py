"""Antiresonances from responses alone, model updating and damage location with them.

>>> import antires_rs as ar
>>> chain = ar.MassSpringChain([1.0, 1.0, 1.0], [500.0, 500.0])
>>> chain.antiresonances(0, 0).round(3)
array([2.199, 5.758])

See ARCHITECTURE.md for the map of the package, and :mod:`antires_rs.cases` for complete studies.
"""

from importlib import import_module as _import_module

from ._core import __version__ as __version__

# Where each public name lives. It is imported at first use, so that `antires --help` waits for no numpy.
# No name may be that of a module, which would take its place once imported.
_NAMES = {
    "damage.assess": "AssessedTest Assessor DamageResult assess_damage",
    "damage.hypotheses": "Hypotheses Hypothesis",
    "damage.options": "DamagePrior SearchOptions",
    "damage.severity_intervals": "SampledSet SeverityIntervals",
    "exceptions": (
        "AntiresError AntiresWarning InternalError InvalidInputError LostWorkerError "
        "MissingDependencyError NumericalError ObjectiveError OutOfMemoryError UnsuitableDataError"
    ),
    "identification.identify": "identify_antiresonances",
    "identification.modes": "identify_modes",
    "identification.options": "FitOptions",
    "identification.rational_fit": "RationalFit fit_rational",
    "identification.stabilization": "StabilizationDiagram stabilization",
    "io": (
        "from_sep005 read_csv read_excel read_frf_files read_hdf5 read_lvm read_mat read_matrices "
        "read_miniseed read_npz read_parquet read_tdms read_uff read_wav to_sep005 write_csv write_hdf5 "
        "write_mat write_matrices write_npz write_uff"
    ),
    "measured.antiresonance_set": "AntiresonanceSet",
    "measured.compare": "Comparison compare",
    "measured.merge": "merge_setups",
    "measured.modal_set": "ModalSet",
    "measured.track": "TrackEvent Tracks track",
    "models.chain": "MassSpringChain",
    "models.constraints": "Constrained eliminate_constraints lagrange_rows",
    "models.frame": "FrameModel",
    "models.frame_parts": "GroundSpring NodeSpring PointMass Rectangle Section Tube",
    "models.matrix_model": "MatrixModel",
    "models.parameters": (
        "Parameter angle density diameter inertia length mass_factor point_mass position "
        "stiffness_factor stiffness_reduction support_stiffness thickness youngs_modulus"
    ),
    "optimize.island_ga": "History IslandGA OptimizeResult",
    "planning.detectability": "detectability",
    "planning.detection_curves": "DetectionCurves",
    "planning.placement": "Round",
    "planning.plan": "SensorPlan plan_test",
    "signals.data_check": "check_data",
    "signals.frequency_response": "FrequencyResponse",
    "signals.one_force": "DataCheck Finding",
    "signals.recording": "Recording",
    "signals.transfer_functions": "frf transmissibility transmissibility_sum",
    "support.messages": "explain",
    "updating.identifiability": "BoxIdentifiability identifiability",
    "updating.posterior": "ParameterIntervals ProfileLikelihood",
    "updating.problem": "DamagePenalty UpdatingProblem",
    "updating.reduced_model": "Reduction ReductionReport",
    "updating.result": "UpdateResult",
    "updating.targets": "FrequencyTable ModalTable",
    "updating.update": "UpdateEnsemble update update_ensemble",
    "watch.charts": "Chart",
    "watch.faults": "Fault",
    "watch.identify_series": "identify_series",
    "watch.series": "Series",
    "watch.monitor": "monitor Watched",
}
_HOME = {name: module for module, names in _NAMES.items() for name in names.split()}
# Modules to be found by completion; every other module is an attribute as well.
_MODULES = ("cases", "exceptions", "figures", "io")

__all__ = sorted([*_HOME, "__version__", "cases"])


def __getattr__(name: str) -> object:
    if name in _HOME:
        found: object = getattr(_import_module(f"{__name__}.{_HOME[name]}"), name)
        globals()[name] = found
        return found
    if not name.startswith("__"):
        module = f"{__name__}.{name}"
        try:
            return _import_module(module)
        except ModuleNotFoundError as exc:
            if exc.name != module:  # one that the module itself asks for
                raise
    # With name and obj, Python proposes what was meant.
    raise AttributeError(
        f"module {__name__!r} has no attribute {name!r}", name=name, obj=_import_module(__name__)
    )


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, *_MODULES})

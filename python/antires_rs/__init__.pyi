# Every public name and where it lives: for type checkers and editors, and for __init__.py, which reads it.
# ruff: noqa: I001
# fmt: off

from . import cases, exceptions as exceptions, figures as figures, io as io
from ._core import __version__
from .damage.assess import AssessedTest, Assessor, DamageResult, assess_damage
from .damage.hypotheses import Hypotheses, Hypothesis
from .damage.options import DamagePrior, SearchOptions
from .damage.severity_intervals import SampledSet, SeverityIntervals
from .exceptions import (
    AntiresError, AntiresWarning, InternalError, InvalidInputError, LostWorkerError,
    MissingDependencyError, NumericalError, ObjectiveError, OutOfMemoryError, UnsuitableDataError
)
from .identification.identify import identify_antiresonances
from .identification.modes import identify_modes
from .identification.options import FitOptions
from .identification.rational_fit import RationalFit, fit_rational
from .identification.stabilization import StabilizationDiagram, stabilization
from .io import (
    MatchedPoints, from_sep005, match_points, read_csv, read_excel, read_frf_files, read_hdf5, read_lvm,
    read_mat, read_matrices, read_miniseed, read_model, read_npz, read_parquet, read_tdms, read_uff, read_wav,
    to_sep005, write_csv, write_hdf5, write_mat, write_matrices, write_model, write_npz, write_uff
)
from .measured.antiresonance_set import AntiresonanceSet
from .measured.compare import Comparison, compare
from .measured.merge import merge_setups
from .measured.modal_set import ModalSet
from .measured.track import TrackEvent, Tracks, track
from .models.chain import MassSpringChain
from .models.constraints import Constrained, eliminate_constraints, lagrange_rows
from .models.frame import FrameModel
from .models.frame_parts import GroundSpring, NodeSpring, PointMass, Rectangle, Section, Tube
from .models.matrix_model import MatrixModel
from .models.parameters import (
    Parameter, angle, density, diameter, inertia, length, mass_factor, point_mass, position,
    stiffness_factor, stiffness_reduction, support_stiffness, thickness, youngs_modulus
)
from .models.term_groups import Mesh, TermGroup
from .optimize.island_ga import History, IslandGA, OptimizeResult
from .planning.detectability import detectability
from .planning.detection_curves import DetectionCurves
from .planning.placement import Round
from .planning.plan import SensorPlan, plan_test
from .signals.alignment import align
from .signals.data_check import check_data
from .signals.frequency_response import FrequencyResponse
from .signals.findings import DataCheck, Finding
from .signals.recording import Recording
from .signals.transfer_functions import frf, transmissibility, transmissibility_sum
from .support.messages import explain
from .updating.force_places import ForcePlaces, rank_force_places
from .updating.identifiability import BoxIdentifiability, identifiability
from .updating.posterior import ParameterIntervals, ProfileLikelihood
from .updating.problem import DamagePenalty, UpdatingProblem
from .updating.reduced_model import Reduction, ReductionReport
from .updating.result import UpdateResult
from .updating.targets import FrequencyTable, ModalTable
from .updating.update import UpdateEnsemble, update, update_ensemble
from .watch.association import Fault
from .watch.charts import Chart
from .watch.identify_series import identify_series
from .watch.monitor import Watched, monitor
from .watch.series import Series

__all__ = [
    "AntiresError", "AntiresWarning", "AntiresonanceSet", "AssessedTest", "Assessor", "BoxIdentifiability",
    "Chart", "Comparison", "Constrained", "DamagePenalty", "DamagePrior", "DamageResult", "DataCheck",
    "DetectionCurves", "Fault", "Finding", "FitOptions", "ForcePlaces", "FrameModel", "FrequencyResponse",
    "FrequencyTable", "GroundSpring", "History", "Hypotheses", "Hypothesis", "InternalError",
    "InvalidInputError", "IslandGA", "LostWorkerError", "MassSpringChain", "MatchedPoints", "MatrixModel",
    "Mesh", "MissingDependencyError", "ModalSet", "ModalTable", "NodeSpring", "NumericalError",
    "ObjectiveError", "OptimizeResult", "OutOfMemoryError", "Parameter", "ParameterIntervals", "PointMass",
    "ProfileLikelihood", "RationalFit", "Recording", "Rectangle", "Reduction", "ReductionReport", "Round",
    "SampledSet", "SearchOptions", "Section", "SensorPlan", "Series", "SeverityIntervals",
    "StabilizationDiagram", "TermGroup", "TrackEvent", "Tracks", "Tube", "UnsuitableDataError",
    "UpdateEnsemble", "UpdateResult", "UpdatingProblem", "Watched", "__version__", "align", "angle",
    "assess_damage", "cases", "check_data", "compare", "density", "detectability", "diameter",
    "eliminate_constraints", "explain", "fit_rational", "frf", "from_sep005", "identifiability",
    "identify_antiresonances", "identify_modes", "identify_series", "inertia", "lagrange_rows", "length",
    "mass_factor", "match_points", "merge_setups", "monitor", "plan_test", "point_mass", "position",
    "rank_force_places", "read_csv", "read_excel", "read_frf_files", "read_hdf5", "read_lvm", "read_mat",
    "read_matrices", "read_miniseed", "read_model", "read_npz", "read_parquet", "read_tdms", "read_uff",
    "read_wav", "stabilization", "stiffness_factor", "stiffness_reduction", "support_stiffness", "thickness",
    "to_sep005", "track", "transmissibility", "transmissibility_sum", "update", "update_ensemble",
    "write_csv", "write_hdf5", "write_mat", "write_matrices", "write_model", "write_npz", "write_uff",
    "youngs_modulus",
]

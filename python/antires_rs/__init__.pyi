# What type checkers and editors see of __init__.py, which imports at first use; a test compares the two.

from . import cases
from . import exceptions as exceptions
from . import io as io
from . import plotting as plotting
from . import report as report
from ._core import __version__
from .assessor.answer import AssessedTest
from .assessor.assessor import Assessor
from .damage.assess import assess_damage
from .damage.hypotheses import Hypotheses, Hypothesis
from .damage.prior import DamagePrior
from .damage.result import DamageResult
from .damage.severity_intervals import SampledSet, SeverityIntervals
from .data_check import DataCheck, Finding, check_data
from .exceptions import (
    AntiresError,
    AntiresWarning,
    InternalError,
    InvalidInputError,
    LostWorkerError,
    MissingDependencyError,
    NumericalError,
    ObjectiveError,
    OutOfMemoryError,
    UnsuitableDataError,
)
from .identification.identify import identify_antiresonances
from .identification.modes import identify_modes
from .io import (
    from_sep005,
    read_csv,
    read_excel,
    read_frf_files,
    read_hdf5,
    read_lvm,
    read_mat,
    read_matrices,
    read_miniseed,
    read_npz,
    read_parquet,
    read_tdms,
    read_uff,
    read_wav,
    to_sep005,
    write_csv,
    write_hdf5,
    write_mat,
    write_matrices,
    write_npz,
    write_uff,
)
from .measured.antiresonance_set import AntiresonanceSet
from .measured.compare import Comparison, compare
from .measured.merge import merge_setups
from .measured.modal_set import ModalSet
from .measured.track import track
from .measured.tracks import TrackEvent, Tracks
from .models.chain import MassSpringChain
from .models.constraints import Constrained, eliminate_constraints, lagrange_rows
from .models.frame import FrameModel
from .models.frame_parameters import (
    density,
    diameter,
    inertia,
    point_mass,
    support_stiffness,
    thickness,
    youngs_modulus,
)
from .models.frame_parts import GroundSpring, NodeSpring, PointMass
from .models.geometry_parameters import angle, length, position
from .models.matrix_model import MatrixModel
from .models.parameters import Parameter, mass_factor, stiffness_factor, stiffness_reduction
from .models.sections import Rectangle, Section, Tube
from .monitoring.charts import Chart
from .monitoring.faults import Fault
from .monitoring.monitor import monitor
from .monitoring.watched import Watched
from .optimize.island_ga import IslandGA
from .optimize.outcome import History, OptimizeResult
from .order_sweep.diagram import StabilizationDiagram, stabilization
from .planning.detectability import detectability
from .planning.detection_curves import DetectionCurves
from .planning.placement import Round
from .planning.plan import plan_test
from .planning.sensor_plan import SensorPlan
from .rational.fit import RationalFit, fit_rational
from .series.identify_series import identify_series
from .series.series import Series
from .signals.frequency_response import FrequencyResponse
from .signals.recording import Recording
from .signals.transfer_functions import frf, transmissibility, transmissibility_sum
from .support.explained import explain
from .updating.box_identifiability import BoxIdentifiability, identifiability
from .updating.parameter_intervals import ParameterIntervals
from .updating.penalty import DamagePenalty
from .updating.problem import UpdatingProblem
from .updating.profile import ProfileLikelihood
from .updating.reduction import Reduction, ReductionReport
from .updating.results import UpdateResult
from .updating.search import update
from .updating.tables import FrequencyTable, ModalTable
from .updating.update_ensemble import UpdateEnsemble, update_ensemble

__all__ = [
    "AntiresError",
    "AntiresWarning",
    "AntiresonanceSet",
    "AssessedTest",
    "Assessor",
    "BoxIdentifiability",
    "Chart",
    "Comparison",
    "Constrained",
    "DamagePenalty",
    "DamagePrior",
    "DamageResult",
    "DataCheck",
    "DetectionCurves",
    "Fault",
    "Finding",
    "FrameModel",
    "FrequencyResponse",
    "FrequencyTable",
    "GroundSpring",
    "History",
    "Hypotheses",
    "Hypothesis",
    "InternalError",
    "InvalidInputError",
    "IslandGA",
    "LostWorkerError",
    "MassSpringChain",
    "MatrixModel",
    "MissingDependencyError",
    "ModalSet",
    "ModalTable",
    "NodeSpring",
    "NumericalError",
    "ObjectiveError",
    "OptimizeResult",
    "OutOfMemoryError",
    "Parameter",
    "ParameterIntervals",
    "PointMass",
    "ProfileLikelihood",
    "RationalFit",
    "Recording",
    "Rectangle",
    "Reduction",
    "ReductionReport",
    "Round",
    "SampledSet",
    "Section",
    "SensorPlan",
    "Series",
    "SeverityIntervals",
    "StabilizationDiagram",
    "TrackEvent",
    "Tracks",
    "Tube",
    "UnsuitableDataError",
    "UpdateEnsemble",
    "UpdateResult",
    "UpdatingProblem",
    "Watched",
    "__version__",
    "angle",
    "assess_damage",
    "cases",
    "check_data",
    "compare",
    "density",
    "detectability",
    "diameter",
    "eliminate_constraints",
    "explain",
    "fit_rational",
    "frf",
    "from_sep005",
    "identifiability",
    "identify_antiresonances",
    "identify_modes",
    "identify_series",
    "inertia",
    "lagrange_rows",
    "length",
    "mass_factor",
    "merge_setups",
    "monitor",
    "plan_test",
    "point_mass",
    "position",
    "read_csv",
    "read_excel",
    "read_frf_files",
    "read_hdf5",
    "read_lvm",
    "read_mat",
    "read_matrices",
    "read_miniseed",
    "read_npz",
    "read_parquet",
    "read_tdms",
    "read_uff",
    "read_wav",
    "stabilization",
    "stiffness_factor",
    "stiffness_reduction",
    "support_stiffness",
    "thickness",
    "to_sep005",
    "track",
    "transmissibility",
    "transmissibility_sum",
    "update",
    "update_ensemble",
    "write_csv",
    "write_hdf5",
    "write_mat",
    "write_matrices",
    "write_npz",
    "write_uff",
    "youngs_modulus",
]

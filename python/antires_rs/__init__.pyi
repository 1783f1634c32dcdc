# What type checkers and editors see of __init__.py, which imports at first use; a test compares the two.

from . import cases, exceptions as exceptions, figures as figures, io as io
from ._core import __version__
from .damage.assess import DamageResult as DamageResult, assess_damage as assess_damage
from .damage.assessor import AssessedTest as AssessedTest, Assessor as Assessor
from .damage.hypotheses import Hypotheses as Hypotheses, Hypothesis as Hypothesis
from .damage.options import DamagePrior as DamagePrior, SearchOptions as SearchOptions
from .damage.severity_intervals import SampledSet as SampledSet, SeverityIntervals as SeverityIntervals
from .exceptions import (
    AntiresError as AntiresError,
    AntiresWarning as AntiresWarning,
    InternalError as InternalError,
    InvalidInputError as InvalidInputError,
    LostWorkerError as LostWorkerError,
    MissingDependencyError as MissingDependencyError,
    NumericalError as NumericalError,
    ObjectiveError as ObjectiveError,
    OutOfMemoryError as OutOfMemoryError,
    UnsuitableDataError as UnsuitableDataError,
)
from .identification.identify import identify_antiresonances as identify_antiresonances
from .identification.modes import identify_modes as identify_modes
from .identification.options import FitOptions as FitOptions
from .identification.rational_fit import RationalFit as RationalFit, fit_rational as fit_rational
from .identification.stabilization import (
    StabilizationDiagram as StabilizationDiagram,
    stabilization as stabilization,
)
from .io import (
    from_sep005 as from_sep005,
    read_csv as read_csv,
    read_excel as read_excel,
    read_frf_files as read_frf_files,
    read_hdf5 as read_hdf5,
    read_lvm as read_lvm,
    read_mat as read_mat,
    read_matrices as read_matrices,
    read_miniseed as read_miniseed,
    read_npz as read_npz,
    read_parquet as read_parquet,
    read_tdms as read_tdms,
    read_uff as read_uff,
    read_wav as read_wav,
    to_sep005 as to_sep005,
    write_csv as write_csv,
    write_hdf5 as write_hdf5,
    write_mat as write_mat,
    write_matrices as write_matrices,
    write_npz as write_npz,
    write_uff as write_uff,
)
from .measured.antiresonance_set import AntiresonanceSet as AntiresonanceSet
from .measured.compare import Comparison as Comparison, compare as compare
from .measured.merge import merge_setups as merge_setups
from .measured.modal_set import ModalSet as ModalSet
from .measured.track import TrackEvent as TrackEvent, Tracks as Tracks, track as track
from .models.chain import MassSpringChain as MassSpringChain
from .models.constraints import (
    Constrained as Constrained,
    eliminate_constraints as eliminate_constraints,
    lagrange_rows as lagrange_rows,
)
from .models.frame import FrameModel as FrameModel
from .models.frame_parts import (
    GroundSpring as GroundSpring,
    NodeSpring as NodeSpring,
    PointMass as PointMass,
    Rectangle as Rectangle,
    Section as Section,
    Tube as Tube,
)
from .models.matrix_model import MatrixModel as MatrixModel
from .models.parameters import (
    Parameter as Parameter,
    angle as angle,
    density as density,
    diameter as diameter,
    inertia as inertia,
    length as length,
    mass_factor as mass_factor,
    point_mass as point_mass,
    position as position,
    stiffness_factor as stiffness_factor,
    stiffness_reduction as stiffness_reduction,
    support_stiffness as support_stiffness,
    thickness as thickness,
    youngs_modulus as youngs_modulus,
)
from .optimize.island_ga import History as History, IslandGA as IslandGA, OptimizeResult as OptimizeResult
from .planning.detectability import detectability as detectability
from .planning.detection_curves import DetectionCurves as DetectionCurves
from .planning.placement import Round as Round
from .planning.plan import SensorPlan as SensorPlan, plan_test as plan_test
from .signals.data_check import check_data as check_data
from .signals.frequency_response import FrequencyResponse as FrequencyResponse
from .signals.one_force import DataCheck as DataCheck, Finding as Finding
from .signals.recording import Recording as Recording
from .signals.transfer_functions import (
    frf as frf,
    transmissibility as transmissibility,
    transmissibility_sum as transmissibility_sum,
)
from .support.messages import explain as explain
from .updating.box_identifiability import (
    BoxIdentifiability as BoxIdentifiability,
    identifiability as identifiability,
)
from .updating.posterior import (
    ParameterIntervals as ParameterIntervals,
    ProfileLikelihood as ProfileLikelihood,
)
from .updating.problem import DamagePenalty as DamagePenalty, UpdatingProblem as UpdatingProblem
from .updating.reduced_search import Reduction as Reduction, ReductionReport as ReductionReport
from .updating.result import UpdateResult as UpdateResult
from .updating.tables import FrequencyTable as FrequencyTable, ModalTable as ModalTable
from .updating.update import (
    UpdateEnsemble as UpdateEnsemble,
    update as update,
    update_ensemble as update_ensemble,
)
from .watch.charts import Chart as Chart
from .watch.faults import Fault as Fault
from .watch.identify_series import identify_series as identify_series
from .watch.monitor import Watched as Watched, monitor as monitor
from .watch.series import Series as Series

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
    "FitOptions",
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
    "SearchOptions",
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

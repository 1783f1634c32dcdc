"""Files in and out: recordings and responses, matrices of models, results.

docs/files.md has a table of what each format keeps. Nothing is computed here; optional packages are imported
where they are used.
"""

from ..support.messages import names_left
from .channels import from_sep005, to_sep005
from .fe_codes import read_model, write_model
from .hdf5_mat import read_hdf5, read_mat, write_hdf5, write_mat
from .matrix_files import read_dof_map, read_matrices, write_matrices
from .mesh_files import read_mesh
from .own_format import read_npz, write_npz
from .points import MatchedPoints, match_points
from .recorders import read_lvm, read_miniseed, read_tdms, read_wav
from .registry import read_frf_files
from .table_files import read_csv, read_excel, read_parquet, write_csv
from .uff import list_uff, read_uff, write_uff

__all__ = [
    "MatchedPoints", "from_sep005", "list_uff", "match_points", "read_csv", "read_dof_map", "read_excel",
    "read_frf_files", "read_hdf5", "read_lvm", "read_mat", "read_matrices", "read_mesh", "read_miniseed",
    "read_model", "read_npz", "read_parquet", "read_tdms", "read_uff", "read_wav", "to_sep005", "write_csv",
    "write_hdf5", "write_mat", "write_matrices", "write_model", "write_npz", "write_uff",
]  # fmt: skip

__getattr__ = names_left(__name__, {"mat_arrays": "scipy.io.loadmat lists the arrays of a file"})

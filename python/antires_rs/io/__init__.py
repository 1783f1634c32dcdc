"""Files in and out: recordings and responses, matrices of models, results.

docs/files.md has a table of what each format keeps. Nothing is computed here; optional packages are imported
where they are used.
"""

from .channels import from_sep005 as from_sep005, to_sep005 as to_sep005
from .hdf5_mat import (
    mat_arrays as mat_arrays,
    read_hdf5 as read_hdf5,
    read_mat as read_mat,
    write_hdf5 as write_hdf5,
    write_mat as write_mat,
)
from .matrix_files import (
    read_dof_map as read_dof_map,
    read_matrices as read_matrices,
    write_matrices as write_matrices,
)
from .own_format import read_npz as read_npz, write_npz as write_npz
from .recorders import (
    read_lvm as read_lvm,
    read_miniseed as read_miniseed,
    read_tdms as read_tdms,
    read_wav as read_wav,
)
from .registry import read_frf_files as read_frf_files
from .table_files import (
    read_csv as read_csv,
    read_excel as read_excel,
    read_parquet as read_parquet,
    write_csv as write_csv,
)
from .uff import list_uff as list_uff, read_uff as read_uff, write_uff as write_uff

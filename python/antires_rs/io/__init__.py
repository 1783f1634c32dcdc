"""Files in and out: recordings and responses, matrices of models, results.

docs/files.md has a table of what each format keeps. Nothing is computed here; optional packages are imported
where they are used.
"""

from ..support.messages import names_left
from .channels import *
from .fe_codes import *
from .hdf5_mat import *
from .matrix_files import *
from .mesh_files import *
from .own_format import *
from .points import *
from .recorders import *
from .registry import *
from .table_files import *
from .uff import *

__getattr__ = names_left(__name__, {"mat_arrays": "scipy.io.loadmat lists the arrays of a file"})

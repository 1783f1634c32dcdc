"""Other packages, driven to give antiresonances. They are called, never copied; each may be missing."""

from . import pydynamic, pyfbs_plscf, pyoma2_fits, scikit_rf, scipy_aaa, sdypy_ema, strid_plscf

METHODS = tuple(
    method
    for module in (sdypy_ema, pyoma2_fits, strid_plscf, pyfbs_plscf, scipy_aaa, scikit_rf, pydynamic)
    for method in module.METHODS
)

"""Antiresonances from responses alone, model updating and damage location with them.

>>> import antires_rs as ar
>>> chain = ar.MassSpringChain([1.0, 1.0, 1.0], [500.0, 500.0])
>>> chain.antiresonances(0, 0).round(3)
array([2.199, 5.758])

See ARCHITECTURE.md for the map of the package, and :mod:`antires_rs.cases` for complete studies.
"""

import re as _re
from _thread import RLock as _RLock
from importlib import import_module as _import_module
from pkgutil import get_data as _get_data

from ._core import __version__ as __version__

# Where each public name lives: what the stub tells type checkers. It is imported at first use, so that
# `antires --help` waits for no numpy. No name may be that of a module, which would take its place.
_IMPORTS = _re.compile(r"^from \.([\w.]+) import (\([^)]*\)|.*)", _re.MULTILINE)
_STUB = (_get_data(__name__, "__init__.pyi") or b"").decode()
_HOME = {name: home for home, names in _IMPORTS.findall(_STUB) for name in _re.findall(r"\w+", names)}
del _HOME["__version__"]
# Of two threads that import modules of one room at once one may see the other's half-made.
_LOCK = _RLock()
# Modules to be found by completion; every other module is an attribute as well.
_MODULES = ("cases", "exceptions", "figures", "io")

__all__ = sorted([*_HOME, "__version__", "cases"])


def __getattr__(name: str) -> object:
    if name in _HOME:
        with _LOCK:
            found: object = getattr(_import_module(f"{__name__}.{_HOME[name]}"), name)
        globals()[name] = found
        return found
    if not name.startswith("__"):
        module = f"{__name__}.{name}"
        try:
            with _LOCK:
                return _import_module(module)
        except ModuleNotFoundError as exc:
            if exc.name != module:  # one that the module itself asks for
                raise
    raise AttributeError(  # With name and obj, Python proposes what was meant.
        f"module {__name__!r} has no attribute {name!r}", name=name, obj=_import_module(__name__)
    )


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, *_MODULES})

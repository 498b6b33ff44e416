"""When simulation and recordings differ: is it real, where, what was left out, does it help."""

from .find import Found, find_mismatch
from .free_run_errors import PathErrors, path_errors
from .locate import Dependence, dependences, folds

__all__ = [
    "Dependence",
    "Found",
    "PathErrors",
    "dependences",
    "find_mismatch",
    "folds",
    "path_errors",
]

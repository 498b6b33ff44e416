"""When simulation and recordings differ: is it real, where, what was left out, does it help."""

from .find import Found, find_mismatch
from .free_run_errors import PathErrors, path_errors
from .locate import Dependence, MissingForce, dependences, folds, missing_force

__all__ = [
    "Dependence",
    "Found",
    "MissingForce",
    "PathErrors",
    "dependences",
    "find_mismatch",
    "folds",
    "missing_force",
    "path_errors",
]

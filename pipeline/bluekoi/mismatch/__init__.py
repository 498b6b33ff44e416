"""When simulation and recordings differ: is it real, where, what was left out, does it help."""

from .find import MismatchResult, find_mismatch
from .free_run_errors import PathErrors, path_errors
from .missing_force_dependence import Dependence, condition_folds, dependences

__all__ = [
    "Dependence",
    "MismatchResult",
    "PathErrors",
    "condition_folds",
    "dependences",
    "find_mismatch",
    "path_errors",
]

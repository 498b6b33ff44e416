"""When simulation and recordings differ: is it real, where, what was left out, does it help."""

from .find import MismatchResult, find_mismatch
from .free_run_errors import PathErrors, path_errors
from .missing_force_dependence import ExplainedForceShare, force_dependences, trial_indices_by_fold

__all__ = [
    "ExplainedForceShare",
    "MismatchResult",
    "PathErrors",
    "find_mismatch",
    "force_dependences",
    "path_errors",
    "trial_indices_by_fold",
]

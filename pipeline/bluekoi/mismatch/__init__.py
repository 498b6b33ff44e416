"""When simulation and recordings differ: is it real, where, what was left out, does it help."""

from .bench import Bench
from .find import Found, find_mismatch
from .horizon import PathErrors, path_errors, stretches
from .judge import Trialled, folds, held_out_worth, trialled
from .locate import Dependence, MissingForce, dependences, missing_force
from .paying import pays
from .search import screened, try_effects
from .select import Choice, choose
from .weighing import reliability, weights

__all__ = [
    "Bench",
    "Choice",
    "Dependence",
    "Found",
    "MissingForce",
    "PathErrors",
    "Trialled",
    "choose",
    "dependences",
    "find_mismatch",
    "folds",
    "held_out_worth",
    "missing_force",
    "path_errors",
    "pays",
    "reliability",
    "screened",
    "stretches",
    "trialled",
    "try_effects",
    "weights",
]

"""When simulation and recordings differ: is it real, where, what was left out, does it help."""

from .find import Found, find_mismatch
from .locate import Dependence, MissingForce, dependences, missing_force
from .search import Trialled, folds, held_out_worth, screened, try_effects
from .select import Choice, choose, pays, shared, weights

__all__ = [
    "Choice",
    "Dependence",
    "Found",
    "MissingForce",
    "Trialled",
    "choose",
    "dependences",
    "find_mismatch",
    "folds",
    "held_out_worth",
    "missing_force",
    "pays",
    "screened",
    "shared",
    "try_effects",
    "weights",
]

"""Steady speed and turn of a trial, with uncertainty and a named outcome."""

from .circle import Circle, fit_circle
from .plateau import Plateau, fit_plateau
from .state import steady_state
from .table import read_steady, write_steady

__all__ = [
    "Circle",
    "Plateau",
    "fit_circle",
    "fit_plateau",
    "read_steady",
    "steady_state",
    "write_steady",
]

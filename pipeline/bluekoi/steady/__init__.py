"""Steady speed and turn of a trial, with uncertainty and a named outcome."""

from .circle import fit_circle
from .plateau import fit_plateau
from .state import steady_state
from .table import read_steady, write_steady

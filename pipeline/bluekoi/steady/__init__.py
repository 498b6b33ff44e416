"""Steady speed and turn of a trial, with uncertainty and a named outcome."""

from .circle_fit import fit_circle
from .speed_plateau import fit_plateau
from .steady_csv import read_steady, write_steady
from .steady_segment import steady_state

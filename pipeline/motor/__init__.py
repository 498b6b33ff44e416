"""Flapping frequency of a trial: from the motor's shaft angle, and from the tail in the video."""

from .compare import compare, flapping_given
from .delay import clock_delay
from .log import flapping_from_log, read_log
from .shaft import Shaft, shaft_motion
from .tailbeat import beat_lag, tail_beat

__all__ = [
    "Shaft",
    "beat_lag",
    "clock_delay",
    "compare",
    "flapping_from_log",
    "flapping_given",
    "read_log",
    "shaft_motion",
    "tail_beat",
]

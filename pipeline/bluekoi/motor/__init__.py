"""Flapping frequency of a trial: from the motor's shaft angle, and from the tail in the video."""

from .compare import common_ratio, compare, flapping_given, has_other_clock
from .delay import clock_delay
from .log import flapping_from_log, read_log
from .tailbeat import beat_lag, clock_ratio, tail_beat

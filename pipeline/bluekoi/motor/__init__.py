"""Flapping frequency of a trial: from the motor's shaft angle, and from the tail in the video."""

from .clock_comparison import (
    common_clock_ratio,
    flapping_compared_with_video,
    flapping_from_stated_frequency,
    trials_with_deviating_clock,
)
from .log_video_delay import log_lead_from_beat_phases
from .motor_log import flapping_from_log, read_log
from .tail_beat import tail_beat_from_video, tail_beat_lag, video_to_motor_frequency_ratio
from .trial_flapping import flapping_as_json, trial_flapping

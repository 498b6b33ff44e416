"""Why the fish turns better to one side: the causes that could, each beside what is named.

They are tried one by one on the same trials and judged on conditions left out, so that the weights
answer this question alone, whatever else the search finds worth naming.
"""

from __future__ import annotations

from collections.abc import Sequence

from .reading import Recording

CAUSES = (
    "tail_drive", "tail_beat_frequency", "tail_amplitude", "clock_error", "servo_reach",
    "head_angle_offset", "thrust_asymmetry", "port_starboard_asymmetry", "trim_moment",
)  # fmt: skip
"""What can tell port from starboard: the drive as the recoil shows it (beat, amplitude, both), a
clock that runs unevenly, the servo's reach and zero, thrust, the body's lift, a lasting moment."""


def side_by_side(recordings: Sequence[Recording]) -> list[tuple[float, float, float, float]]:
    """Bias, tail beat (Hz), recoil (rad over the told amplitude), means of a condition's trials."""
    out = []
    for condition in dict.fromkeys(r.condition for r in recordings):
        own = [r for r in recordings if r.condition == condition]
        hz = sum(r.beat_hz for r in own) / len(own)
        recoil = sum(r.recoil_rad for r in own) / len(own)
        out.append((own[0].amplitude_deg, own[0].bias_deg, hz, recoil))
    return out

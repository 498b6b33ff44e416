"""The motor's clock held against the camera's."""

from __future__ import annotations

import math
from dataclasses import replace

from ..data import Flapping

SIGMAS = 3.0


def flapping_given(flap_hz: float) -> Flapping:
    """Flapping of a trial whose frequency is stated in trials.csv, taken as exact to 1 %."""
    return Flapping(flap_hz=float(flap_hz), flap_hz_std=0.01 * float(flap_hz), source="flap_hz")


def compare(flapping: Flapping, video: tuple[float, float]) -> Flapping:
    """`flapping` with the tail-beat frequency seen in the video, (Hz, std), and whether they agree.

    They disagree where they lie more than three standard deviations apart: then one of the two
    clocks is wrong, and a remark gives the ratio video / motor with its uncertainty.
    """
    hz, std = video
    if not (math.isfinite(hz) and math.isfinite(std)):
        return replace(flapping, video_hz=math.nan, video_hz_std=math.nan)
    apart = abs(hz - flapping.flap_hz)
    agrees = apart <= SIGMAS * math.hypot(std, flapping.flap_hz_std)
    remarks = flapping.remarks
    if not agrees:
        ratio = hz / flapping.flap_hz
        error = ratio * math.hypot(std / hz, flapping.flap_hz_std / flapping.flap_hz)
        remarks = (
            *remarks,
            f"clocks disagree: tail beat in the video / motor = {ratio:.4f} +- {error:.4f}; "
            "check fps in trials.csv and the motor log's time column",
        )
    return replace(flapping, video_hz=hz, video_hz_std=std, agrees=agrees, remarks=remarks)

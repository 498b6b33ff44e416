"""How far the errors that are constant in a trial scatter between trials."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..fitting import Noise, TrialEffect
from ..fitting.trial_effects import STD_PRIOR_GEOMETRIC_STD


@dataclass(frozen=True)
class _ScatteringQuantity:
    """A quantity with an error in each trial: name, number with unit of a standard deviation of its
    parameter, and what to do where it scatters widely.
    """

    name: str
    text: Callable[[float, float], str]
    remedy: str


def _degrees(std: float, _: float) -> str:
    return f"{np.degrees(std):.2g} degrees"


QUANTITIES = {
    "servo_error.angle": _ScatteringQuantity(
        "true head angle", _degrees,
        "Check the play of the servo, and whether head_angle_deg is right in each trial."),
    "C_T": _ScatteringQuantity(
        "flapping frequency", lambda std, thrust: f"{50.0 * std / thrust:.2g} %",
        "Log the motor, or charge the battery before each trial."),
    "head_angle_error.angle": _ScatteringQuantity(
        "measured head angle", _degrees,
        "Look at the keypoints of head tip and hinge in the overlays."),
    "time_offset.start_delay": _ScatteringQuantity(
        "starting time", lambda std, _: f"{std:.2g} s",
        "Start video and motor together, or show the start of the motor in the video."),
}  # fmt: skip
"""Parameter of a trial effect -> the quantity. The thrust is proportional to the square of the
frequency; its parameter `C_T` is compared with its value."""


def scatter_warnings(noise: Noise, thrust_coefficient: float) -> list[str]:
    """A sentence for each error that scatters more than laboratories usually do: by more than the
    geometric standard deviation of its prior above the expected standard deviation.
    """
    return [_sentence(effect, abs(thrust_coefficient)) for effect in noise.trial_effects
            if effect.expected_std > 0
            and effect.std > STD_PRIOR_GEOMETRIC_STD * effect.expected_std]  # fmt: skip


def _sentence(effect: TrialEffect, thrust_coefficient: float) -> str:
    own = QUANTITIES[effect.parameter]
    found, expected = (
        own.text(std, thrust_coefficient) for std in (effect.std, effect.expected_std)
    )
    return (f"The {own.name} differs between trials by {found} (standard deviation; {expected} is "
            f"usual), which hides causes. {own.remedy}")  # fmt: skip


def scatter_json(noise: Noise) -> dict[str, dict[str, float]]:
    """Parameter of each trial effect -> estimated and expected standard deviation."""
    return {effect.parameter: {"std": effect.std, "expected_std": effect.expected_std}
            for effect in noise.trial_effects}  # fmt: skip

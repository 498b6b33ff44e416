"""Compiled functions, loaded before they are needed; on first use compiled and kept on the disk."""

from __future__ import annotations

import numpy as np

from ..data import Pose
from ..fitting import Noise, TrialSeries, filter_series, free_runs
from ..integrate import compile_system
from ..model import two_plate_system
from ..smoothing import smooth_pose

WARM_UP_FRAMES = 24
WARM_UP_FLAP_HZ = 5.0


def precompile_smoother() -> None:
    """Smooth a short straight run, so that all functions of the smoother are compiled."""
    time_s = np.arange(WARM_UP_FRAMES) / 30
    values = np.zeros((WARM_UP_FRAMES, 4))
    values[:, 0] = 0.5 * time_s
    cov = np.tile(1e-6 * np.eye(4), (WARM_UP_FRAMES, 1, 1))
    smooth_pose(Pose(time_s, values, cov), WARM_UP_FLAP_HZ)


def precompile_model() -> None:
    """Filter and simulate three frames with the kernel of the model without effects."""
    _filter_and_simulate_three_frames(0.0)


def precompile_model_with_effects() -> None:
    """Filter and simulate three frames with the kernel of the model with effects."""
    _filter_and_simulate_three_frames(1e-9)


def _filter_and_simulate_three_frames(strength: float) -> None:
    kernel = compile_system(two_plate_system())
    system = kernel.system
    values = np.array([p.start for p in system.parameters])
    values[system.strength_parameter_indices[0]] = strength
    states, seen = len(system.all_states), len(system.observations)
    one = TrialSeries(
        name="", group="", condition="", times=np.arange(3) / 30, inputs=np.zeros((3, 2)),
        constants=np.ones(len(system.constants)), seen=np.zeros((3, seen)),
        noise=np.tile(np.eye(seen), (3, 1, 1)), mean=np.zeros(states), cov=np.eye(states),
    )  # fmt: skip
    filter_series(kernel, one, values, Noise(np.zeros(0), np.ones(0), np.ones(seen)))
    free_runs(kernel, [one], [values], iterations=1)

"""From a motion to what is written: pixels of labels in every frame, and the motor's shaft."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from .drive_laws import drive_factor, head_angle
from .here import Law, Setting
from .robots import Array
from .session import Run
from .sight import Scene, clock_error, seen_places
from .tracker import Tracker, label_places, tracked

LOG_STEP = 0.005


@dataclass(frozen=True)
class Take:
    """One trial as found. stated_fps: as trials.csv says; shaft: turns every `LOG_STEP`."""

    pixels: Array
    likelihood: Array
    stated_fps: float
    shaft: Array


def shaft_turns(laws: tuple[Law, ...], setting: Setting, times: Array, phase: float) -> Array:
    """Turns of the shaft of one trial since the recording began."""
    fine = np.linspace(0, times[-1] + 0.01, 4000)
    awake = np.maximum(fine - setting.delay[0], 0)
    wide = setting.columns(np.zeros(len(fine), dtype=int))
    flap = wide.flap * drive_factor(laws, awake, wide) * (fine >= setting.delay[0])
    return phase + CubicSpline(fine, flap).antiderivative()(times)


def film_trial(
    rng: np.random.Generator, laws: tuple[Law, ...], scene: Scene, run: Run, tracker: Tracker,
    *, trial: int, fps: float,
) -> Take:  # fmt: skip
    """Film one trial."""
    setting = run.setting.columns(slice(trial, trial + 1))
    span = float(setting.span[0])
    times = np.arange(int(span * fps)) / fps
    state = CubicSpline(run.times, run.states[:, trial], axis=1)(times)
    phase = float(rng.random())
    awake = np.maximum(times - setting.delay[0], 0)
    phi = np.full(len(times), setting.phi[0])
    for law in laws:
        if law.name in ("servo_lag", "head_angle_offset"):
            phi = head_angle(law, phi, awake, np.full(len(times), setting.phi[0]))
    turns = shaft_turns(laws, setting, times, phase)[: len(times)]
    strength = (1 - np.exp(-awake / 0.3)) * (times >= setting.delay[0])
    labels = label_places(
        scene.robot, setting, laws, tracker, place=state[0] + 1j * state[1],
        core=state[2] + phi, phi=phi, beat=2 * np.pi * turns, strength=strength,
    )  # fmt: skip
    pixels = seen_places(laws, scene, setting, times[None], labels[None])[0]
    found, likelihood = tracked(rng, tracker, pixels, fps)
    stated = fps
    for law in laws:
        if law.name == "clock_error":
            stated = fps * (1 + float(clock_error(law, setting.order)[0]))
    log_times = np.arange(0, span - setting.delay[0], LOG_STEP) + setting.delay[0]
    return Take(found, likelihood, stated, shaft_turns(laws, setting, log_times, phase))

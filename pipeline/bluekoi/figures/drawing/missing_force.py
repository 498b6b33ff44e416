"""The missing force along the paths, and the force of the identified effects."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...campaign import Campaign
from ...data import Float, Track
from ...integrate import LANES, System, compile_system
from ...integrate.batch import repeat_over_lanes, simulate_batch
from ...model import constants_of_robot_trial, is_residual, robot_system

FORCE_CHANNELS = ("surge", "sway", "yaw")
"""Force components: along the core, to its left, and the moment about the vertical axis."""
FORCE_COLUMNS = {"surge": "surge_N", "sway": "sway_N", "yaw": "yaw_Nm"}
"""Channel -> column of mismatch_detail.json with its missing force."""
FORCE_UNITS = {"surge": "mN", "sway": "mN", "yaw": "mN m"}
"""Channel -> unit in which a figure shows its force."""
FORCE_NAMES = {"surge": "surge force", "sway": "sway force", "yaw": "yaw moment"}
"""Channel -> name of its force in a figure."""
VARIABLE_LABELS = {
    "speed_m_s": "speed (m/s)",
    "sway_speed_m_s": "sway speed, positive to the left (m/s)",
    "yaw_rate_rad_s": "yaw rate, counter-clockwise positive (rad/s)",
    "angle_of_attack_rad": "angle of attack of the head (rad)",
    "head_angle_rad": "head angle (rad)",
    "flap_hz": "flapping frequency (Hz)",
    "head_length_m": "head length (m)",
    "x_m": "x position in the pool (m)",
    "y_m": "y position in the pool (m)",
    "time_s": "time (s)",
    "heading_turned_rad": "change of heading since the start (rad)",
    "tail_beat_phase_rad": "phase of the tail beat (rad)",
    "side": "turning side (-1: core right of head, +1: left)",
}
"""Variable -> label of its axis."""
DERIVATIVE_STEP_S = 1e-6
"""Interval over which the model's accelerations are taken."""
EFFECT_STATE_STEPS_PER_FRAME = 4
"""Steps of an effect's own states between frames; the motion is the measured one at each."""


@dataclass(frozen=True)
class MissingForceSeries:
    """Missing force of one trial, (n, 3): surge, sway [mN], yaw [mN m], with standard errors.

    motion: (n, 7) = x, y [m], core heading [rad], surge, sway speed [m/s], yaw rate [rad/s],
    time [s].
    """

    trial_id: str
    force: Float
    std: Float
    motion: Float


def missing_forces(campaign: Campaign) -> dict[str, MissingForceSeries]:
    """Missing force by trial, from mismatch_detail.json and the tracks; empty without forces.

    A trial along which the filter ran away has none: its forces are not numbers.
    """
    forces = (campaign.mismatch_detail or {}).get("forces") or {}
    needed = {
        "time_s",
        "x_m",
        "y_m",
        *FORCE_COLUMNS.values(),
        *(f"{c}_std" for c in FORCE_CHANNELS),
    }
    found = {
        name: _missing_force(name, entry, campaign.tracks[name])
        for name, entry in forces.items()
        if name in campaign.tracks and needed <= entry.keys()
    }
    return {name: one for name, one in found.items() if np.isfinite(one.force).all()}


def variable_along_trial(campaign: Campaign, one: MissingForceSeries, name: str) -> Float:
    """A variable of mismatch.json along a trial, (n,); NaN for an unknown name."""
    x, y, psi, u, v, r, t = one.motion.T
    trial = campaign.study.trial(one.trial_id)
    phi, flap_hz = trial.head_angle_rad, campaign.steady[one.trial_id].flap_hz
    along, across = u * np.cos(phi) - v * np.sin(phi), u * np.sin(phi) + v * np.cos(phi)
    beat = 2 * np.pi * flap_hz * t
    known: dict[str, Float] = {
        "speed_m_s": np.hypot(u, v),
        "sway_speed_m_s": v,
        "yaw_rate_rad_s": r,
        "angle_of_attack_rad": -np.arctan2(across, np.maximum(np.abs(along), 1e-3)),
        "head_angle_rad": np.full(len(t), phi),
        "flap_hz": np.full(len(t), flap_hz),
        "head_length_m": np.full(len(t), trial.head_length_m),
        "x_m": x,
        "y_m": y,
        "time_s": t,
        "heading_turned_rad": np.abs(psi - psi[0]),
        "tail_beat_phase_rad": np.arctan2(np.sin(beat), np.cos(beat)),
        "side": np.full(len(t), np.sign(phi)),
    }
    return known.get(name, np.full(len(t), np.nan))


def force_of_effects(campaign: Campaign, one: MissingForceSeries) -> Float:
    """Force of the identified effects in the measured motion, (n, 3), mN and mN m.

    m (u'_with - u'_without), m (v'_with - v'_without), I (r'_with - r'_without), with the same
    coefficients in both; NaN if the detail file has no coefficients.
    """
    fitted = ((campaign.mismatch_detail or {}).get("coefficients") or {}).get("after")
    if not fitted:
        return np.full_like(one.force, np.nan)
    power = f"{campaign.study.trial(one.trial_id).power_pct:g}"
    system = robot_system(campaign.study.setup.robot)
    models = [
        _parameter_vector_of_fit(system, _without_effects(fitted), power),
        _parameter_vector_of_fit(system, fitted, power),
    ]
    before, after = _accelerations_of_two_models(campaign, one, models)
    robot = campaign.study.setup.robot
    inertia = np.array([robot.mass_kg, robot.mass_kg, robot.yaw_inertia_kg_m2])
    return np.asarray(1000 * inertia * (after - before))


def _without_effects(fitted: Mapping[str, Any]) -> dict[str, Any]:
    """Coefficients of a fit without its effects; only the residual terms are removed if any."""
    residual = any(is_residual(label) for label in fitted)
    return {
        label: cell for label, cell in fitted.items()
        if "." not in label or (residual and not is_residual(label))
    }  # fmt: skip


def _missing_force(name: str, entry: Mapping[str, Any], track: Track) -> MissingForceSeries:
    times = np.asarray(entry["time_s"], dtype=float)
    psi, vx, vy, rate = (
        np.interp(times, track.time_s, values)
        for values in (track.heading_rad, track.vx_m_s, track.vy_m_s, track.yaw_rate_rad_s)
    )
    c, s = np.cos(psi), np.sin(psi)
    xy = [np.asarray(entry[k], dtype=float) for k in ("x_m", "y_m")]
    motion = [*xy, psi, vx * c + vy * s, vy * c - vx * s, rate, times]
    force = [np.asarray(entry[FORCE_COLUMNS[channel]], dtype=float) for channel in FORCE_CHANNELS]
    std = [np.asarray(entry[f"{channel}_std"], dtype=float) for channel in FORCE_CHANNELS]
    return MissingForceSeries(
        name, 1000 * np.column_stack(force), 1000 * np.column_stack(std), np.column_stack(motion)
    )


def _parameter_vector_of_fit(
    system: System, fitted: Mapping[str, Mapping[str, float]], power: str
) -> Float:
    """Full parameter vector of a fit; `C_Da@75` applies to trials at 75 % power."""
    coefficients: dict[str, float] = {}
    effects: dict[str, dict[str, float]] = {}
    for label, cell in fitted.items():
        name, _, group = label.partition("@")
        if group and group != power:
            continue
        effect, _, parameter = name.rpartition(".")
        target = effects.setdefault(effect, {}) if effect else coefficients
        target[parameter] = float(cell["value"])
    return np.asarray(system.parameter_vector(coefficients, effects))


def _accelerations_of_two_models(
    campaign: Campaign, one: MissingForceSeries, models: list[Float]
) -> tuple[Float, Float]:
    """Derivatives of surge, sway and yaw rate of two models in the measured motion, (n, 3) each.

    States of the effects, such as the lift of a fin that follows the flow, start at 0 and follow
    the measured motion.
    """
    kernel = compile_system(robot_system(campaign.study.setup.robot))
    n = len(one.motion)
    trial = campaign.study.trial(one.trial_id)
    state = np.zeros((n, len(kernel.system.all_states), LANES))
    state[:, :6] = one.motion[:, :6, None]
    values = np.repeat(models[0][:, None], LANES, axis=1)
    values[:, 1] = models[1]
    x, y, heading = map(float, one.motion[0, :3])
    fixed = constants_of_robot_trial(
        campaign.study.setup, trial.head_length_m, heading_rad=heading, place_m=(x, y)
    )
    inputs = [trial.head_angle_rad, campaign.steady[one.trial_id].flap_hz]

    def states_after(rows: slice, seconds: Float) -> Float:
        """States (m, states, 16) after an interval (m, 1) from each of some frames."""
        count = len(seconds)
        _, states = simulate_batch(
            kernel,
            state[rows],
            np.repeat(values[None], count, axis=0),
            repeat_over_lanes(np.tile(fixed, (count, 1))),
            times=one.motion[rows, 6:] + np.hstack([np.zeros_like(seconds), seconds]),
            inputs=np.tile(inputs, (count, 2, 1)),
            keep_states=True,
        )
        return np.asarray(states[:, 1])

    _, effects = kernel.system.unpack_parameter_vector(models[1])
    names = [name for effect in effects for name in kernel.system.effect(effect).states]
    own = [kernel.system.all_states.index(name) for name in names]
    for i in range(n - 1 if own else 0):
        seconds = (
            one.motion[i + 1 : i + 2, 6:] - one.motion[i : i + 1, 6:]
        ) / EFFECT_STATE_STEPS_PER_FRAME
        at_frame = state[i, own]
        for _ in range(EFFECT_STATE_STEPS_PER_FRAME):
            state[i, own] = states_after(slice(i, i + 1), seconds)[0, own]
        state[i, own], state[i + 1, own] = at_frame, state[i, own]
    after = states_after(slice(None), np.full((n, 1), DERIVATIVE_STEP_S))
    change = (after[:, 3:6, :2] - one.motion[:, 3:6, None]) / DERIVATIVE_STEP_S
    return change[..., 0], change[..., 1]

"""The missing force along the paths, and what the extended model puts in its place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...campaign import Campaign
from ...data import Float, Track
from ...integrate import LANES, compiled
from ...integrate.batch import propagate
from ...model import constants, is_nameless, plates

CHANNELS = ("surge", "sway", "yaw")
KEYS = {"surge": "surge_N", "sway": "sway_N", "yaw": "yaw_Nm"}
UNITS = {"surge": "mN", "sway": "mN", "yaw": "mN m"}
LABELS = {
    "speed_m_s": "speed (m/s)",
    "sway_speed_m_s": "sideways speed, to the left (m/s)",
    "yaw_rate_rad_s": "yaw rate, counter-clockwise (rad/s)",
    "angle_of_attack_rad": "angle of attack of the head (rad)",
    "head_angle_rad": "head angle (rad)",
    "flap_hz": "flapping frequency (Hz)",
    "head_length_m": "head length (m)",
    "x_m": "place along the pool, x (m)",
    "y_m": "place across the pool, y (m)",
    "time_s": "time (s)",
    "heading_turned_rad": "heading turned since the start (rad)",
    "tail_beat_phase_rad": "phase of the tail beat (rad)",
    "side": "side of the head (-1: core right of head, +1: left)",
}
SPAN_S = 1e-6


@dataclass(frozen=True)
class Lacking:
    """Missing force of one trial, (n, 3): surge, sway [mN], yaw [mN m], and where it acts.

    motion: (n, 7) = x, y [m], core heading [rad], surge, sway speed [m/s], yaw rate [rad/s],
    time [s].
    """

    trial_id: str
    force: Float
    std: Float
    motion: Float


def lacking(campaign: Campaign) -> dict[str, Lacking]:
    """Missing force by trial, from mismatch_detail.json and the tracks."""
    forces = (campaign.mismatch_detail or {}).get("forces", {})
    known = {name: entry for name, entry in forces.items() if name in campaign.tracks}
    return {name: _one(name, entry, campaign.tracks[name]) for name, entry in known.items()}


def variable(campaign: Campaign, one: Lacking, name: str) -> Float:
    """What a missing force may depend on, (n,), by the name used in mismatch.json."""
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


def put_in_its_place(campaign: Campaign, one: Lacking) -> Float:
    """Force of the extended model's additions in the measured motion, (n, 3).

    m (u'_with - u'_without), m (v'_with - v'_without), I (r'_with - r'_without), with the same
    coefficients in both; mN and mN m; NaN where the detail file has no coefficients.
    """
    told = (campaign.mismatch_detail or {}).get("coefficients", {})
    if "after" not in told:
        return np.full_like(one.force, np.nan)
    trial = campaign.study.trial(one.trial_id)
    power = f"{trial.power_pct:g}"
    models = [_values(_without_additions(told["after"]), power), _values(told["after"], power)]
    before, after = _rates(campaign, one, models)
    robot = campaign.study.setup.robot
    inertia = np.array([robot.mass_kg, robot.mass_kg, robot.yaw_inertia_kg_m2])
    return np.asarray(1000 * inertia * (after - before))


def _without_additions(told: Mapping[str, Any]) -> dict[str, Any]:
    """A fit without its effects; where something has no name, without the nameless terms alone."""
    nameless = any(is_nameless(label) for label in told)
    return {
        label: cell for label, cell in told.items()
        if "." not in label or (nameless and not is_nameless(label))
    }  # fmt: skip


def _one(name: str, entry: Mapping[str, Any], track: Track) -> Lacking:
    times = np.asarray(entry["time_s"], dtype=float)

    def at(values: Float) -> Float:
        return np.interp(times, track.time_s, values)

    psi = at(track.heading_rad)
    vx, vy, c, s = at(track.vx_m_s), at(track.vy_m_s), np.cos(psi), np.sin(psi)
    where = [np.asarray(entry[k], dtype=float) for k in ("x_m", "y_m")]
    motion = [*where, psi, vx * c + vy * s, vy * c - vx * s, at(track.yaw_rate_rad_s), times]
    force = [np.asarray(entry[KEYS[channel]], dtype=float) for channel in CHANNELS]
    std = [np.asarray(entry[f"{channel}_std"], dtype=float) for channel in CHANNELS]
    return Lacking(
        name, 1000 * np.column_stack(force), 1000 * np.column_stack(std), np.column_stack(motion)
    )


def _values(told: Mapping[str, Mapping[str, float]], power: str) -> Float:
    """Full parameter vector of a fit; `C_Da@75` counts for trials at 75 %."""
    coefficients: dict[str, float] = {}
    effects: dict[str, dict[str, float]] = {}
    for label, cell in told.items():
        name, _, group = label.partition("@")
        if group and group != power:
            continue
        effect, _, parameter = name.rpartition(".")
        target = effects.setdefault(effect, {}) if effect else coefficients
        target[parameter] = float(cell["value"])
    return np.asarray(plates().values(coefficients, effects))


def _rates(campaign: Campaign, one: Lacking, models: list[Float]) -> tuple[Float, Float]:
    """Derivatives of surge, sway and yaw rate of two models in the measured motion, (n, 3) each."""
    kernel, n = compiled(plates()), len(one.motion)
    trial = campaign.study.trial(one.trial_id)
    state = np.zeros((n, len(kernel.system.all_states), LANES))
    state[:, :6] = one.motion[:, :6, None]
    values = np.repeat(models[0][:, None], LANES, axis=1)
    values[:, 1] = models[1]
    fixed = constants(
        campaign.study.setup, trial.head_length_m, heading_rad=float(one.motion[0, 2])
    )
    drive = [trial.head_angle_rad, campaign.steady[one.trial_id].flap_hz]
    _, states = propagate(
        kernel,
        state,
        np.repeat(values[None], n, axis=0),
        np.repeat(np.repeat(fixed[None, :, None], LANES, axis=2), n, axis=0),
        times=one.motion[:, 6:] + np.array([[0.0, SPAN_S]]),
        inputs=np.tile(drive, (n, 2, 1)),
        keep_states=True,
    )
    change = (states[:, 1, 3:6, :2] - one.motion[:, 3:6, None]) / SPAN_S
    return change[..., 0], change[..., 1]

"""Keypoints of a swim as a camera sees them, and what a tracker makes of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from .faults import KEYPOINT_NAMES, FrameTimes
from .ideal import OBSERVATION_RATE_HZ, Noise, SimulatedMotion
from .motion import Flow, HiddenLaw, actual_drive
from .optics import Camera, StatedSetup, true_statement
from .robots import Array, ParallelTrials, Robot

GAP_LIKELIHOOD = -1.0
"""Likelihood that marks a point without coordinates."""


@dataclass(frozen=True)
class FilmSetup:
    """Camera, tracker and recoil of a study. Errors in px, times in s, recoil in rad and m."""

    camera: Camera
    white: float
    slow: float
    slow_time: float
    outliers: float
    gaps: float
    recoil: tuple[float, float]
    tail_swing: float
    scorer: str

    def noise(self, fps: float, lanes: ParallelTrials) -> Noise:
        """The same as the ideal detector sees it."""
        per_metre = self.camera.matrix[0, 0] / self.camera.place[2]
        var = self.white**2 * OBSERVATION_RATE_HZ / fps + self.slow**2 * max(
            1.0, 2 * self.slow_time * OBSERVATION_RATE_HZ
        )
        water = np.sqrt((np.abs(lanes.flow) ** 2).sum(0).mean() / 4)
        position = float(np.sqrt(var) / per_metre)
        return Noise(position, 1.4 * position / 0.2, float(water))


def draw_film(rng: np.random.Generator, camera: Camera) -> FilmSetup:
    """A tracker of average quality."""
    return FilmSetup(camera, rng.uniform(0.3, 0.8), rng.uniform(0.1, 0.4), rng.uniform(0.1, 0.35),
                rng.uniform(0.001, 0.012), rng.uniform(0.002, 0.015),
                (np.deg2rad(rng.uniform(0.4, 2.0)), rng.uniform(5e-4, 2.5e-3)),
                np.deg2rad(rng.uniform(14, 28)),
                str(rng.choice(["DLC_resnet50", "DLC_hrnet", "DLC_dlcrnet"])))  # fmt: skip


def frame_times(swim: SimulatedMotion, k: int) -> FrameTimes:
    """Frames of one trial."""
    t = swim.times[: swim.frames[k]]
    return FrameTimes(t, float(t[-1]), k, len(swim.frames))


def actuation_at(swim: SimulatedMotion, times: Array) -> tuple[Array, Array]:
    """Shaft frequency (Hz) and head angle (rad) at times, (times, lanes)."""
    zero = np.zeros(len(swim.frames))
    out = [actual_drive(Flow(t, swim.robot, swim.lanes, zero, zero, np.stack([zero, zero]), zero,
                         zero + 0j), swim.laws) for t in np.maximum(times, 0)]  # fmt: skip
    return np.array([o[0] for o in out]), np.array([o[1] for o in out])


def shaft_turns(
    swim: SimulatedMotion, first: Array, step: float, length: float
) -> tuple[Array, Array]:
    """Times and shaft angle in turns, (times, lanes); at rest before time 0."""
    t = np.arange(0, length + step, step)
    f = actuation_at(swim, t)[0]
    turns = np.vstack([np.zeros_like(f[:1]), np.cumsum(0.5 * step * (f[1:] + f[:-1]), 0)])
    return t, first + turns


def labelled_points(
    swim: SimulatedMotion,
    k: int,
    turns: tuple[Array, Array],
    fault: HiddenLaw | None,
    film: FilmSetup | None,
) -> dict[str, Array]:
    """Labels of a trial in the pool, each (frames,) complex m, and `depth`, `phi`, `psi`.

    film: its recoil and swing of the tail are added.
    """
    m = frame_times(swim, k)
    t = m.t
    at = fault.form.law(m, fault.strength, fault.shape) if _has_stage(fault, "time") else t
    x, y, psi = (CubicSpline(swim.times, swim.states[:, i, k])(np.maximum(at, 0)) for i in range(3))
    phi = np.interp(at, swim.times, actual_head_angles(swim)[:, k])
    z = x + 1j * y
    angle = np.interp(at, turns[0], turns[1][:, k]) * 2 * np.pi
    swing = 0.0
    if film:
        grown = 1 - np.exp(-np.maximum(at, 0) / 0.25)
        psi = psi + film.recoil[0] * grown * np.sin(angle + 0.6)
        z = z + 1j * np.exp(1j * psi) * film.recoil[1] * grown * np.sin(angle - 0.4)
        swing = film.tail_swing * grown * np.sin(angle)
    axis = np.exp(1j * psi)
    nose = np.exp(1j * (psi - phi)) * swim.lanes.head[k]
    out = _labels(swim.robot, z, axis, nose, swing)
    for law in swim.laws:
        if law.form.stage == "centre":
            c = Flow(t, swim.robot, swim.lanes.take(np.array([k])), psi, psi, psi, psi, z, phi=phi)
            out = {name: v + law(c) * axis for name, v in out.items()}
    if _has_stage(fault, "label"):
        for name, offset in fault.form.law(phi, fault.strength, fault.shape).items():
            out[name] = out[name] + offset * axis
    sunk = fault.form.law(m, fault.strength, fault.shape) if _has_stage(fault, "sink") else 0.0
    depth = fault.strength if _has_stage(fault, "depth") else swim.robot.depth
    return out | {"depth": depth + sunk + 0 * t, "phi": phi, "psi": psi}


def actual_head_angles(swim: SimulatedMotion) -> Array:
    """Head angles at the times of the swim, (times, lanes)."""
    return actuation_at(swim, swim.times)[1]


def _has_stage(fault: HiddenLaw | None, stage: str) -> Any:
    return fault is not None and fault.form.stage == stage


def _labels(r: Robot, z: Array, axis: Array, nose: Array, swing: Any) -> dict[str, Any]:
    hinge = z + r.hinge_to_com * axis
    base = z - (r.body_length - r.head_length - r.hinge_to_com) * axis
    base = base - 0.12j * r.tail_length * np.sin(swing) * axis
    tip = base - r.tail_length * axis * np.exp(1j * np.asarray(swing))
    return dict(zip(KEYPOINT_NAMES, (hinge + nose, hinge, z, base, tip), strict=True))


def keypoint_pixels(
    camera: Camera, seen: dict[str, Array], swim: SimulatedMotion, k: int, fault: HiddenLaw | None
) -> Array:
    """Images of the labels, (frames, labels, 2) px, in a camera that may be jolted."""
    px = np.stack([camera.see(seen[name], seen["depth"]) for name in KEYPOINT_NAMES], 1)
    if _has_stage(fault, "picture"):
        move = fault.form.law(frame_times(swim, k), fault.strength, fault.shape)
        centre = np.array(camera.size) / 2
        if fault.form.name == "rotation":  # strength: px at 0.4 of the width from the middle
            turn = np.exp(1j * move / (0.4 * camera.size[0]))[:, None]
            flat = (px - centre) @ np.array([1, 1j]) * turn
            return centre + np.stack([flat.real, flat.imag], -1)
        px = px + np.stack([move.real, move.imag], -1)[:, None, :]
    return px


def stated_setup(film: FilmSetup, robot: Robot, fault: HiddenLaw | None) -> StatedSetup:
    """What study.yaml says, wrong where the fault makes it."""
    depth = fault.strength if _has_stage(fault, "depth") else robot.depth
    out = true_statement(film.camera, depth)
    if _has_stage(fault, "depth") or _has_stage(fault, "stated"):
        out = fault.form.law(out, fault.strength, fault.shape)
    return out


def tracked_keypoints(rng: np.random.Generator, film: FilmSetup, px: Array, fps: float) -> Array:
    """(frames, labels, 3): px with errors, and likelihood. Points not seen have GAP."""
    n, labels, _ = px.shape
    rho = np.exp(-1 / (fps * film.slow_time))
    kicks = film.slow * np.sqrt(1 - rho**2) * rng.normal(size=px.shape)
    slow = np.empty_like(px)
    slow[0] = film.slow * rng.normal(size=px.shape[1:])
    for i in range(1, n):
        slow[i] = rho * slow[i - 1] + kicks[i]
    scale = np.array([1, 1, 1, 1, 1.5])[:, None]
    out = px + scale * film.white * rng.normal(size=px.shape) + slow
    likelihood = 1 - rng.beta(1.2, 60, (n, labels))
    wild = rng.random((n, labels)) < film.outliers
    out[wild] += rng.normal(0, 60, (int(wild.sum()), 2))
    likelihood[wild] = rng.uniform(0.01, 0.55, int(wild.sum()))
    for begin, label in zip(*np.nonzero(rng.random((n, labels)) < film.gaps / 4), strict=True):
        end = begin + int(rng.integers(2, 9))
        likelihood[begin:end, label] = rng.choice([GAP_LIKELIHOOD, 0.02])
    return np.concatenate([out, likelihood[..., None]], -1)

"""A study before noise: trials, true and stated laboratory, paths, exact keypoints."""

from dataclasses import dataclass, replace

import numpy as np

from . import camera as cam
from . import dynamics as dyn
from . import effects as eff

KEYPOINT_NAMES = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")


@dataclass(frozen=True)
class Trial:
    """One trial: nominal condition, hidden errors, starting pose and water (per millisecond)."""

    name: str
    day: int
    power_pct: float
    head_angle: float
    head_length: float
    flap_hz: float
    duration_s: float
    start: tuple[float, float, float]
    servo_error: float
    flap_error: float
    swirl: float
    water: np.ndarray
    light: float


@dataclass(frozen=True)
class StudyWorld:
    """A laboratory with its robot, camera, noise levels, trials and concealed effects."""

    robot: dict[str, float]
    coefficients: dyn.Coefficients
    camera: cam.Camera
    noise: dict[str, float]
    trials: tuple[Trial, ...]
    effects: tuple[eff.Effect, ...]
    depth: float
    corner_height: float
    index: float = 1.333

    def by_name(self) -> dict[str, eff.Effect]:
        """Effects by name."""
        return {e.name: e for e in self.effects}

    def body(self, head: float) -> dyn.BodyParameters:
        """Body with head length ``head`` (m); arm l as in STUDY.md."""
        r = self.robot
        arm = head + r["hinge_to_com_m"] - (r["body_length_m"] + head - r["head_length_m"]) / 4
        core = r["body_length_m"] - r["head_length_m"]
        return dyn.BodyParameters(
            r["mass_kg"], r["yaw_inertia_kg_m2"], head, r["head_span_m"], arm,
            r["hinge_to_com_m"], core, r["tail_length_m"], r["head_length_m"], 2.6, 1.6,
        )  # fmt: skip


def trial_inputs(
    world: StudyWorld, trial: Trial, without: str = ""
) -> tuple[np.ndarray, np.ndarray]:
    """Flapping frequency (Hz) and head angle (rad) per millisecond, optionally without one effect.

    With ``time_offset`` in its second form the log starts first: the believed motor start is late,
    the actual one is not.
    """
    t = eff.step_times(len(trial.water) - 1)
    active = world.by_name()
    if (e := active.get("time_offset")) is not None and e.form.code == 2:
        if without != "time_offset":
            del active["time_offset"]
    else:
        active.pop(without, None)
    f = eff.frequency(active, t, trial.flap_hz * (1 + trial.flap_error))
    if without != "time_offset":
        active.pop(without, None)
    return f, eff.head_angle(active, t, trial.head_angle) + trial.servo_error


def trial_path(world: StudyWorld, trial: Trial, walls: bool = True) -> np.ndarray:
    """States (n, 8) per millisecond, cut 5 cm from a wall (centre of mass or nose + 3 cm)."""
    start = np.zeros(8)
    start[:3] = trial.start
    f, phi = trial_inputs(world, trial)
    k, p = eff.effect_table(world.effects)
    body = world.body(trial.head_length)
    states = dyn.simulate(body, world.coefficients, start, f, phi, trial.water, trial.swirl, k, p)
    if not walls:
        return states
    nose = states[:, :2] + np.stack([np.cos(states[:, 2]), np.sin(states[:, 2])], 1) * (
        trial.head_length + 0.03
    )
    both = np.concatenate([states[:, :2], nose], 1)
    out = (both < 0.05).any(1) | (both > np.array([2.55, 1.55, 2.55, 1.55])).any(1)
    n = int(np.argmax(out)) if out.any() else len(states)
    n = min(n, round(1000 * trial.duration_s) + 1)
    return states[: max((n - 1) // 200 * 200 + 1, 1)]


def keypoint_positions(
    world: StudyWorld, trial: Trial, states: np.ndarray, phi: np.ndarray
) -> np.ndarray:
    """Marked points (n, 5, 2) in the pool (m), with a shifted centre of mass or shifted labels."""
    b, active = world.body(trial.head_length), world.by_name()
    nose = np.exp(1j * states[:, 2])
    axis = np.exp(1j * (states[:, 2] + phi))
    com = states[:, 0] + 1j * states[:, 1]
    if (e := active.get("centre_of_mass_shift")) is not None:
        com = com + axis * (e.strength if e.form.code == 1 else -1j * e.strength)
    hinge = com + b.hinge_to_com * axis
    z = np.stack(
        [
            hinge + b.head * nose,
            hinge,
            com,
            hinge - b.core * axis,
            hinge - (b.core + b.tail) * axis,
        ],
        1,
    )
    if (e := active.get("keypoint_bias")) is not None:
        part, way = ((2, axis), (2, 1j * axis), (0, 1j * nose))[e.form.code - 1]
        z[:, part] += e.strength * way
    return np.stack([z.real, z.imag], -1)


def true_optics(world: StudyWorld, n_trial: int, late: bool) -> tuple[cam.Camera, float, float]:
    """Actual camera, keypoint depth and index in trial ``n_trial`` (``late``: after its 40 %)."""
    active, c = world.by_name(), world.camera
    depth, index, n = world.depth, world.index, len(world.trials)
    if (e := active.get("camera_shift")) is not None:
        displaced = n_trial + late > n // 2
        share = (float(displaced), float(world.trials[n_trial].day > 0), n_trial / (n - 1))
        move = e.strength * share[e.form.code - 1]
        rot = np.array([0.3, -0.2, 0.1]) * move
        lift = (0.2, 1.0, 0.4)[e.form.code - 1]
        c = c._replace(rotvec=c.rotvec + rot, C=c.C + np.array([0.3, 0.2, lift]) * move)
    if (e := active.get("uncorrected_refraction")) is not None:
        depth += e.strength * (1.0, 0.2)[e.form.code - 1]
    return c, depth, index


def stated_optics(
    world: StudyWorld, corners_px: np.ndarray
) -> tuple[cam.Camera, float, float, list]:
    """Camera, depth and index the laboratory states, with the stated pool lengths (m).

    The pose follows from the stated lens and the (stated) images of the pool corners.
    """
    active, c, px = world.by_name(), world.camera, corners_px
    index, size = world.index, [2.6, 1.6]
    if (e := active.get("uncorrected_refraction")) is not None and e.form.code == 2:
        index -= 0.333 * e.strength
    if (e := active.get("scale_error")) is not None:
        if e.form.code == 3:
            px = px.mean(0) + (px - px.mean(0)) / (1 + e.strength)
        else:
            size[0] *= 1 + e.strength
            size[1] *= 1 + e.strength * (1.0, 0.93)[e.form.code - 1]
    if (e := active.get("lens_error")) is not None:
        if e.form.code == 1:
            c = c._replace(dist=(c.dist[0] + e.strength, *c.dist[1:]))
        elif e.form.code == 2:
            c = c._replace(cx=c.cx + 600 * e.strength, cy=c.cy - 400 * e.strength)
        else:
            c = c._replace(fx=c.fx * (1 + e.strength), fy=c.fy * (1 - e.strength))
    fitted = cam.with_fitted_pose(c, cam.pool_corners(*size, world.corner_height), px)
    return fitted, world.depth, index, [*size, px]


def corner_pixels(world: StudyWorld) -> np.ndarray:
    """Exact images (4, 2) of the pool's corner marks."""
    return cam.project_air(world.camera, cam.pool_corners(2.6, 1.6, world.corner_height))


def keypoint_pixels(world: StudyWorld, n_trial: int, xy: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Raw pixels (n, 5, 2) of the marked points ``xy`` (n, 5, 2) at times ``t`` (s)."""
    trial = world.trials[n_trial]
    late = t > 0.4 * trial.duration_s
    out = np.empty_like(xy)
    for flag in (False, True):
        sel = late == flag
        if sel.any():
            c, still, index = true_optics(world, n_trial, flag)
            d = eff.keypoint_depth(world.by_name(), t[sel], trial.flap_hz, still)
            flat = xy[sel].reshape(-1, 2)
            out[sel] = cam.project_water(c, flat, np.repeat(d, 5), index).reshape(-1, 5, 2)
    return out


def stated_clock_rate(world: StudyWorld, n_trial: int) -> float:
    """True seconds that pass in one second of the stated clock."""
    e = world.by_name().get("clock_error")
    if e is None:
        return 1.0
    if e.form.code == 2:
        return 1 + e.strength * (world.trials[n_trial].day > 0)
    return 1 + e.strength


def with_strength(world: StudyWorld, name: str, strength: float) -> StudyWorld:
    """``world`` with the strength of one effect replaced."""
    new = tuple(replace(e, strength=strength) if e.name == name else e for e in world.effects)
    return replace(world, effects=new)

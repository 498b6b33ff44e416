"""What each cause changes in the pose seen from above, for the ideal detector."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np

from .dynamics import Case, head_angles
from .form import Active
from .laws_body import SINKING_SHAPES
from .optics import Camera, calibrated, locate, pixels_per_metre, project


@dataclass(frozen=True)
class Pose:
    """Core centre x + iy, heading and head angle, each (steps, rows), at `times` (steps,)."""

    times: np.ndarray
    centre: np.ndarray
    theta: np.ndarray
    phi: np.ndarray

    def at(self, when: np.ndarray) -> "Pose":
        """The pose at times `when` (steps, rows), by linear interpolation; rest before 0."""
        step = self.times[1] - self.times[0]
        place = np.clip(when / step, 0, len(self.times) - 1.001)
        low = place.astype(int)
        part = place - low
        rows = np.arange(self.theta.shape[1])

        def between(values):
            return values[low, rows] * (1 - part) + values[low + 1, rows] * part

        return replace(
            self, centre=between(self.centre), theta=between(self.theta), phi=between(self.phi)
        )


def true_pose(times: np.ndarray, states: np.ndarray, case: Case) -> Pose:
    """Pose of the centre of mass from states (steps, states, rows)."""
    phi = head_angles(times[:, None], case)
    return Pose(times, states[:, 0] + 1j * states[:, 1], states[:, 2], phi)


def recorded_times(case: Case, frames: np.ndarray) -> np.ndarray:
    """True time (frames, rows) of each frame from the time the study states."""
    when = frames[:, None] + 0.0 * case.trial
    for active in case.active:
        if active.form.stage == "clock":
            when = active.form.law(when, active.p, case.trial)
    return when


def centre_shift(pose: Pose, active: Active, case: Case) -> np.ndarray:
    """Where the label core_center lies relative to the shifted centre of mass, pool axes."""
    s = SimpleNamespace(phi=pose.phi, head=case.head, b=case.robot)
    return -active.form.law(s, active.p) * np.exp(1j * (pose.theta + pose.phi))


def _stacked(centre, theta, phi) -> np.ndarray:
    centre, theta, phi = np.broadcast_arrays(centre, theta + 0.0, phi + 0.0)
    return np.stack([centre.real, centre.imag, theta, phi])


def _clock(pose: Pose, active: Active, case: Case, _camera) -> np.ndarray:
    when = active.form.law(pose.times[:, None], active.p, case.trial)
    seen = pose.at(when)
    return _stacked(seen.centre - pose.centre, seen.theta - pose.theta, seen.phi - pose.phi)


def _label(pose: Pose, active: Active, case: Case, _camera) -> np.ndarray:
    core, tip = active.form.law(pose.phi, active.p)
    tilt = tip.imag / case.head
    return _stacked(core * np.exp(1j * (pose.theta + pose.phi)), tilt, -tilt)


def _camera_displacement(pose: Pose, active: Active, case: Case, camera: Camera) -> np.ndarray:
    shift, turn = active.form.law(pose.times[:, None], active.p, case.trial)
    middle = camera.size[0] / 2 + 0.5j * camera.size[1]
    moved = np.conj(shift) / pixels_per_metre(camera) - 1j * turn * (pose.centre - middle)
    return _stacked(moved, 0 * pose.theta - turn, 0 * pose.phi)


def _centre(pose: Pose, active: Active, case: Case, _camera) -> np.ndarray:
    return _stacked(centre_shift(pose, active, case), 0 * pose.theta, 0 * pose.phi)


def _sinking(pose: Pose, active: Active, _case, camera: Camera) -> np.ndarray:
    depth = active.p.amp * SINKING_SHAPES[active.form.form](pose.times[:, None])
    foot = camera.position[0] + 1j * camera.position[1]
    shrink = depth / (camera.index * camera.position[2])
    return _stacked(-(pose.centre - foot) * shrink, 0 * pose.theta, 0 * pose.phi)


def _terms(x, y):
    return np.stack([x**i * y**j for i in range(6) for j in range(6 - i)], axis=-1)


def displacement(camera: Camera, stated: Camera):
    """Function (x, y) in half pool sizes -> complex displacement by reading with `stated`.

    A polynomial of fifth degree fitted over the pool.
    """
    a, b = (g.ravel() for g in np.meshgrid(np.linspace(-1, 1, 13), np.linspace(-1, 1, 9)))
    half = np.array(camera.size) / 2
    points = np.column_stack([(1 + a) * half[0], (1 + b) * half[1], np.full_like(a, -camera.depth)])
    pixels = project(camera, points)
    moved = locate(calibrated(stated), pixels) - locate(calibrated(camera), pixels)
    weights, *_ = np.linalg.lstsq(_terms(a, b), moved @ np.array([1, 1j]), rcond=None)
    return lambda x, y: _terms(x, y) @ weights


def _camera_change(pose: Pose, active: Active, case: Case, camera: Camera) -> np.ndarray:
    half = np.array(camera.size) / 2
    amps = np.broadcast_to(active.p.amp, pose.theta.shape[1:]).reshape(-1, case.trials)
    centre, theta = (v.reshape(len(v), -1, case.trials) for v in (pose.centre, pose.theta))
    reach = 0.25 * case.robot.length * np.exp(1j * theta)
    moved, turned = np.empty_like(centre), np.empty_like(theta)
    for k, amp in enumerate(amps[:, 0]):
        stated = active.form.law(camera, active.scaled(amp * active.p.sign).p)
        field = displacement(camera, stated)

        def shifted(z, field=field):
            return field(z.real / half[0] - 1, z.imag / half[1] - 1)

        moved[:, k] = shifted(centre[:, k])
        stretch = shifted(centre[:, k] + reach[:, k]) - shifted(centre[:, k] - reach[:, k])
        turned[:, k] = np.angle(1 + stretch / (2 * reach[:, k]))
    return _stacked(
        moved.reshape(pose.centre.shape), turned.reshape(pose.theta.shape), 0 * pose.phi
    )


_CHANGES = {
    "clock": _clock,
    "label": _label,
    "displacement": _camera_displacement,
    "centre": _centre,
    "camera": _camera_change,
}


def observation_change(pose: Pose, case: Case, index: int, camera: Camera) -> np.ndarray:
    """Change (4, steps, rows) of the observed x, y, theta and phi by form number `index`."""
    active = case.active[index]
    if active.form.stage == "servo":
        without = head_angles(pose.times[:, None], case, frozenset({index}))
        return _stacked(0 * pose.centre, 0 * pose.theta, pose.phi - without)
    if active.form.cause == "sinking":
        return _sinking(pose, active, case, camera)
    if active.form.stage in _CHANGES:
        return _CHANGES[active.form.stage](pose, active, case, camera)
    return _stacked(0 * pose.centre, 0 * pose.theta, 0 * pose.phi)


def beat_frequency_change(case: Case, index: int, times: np.ndarray) -> np.ndarray:
    """Relative error of the tail-beat frequency seen in the video, per row."""
    active = case.active[index]
    if active.form.cause != "clock_error":
        return np.zeros(len(case.trial))
    t = times[:, None]
    when = active.form.law(t, active.p, case.trial) + 0 * t
    return np.mean(np.diff(when, axis=0) / np.diff(t, axis=0), axis=0) - 1 + 0.0 * case.trial

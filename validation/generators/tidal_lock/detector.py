"""Sigma at which an ideal detector sees each cause.

Every cause acts as an additional acceleration along the path swum with it and as a change of
the observed pose. A Kalman filter that knows the water's motion and the tracking noise whitens
its response; the six coefficients, every other cause, and for each trial the servo error, the
frequency error and the starting state are projected out.
"""

from dataclasses import dataclass, replace

import numpy as np

from .dynamics import Case, flow_rates
from .observation import beat_frequency_change, observation_change, true_pose
from .optics import Camera, pixels_per_metre
from .robot import COEFFICIENTS

STRIDE = 4  # simulation steps between filter steps
SERVO_STD = np.radians(0.3)
FREQUENCY_STD = 0.003
BEAT_STD = 0.002  # relative precision of the beat frequency in the video of one trial


@dataclass(frozen=True)
class Noise:
    """Tracking noise in px and s, and the frame rate."""

    white: float
    slow: float
    slow_time: float
    fps: float


def accelerations(case: Case, t, z, skip: frozenset[int] = frozenset()) -> np.ndarray:
    """World and yaw accelerations (3, steps, rows)."""
    return flow_rates(t, z, case, skip)[3:6]


def _columns(case: Case, t, z, chosen: list[int]) -> np.ndarray:
    """Accelerations (columns, 3, steps, rows): causes, coefficients, servo, frequency."""
    full = accelerations(case, t, z)
    columns = [full - accelerations(case, t, z, frozenset({i})) for i in chosen]
    for name in COEFFICIENTS:
        more = {**case.coefficients, name: 1.01 * case.robot.coefficients[name]}
        columns.append((accelerations(replace(case, coefficients=more), t, z) - full) / 0.01)
    turned = replace(case, phi=case.phi + 1e-3)
    columns.append((accelerations(turned, t, z) - full) / 1e-3)
    faster = replace(case, frequency=case.frequency * 1.001)
    columns.append((accelerations(faster, t, z) - full) / 1e-3)
    return np.stack(columns)


def _transition(case: Case, t, z, h: float, correlations: tuple[float, float]) -> np.ndarray:
    """State transitions (steps, rows, 11, 11): six states, water (2), slow tracking error (3)."""
    full = accelerations(case, t, z)
    steps, rows = full.shape[1:]
    A = np.zeros((steps, rows, 11, 11))
    A[..., [0, 1, 2], [3, 4, 5]] = 1.0
    sizes = 1e-5 * np.array([1, 1, 10, 1, 1, 10]) * case.robot.length
    for m, size in enumerate(sizes):
        perturbed = z.copy()
        perturbed[m] += size
        A[..., 3:6, m] = np.moveaxis((accelerations(case, t, perturbed) - full) / size, 0, -1)
    A[..., 3:6, 6:8] = -A[..., 3:6, 3:5]
    water, slow = correlations
    A[..., [6, 7], [6, 7]] = -1 / water
    A[..., [8, 9, 10], [8, 9, 10]] = -1 / slow
    half = np.clip(A, -60, 60) * h / 4
    result = term = np.broadcast_to(np.eye(11), A.shape)
    for order in range(1, 6):
        term = term @ half / order
        result = result + term
    result = result @ result
    return result @ result


def _noise_levels(case: Case, camera: Camera, noise: Noise, h: float):
    """Standard deviations of a block of frames: white and slow (x, y, theta), and phi."""
    frames = max(noise.fps * h, 1.0)
    metre = 1 / pixels_per_metre(camera)
    head, aft = case.robot.head, case.robot.aft + case.robot.hinge_to_com
    lever = np.sqrt(2) / head
    white = noise.white * metre / np.sqrt(frames) * np.array([1, 1, lever])
    slow = noise.slow * metre * np.array([1, 1, lever])
    both = np.hypot(noise.white / np.sqrt(frames), noise.slow * np.sqrt(2 * noise.slow_time / h))
    return white, slow, both * metre * np.sqrt(2 / head**2 + 2 / aft**2)


def _whitened(transition, forcing, change, levels, process) -> np.ndarray:
    """Whitened innovations (steps, rows, 3, columns) of all columns."""
    white, initial = levels
    steps, rows = transition.shape[:2]
    columns = forcing.shape[-1]
    H = np.zeros((3, 11))
    H[[0, 1, 2, 0, 1, 2], [0, 1, 2, 8, 9, 10]] = 1.0
    P = np.broadcast_to(np.diag(initial), (rows, 11, 11)).copy()
    e = np.zeros((rows, 11, columns))
    result = np.empty((steps, rows, 3, columns))
    for k in range(steps):
        S = H @ P @ H.T + np.diag(white**2)
        innovation = H @ e + change[k]
        result[k] = np.linalg.solve(np.linalg.cholesky(S), innovation)
        gain = np.swapaxes(np.linalg.solve(S, H @ P), 1, 2)
        P = P - gain @ (H @ P)
        e = transition[k] @ (e - gain @ innovation) + forcing[k]
        P = transition[k] @ P @ np.swapaxes(transition[k], 1, 2) + process
        P = 0.5 * (P + np.swapaxes(P, 1, 2))
    return result


def _information(times, states, case, *, valid, chosen, instruments) -> np.ndarray:
    """Fisher information (rows, columns, columns) of causes, coefficients, servo, frequency."""
    camera, noise, ambient = instruments
    t, z = times[::STRIDE, None], np.moveaxis(states[::STRIDE], 1, 0)
    h = times[STRIDE]
    pose = true_pose(times, states, case)
    a = _columns(case, t, z, chosen)
    columns = len(a)
    a = np.moveaxis(a, (0, 1), (3, 2))
    forcing = np.zeros((*a.shape[:2], 11, columns))
    forcing[:, :, 3:6], forcing[:, :, :3] = a * h, a * h**2 / 2
    change = np.zeros((*a.shape[:2], 4, columns))
    for column, index in enumerate(chosen):
        seen = observation_change(pose, case, index, camera)[:, ::STRIDE]
        change[..., column] = np.moveaxis(seen, 0, -1)
    change[:, :, 3, -2] = 1.0
    transition = _transition(case, t, z, h, (ambient.correlation, noise.slow_time))
    white, slow, phi_std = _noise_levels(case, camera, noise, h)
    still = np.array([0.01, 0.01, 0.02]) ** 2
    water = np.full(2, ambient.speed**2 / 2)
    initial = np.concatenate([np.full(3, 1.0), still, water, slow**2])
    jitter = (np.array([0.004, 0.004]) * ambient.speed) ** 2
    yaw = (0.02 * ambient.speed / case.robot.length) ** 2 * h
    process = np.diag(
        np.concatenate(
            [
                np.zeros(3),
                jitter * h,
                [yaw],
                water * (1 - np.exp(-2 * h / ambient.correlation)),
                slow**2 * (1 - np.exp(-2 * h / noise.slow_time)),
            ]
        )
    )
    white_responses = _whitened(transition, forcing, change[:, :, :3], (white, initial), process)
    responses = np.concatenate([white_responses, change[:, :, 3:] / phi_std], axis=2)
    responses = np.where(valid[::STRIDE, :, None, None], responses, 0.0)
    information = np.einsum("krci,krcj->rij", responses, responses)
    beats = np.zeros((len(case.trial), columns))
    for column, index in enumerate(chosen):
        beats[:, column] = beat_frequency_change(case, index, times[::STRIDE]) / BEAT_STD
    return information + beats[:, :, None] * beats[:, None, :]


def sigmas(times, states, case: Case, *, valid, chosen: list[int], instruments) -> np.ndarray:
    """Detection sigma (variants, chosen) of the forms number `chosen`.

    `states` (steps, states, variants x trials); `valid` (steps, rows) marks usable samples;
    `instruments` is (camera, noise, ambient water).
    """
    information = _information(
        times, states, case, valid=valid, chosen=chosen, instruments=instruments
    )
    prior = np.diag([1 / SERVO_STD**2, 1 / FREQUENCY_STD**2])
    own, shared = information[:, -2:, -2:] + prior, information[:, -2:, :-2]
    reduced = information[:, :-2, :-2] - np.swapaxes(shared, 1, 2) @ np.linalg.solve(own, shared)
    totals = reduced.reshape(-1, case.trials, *reduced.shape[1:]).sum(axis=1)
    return np.array([[_seen(total, j) for j in range(len(chosen))] for total in totals])


def _seen(total: np.ndarray, j: int) -> float:
    """Square root of the information on column j left after projecting out the others."""
    scale = np.sqrt(np.diag(total)) + 1e-12
    matrix = total / np.outer(scale, scale)
    others = np.delete(np.arange(len(matrix)), j)
    block = matrix[np.ix_(others, others)] + 1e-10 * np.eye(len(others))
    left = matrix[j, j] - matrix[j, others] @ np.linalg.solve(block, matrix[others, j])
    return float(scale[j] * np.sqrt(max(left, 0.0)))

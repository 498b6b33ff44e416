"""Path error that remains after the published model is fitted to the motion with a law.

The path is cut into segments of 3 s. The published model (with the fin, if the robot has one; its
area and arm are free) is fitted to positions and headings of all segments at once by Gauss-Newton:
the coefficients are common, and each segment has its own first state. The rms distance that remains
is the path error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .body_laws import depth_gained
from .form import Array, HiddenLaw, Runs
from .head_laws import mass_shift
from .motion import STATE_SIZE, integrate
from .robots import Robot
from .trials import PATH_RATE
from .water import ResidualWater

SEGMENT_SAMPLES = 30
LEAST_SAMPLES = 12
"""Samples that a segment must exceed."""
STEP, STEPS_PER_SAMPLE = 1 / 30, 3
STATE_STEPS = np.array([0.002, 0.002, 0.02, 0.01, 0.01, 0.05])
"""Steps of the numerical derivative by a first state: m, m, rad, m/s, m/s, rad/s."""
STATE_PRIOR = np.array([0.1, 0.1, 0.5, 0.2, 0.2, 2.0])
"""Standard deviations of a first state about the true one, in the same units."""
COEFFICIENT_STEP = 0.01
"""Relative step of the numerical derivative by a coefficient; its prior has the deviation 1."""
HEADING_NOISE_M = 0.1
"""Distance (m) by which the noise of a point is divided to that of a heading."""
LOST_PATH_ERROR_M = 1.0
"""Path error where the motion is not finite."""
MAX_ROUNDS = 5


def _observed(
    path: Array, runs: Runs, robot: Robot, laws: Sequence[HiddenLaw], camera: Array
) -> Array:
    """Positions and headings (samples, runs, 3) of the core centre as a camera would place them."""
    z, psi = path[:, 0] + 1j * path[:, 1], path[:, 2]
    times = np.arange(len(path)) / PATH_RATE
    below = camera[0] + 1j * camera[1]
    for law in laws:
        if law.name == "centre_of_mass_shift":
            z = z - mass_shift(robot, runs.head, law) * np.exp(1j * psi)
        if law.name == "sinking":
            shrink = depth_gained(times, law)[:, None] / (1.33 * camera[2])
            z = below + (z - below) * (1 - shrink)
    return np.stack([z.real, z.imag, psi], -1)


class RefitBench:
    """Simulates trials on a coarse grid, and refits the published model to them.

    noise: error of a tracked point, m. camera: its position (3,), m. model: the robot that is
    fitted, if another. trial: trial of each segment (segments,).
    """

    def __init__(
        self, robot: Robot, runs: Runs, start: Array, duration: Array,
        *, noise: float, camera: Array, model: Robot | None = None,
    ) -> None:  # fmt: skip
        self.robot, self.runs, self.start, self.duration = robot, runs, start, duration
        self.noise, self.camera, self.model = noise, camera, model or robot
        self._samples = (duration * PATH_RATE).astype(int)
        pieces = [
            (trial, first)
            for trial, count in enumerate(self._samples)
            for first in range(0, count - LEAST_SAMPLES, SEGMENT_SAMPLES)
        ]
        self.trial, self._first = (np.array(v) for v in zip(*pieces, strict=True))
        grid = self._first[None] + np.arange(SEGMENT_SAMPLES + 1)[:, None]
        self._inside = grid <= self._samples[self.trial][None]
        self._grid = np.minimum(grid, self._samples.max())

    @property
    def segments(self) -> int:
        """Number of segments of all trials."""
        return len(self.trial)

    def judged_by(self, model: Robot) -> RefitBench:
        """The same trials, to which another robot is fitted."""
        return RefitBench(
            self.robot, self.runs, self.start, self.duration,
            noise=self.noise, camera=self.camera, model=model,
        )  # fmt: skip

    def path(
        self,
        laws: Sequence[HiddenLaw] = (),
        runs: Runs | None = None,
        water: ResidualWater | None = None,
    ) -> Array:
        """States (samples, 8, runs) with these laws."""
        return integrate(
            self.start, runs or self.runs, self.robot, laws=laws, water=water,
            step=STEP, count=int(self._samples.max()), every=STEPS_PER_SAMPLE,
        )  # fmt: skip

    def path_error(
        self,
        laws: Sequence[HiddenLaw] = (),
        runs: Runs | None = None,
        water: ResidualWater | None = None,
    ) -> float:
        """Path error (m) after the refit."""
        path = self.path(laws, runs, water)
        if not np.isfinite(path).all():
            return LOST_PATH_ERROR_M
        seen = _observed(path, self.runs, self.robot, laws, self.camera)
        data = seen[self._grid, self.trial[None]]
        first = path[self._first, :, self.trial].T.copy()
        first[:2] = data[0, :, :2].T
        first[6:] = 0
        rest = self._residuals(data, first)
        return float(np.sqrt((rest[..., :2] ** 2).sum(-1)[self._inside].mean()))

    def _residuals(self, data: Array, first: Array) -> Array:
        """Residuals (samples, segments, 3) of the fit; steps that do not help are shortened."""
        base = replace(self.runs.take(self.trial), begin=self._first / PATH_RATE)
        names = [n for n in base.values if self.model.fin or not n.startswith("fin_")]
        total, local = np.zeros(len(names)), np.zeros((6, self.segments))
        sigma = np.array([self.noise, self.noise, self.noise / HEADING_NOISE_M])
        weight = self._inside[..., None] / sigma
        out = self._moved(base, names, first, total, local)
        for _ in range(MAX_ROUNDS):
            rest, jacobian = (data - out[0]) * weight, (out[1:] - out[:1]) * weight
            step, local_step = gauss_newton_step(rest, jacobian, total, local)
            for share in (1.0, 0.4, 0.1):
                tried = np.clip(total + share * step, -0.9, 4), local + share * local_step
                new = self._moved(base, names, first, *tried)
                if np.square((data - new[0]) * weight).sum() < np.square(rest).sum():
                    total, local, out = *tried, new
                    break
            else:
                break
        return (data - out[0]) * self._inside[..., None]

    def _moved(
        self, base: Runs, names: Sequence[str], first: Array, total: Array, local: Array
    ) -> Array:
        """Observations (1 + parameters, samples, segments, 3) of the model.

        First as it is, then with one parameter after the other moved. total: relative changes of
        the coefficients. local: changes of the first states (6, segments).
        """
        count, g = self.segments, len(names)
        moves = 1 + g + 6
        runs = base.take(np.tile(np.arange(count), moves))
        state = np.tile(first, (1, moves)).reshape(STATE_SIZE, moves, count)
        shift = np.tile(local[:, None], (1, moves, 1))
        for j in range(6):
            shift[j, 1 + g + j] += STATE_STEPS[j]
        state[:6] += shift
        values = {}
        for i, name in enumerate(names):
            factor = np.full((moves, count), 1 + total[i])
            factor[1 + i] += COEFFICIENT_STEP
            values[name] = runs.values[name] * factor.ravel()
        out = integrate(
            state.reshape(STATE_SIZE, -1), replace(runs, values=values), self.model,
            step=STEP, count=SEGMENT_SAMPLES, every=STEPS_PER_SAMPLE,
        )[:, :3]  # fmt: skip
        return out.reshape(SEGMENT_SAMPLES + 1, 3, moves, count).transpose(2, 0, 3, 1)


def gauss_newton_step(
    rest: Array, jacobian: Array, total: Array, local: Array
) -> tuple[Array, Array]:
    """Step of the common parameters (g,) and of those of the segments (6, segments), with priors.

    The parameters of each segment are eliminated by a QR decomposition.
    """
    g = len(total)
    common, right = np.diag(np.full(g, COEFFICIENT_STEP**2)), -COEFFICIENT_STEP * total
    own, gains = [], []
    for s in range(rest.shape[1]):
        r = np.concatenate([rest[:, s].ravel(), -local[:, s] / STATE_PRIOR])
        a = np.concatenate([jacobian[:g, :, s].reshape(g, -1).T, np.zeros((6, g))])
        prior = np.diag(STATE_STEPS / STATE_PRIOR)
        b = np.concatenate([jacobian[g:, :, s].reshape(6, -1).T, prior])
        q, triangle = np.linalg.qr(b)
        inverse = np.linalg.pinv(triangle) @ q.T
        clean = a - q @ (q.T @ a)
        common, right = common + clean.T @ clean, right + clean.T @ (r - q @ (q.T @ r))
        own.append(inverse @ r)
        gains.append(inverse @ a)
    x = np.linalg.solve(common + 1e-9 * np.eye(g), right)
    local_step = np.array([o - w @ x for o, w in zip(own, gains, strict=True)]).T
    return COEFFICIENT_STEP * x, local_step * STATE_STEPS[:, None]

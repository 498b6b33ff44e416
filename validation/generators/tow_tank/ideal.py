"""Ideal detector: what a Kalman filter that knows all but the strength sees of a hidden effect.

The filter follows position and heading of each trial by the true law, linearised along the true
path. Its state also holds the restless water, the servo's error and the error of the flapping
frequency of the trial. sigma is the length of the whitened signal that is left after projection
on the coefficients of the baseline and on the strengths of the other hidden laws.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .motion import HiddenLaw, derivative
from .robots import Array, ParallelTrials, Robot

OBSERVATION_RATE_HZ = 15.0
"""Observations that the filter takes in a second."""
WATER_CORRELATION_S = 3.0
"""Correlation time of the restless water, s."""
COEFFICIENTS = ("C_T", "C_D0", "C_Da", "C_La", "C_Ma", "C_Md")


@dataclass(frozen=True)
class SimulatedMotion:
    """Motion of all trials: states (times, 9, lanes) every frame, and frames used of each."""

    lanes: ParallelTrials
    robot: Robot
    laws: Sequence[HiddenLaw]
    times: Array
    states: Array
    frames: Array


@dataclass(frozen=True)
class Noise:
    """Of position (m) and heading (rad) in a frame, as if white; of the water (m/s)."""

    position: float
    heading: float
    water: float


def detectability_sigmas(
    swim: SimulatedMotion,
    noise: Noise,
    effects: Sequence[Sequence[HiddenLaw]],
    seen: Sequence[Array] = (),
) -> Array:
    """Detectability of each group of laws, then of each direct change of x, y and psi.

    effects: laws of the swim that belong together. seen: (times, 3, lanes).
    """
    step = max(1, round((1 / OBSERVATION_RATE_HZ) / (swim.times[1] - swim.times[0])))
    pick = np.arange(0, len(swim.times), step)
    line = _LinearisedMotion(swim, pick)
    every = _LinearisedMotion(swim, np.arange(len(swim.times)))
    forces = [_mean_until_next(every.without(group), pick) for group in effects]
    forces += [line.coefficient(name) for name in COEFFICIENTS]
    nothing = np.zeros((len(pick), 3, len(swim.frames)))
    count = len(effects)
    columns = [(f, nothing) for f in forces[:count]]
    columns += [(0 * forces[0] if forces else nothing, s[pick]) for s in seen]
    columns += [(f, nothing) for f in forces[count:]]
    white = _whitened(line, noise, columns, step * (swim.times[1] - swim.times[0]))
    out = []
    for k in range(count + len(seen)):
        rest = np.delete(white, k, axis=1)
        rest = rest / np.maximum(np.linalg.norm(rest, axis=0), 1e-12)
        fit = np.linalg.lstsq(rest, white[:, k], rcond=1e-9)[0]
        out.append(float(np.linalg.norm(white[:, k] - rest @ fit)))
    return np.array(out)


def _mean_until_next(rate: Array, pick: Array) -> Array:
    """Mean of a rate between one pick and the next: effects of the start last a few frames."""
    between = 0.5 * (rate[1:] + rate[:-1])
    total = np.concatenate([np.zeros_like(rate[:1]), np.cumsum(between, 0)])
    step = pick[1] - pick[0]
    end = np.minimum(pick + step, len(rate) - 1)
    return (total[end] - total[pick]) / step


class _LinearisedMotion:
    """Accelerations along the true path and their derivatives, all times at once."""

    def __init__(self, swim: SimulatedMotion, pick: Array) -> None:
        n = len(swim.frames)
        self.shape = (len(pick), n)
        self.times = np.repeat(swim.times[pick], n)
        self.state = swim.states[pick].transpose(1, 0, 2).reshape(9, -1)
        self.lanes = swim.lanes.take(np.tile(np.arange(n), len(pick)))
        self.robot, self.laws = swim.robot, list(swim.laws)
        self.used = pick[:, None] < swim.frames
        self.base = self._at()

    def _at(
        self,
        state: Array | None = None,
        lanes: ParallelTrials | None = None,
        robot: Robot | None = None,
        laws: Sequence[HiddenLaw] | None = None,
    ) -> Array:
        rate = derivative(
            self.times, self.state if state is None else state, lanes or self.lanes,
            robot or self.robot, self.laws if laws is None else laws,
        )  # fmt: skip
        return rate[3:6].reshape(3, *self.shape).transpose(1, 0, 2)

    def without(self, group: Sequence[HiddenLaw]) -> Array:
        """Accelerations that these laws cause, (times, 3, lanes)."""
        return self.base - self._at(laws=[law for law in self.laws if law not in group])

    def coefficient(self, name: str) -> Array:
        """Change of the accelerations for a relative change of a coefficient."""
        more = replace(self.robot, **{name: 1.01 * getattr(self.robot, name)})
        return (self._at(robot=more) - self.base) / 0.01

    def jacobian(self) -> Array:
        """By x, y, psi, v_x, v_y, r, water x, water y, servo, log f: (times, lanes, 3, 10)."""
        columns = []
        for k, eps in enumerate((1e-3, 1e-3, 1e-4, 1e-4, 1e-4, 1e-4)):
            moved = self.state.copy()
            moved[k] += eps
            columns.append((self._at(state=moved) - self.base) / eps)
        lanes = self.lanes
        for more in (
            replace(lanes, flow_bias=lanes.flow_bias + 1e-4),
            replace(lanes, flow_bias=lanes.flow_bias + 1e-4j),
            replace(lanes, servo_error=lanes.servo_error + 1e-4),
            replace(lanes, flap=lanes.flap * (1 + 1e-4)),
        ):
            columns.append((self._at(lanes=more) - self.base) / 1e-4)
        return np.stack(columns, -1).transpose(0, 2, 1, 3)


def _whitened(
    line: _LinearisedMotion, noise: Noise, columns: Sequence[tuple[Array, Array]], dt: float
) -> Array:
    """Innovations of each column in units of their deviation, (times x lanes x 3, columns)."""
    J = line.jacobian()
    n, lanes = line.shape
    A = np.zeros((n, lanes, 10, 10))
    A[..., [0, 1, 2], [3, 4, 5]] = 1
    A[..., 3:6, :] = J
    A[..., [6, 7], [6, 7]] = -1 / WATER_CORRELATION_S
    F = np.eye(10) + dt * A + 0.5 * dt**2 * A @ A
    Q = np.zeros((10, 10))
    Q[[6, 7], [6, 7]] = 2 * noise.water**2 * dt / WATER_CORRELATION_S
    Q[[3, 4, 5], [3, 4, 5]] = np.array([1e-4, 1e-4, 1e-3]) ** 2 * dt  # eddies
    R = np.diag([noise.position, noise.position, noise.heading]) ** 2
    P = np.diag([1.0, 1.0, 1.0, 1e-3, 1e-3, 5e-3, noise.water, noise.water, 5e-3, 3e-3]) ** 2
    P = np.tile(P, (lanes, 1, 1))
    push = np.stack([c[0] for c in columns], -1).transpose(0, 2, 1, 3)  # (times, lanes, 3, cols)
    seen = np.stack([c[1] for c in columns], -1).transpose(0, 2, 1, 3)
    x = np.zeros((lanes, 10, len(columns)))
    out = np.zeros((n, lanes, 3, len(columns)))
    for k in range(n):
        S = P[:, :3, :3] + R
        gain = np.linalg.solve(S, P[:, :3, :]).transpose(0, 2, 1)
        innovation = seen[k] - x[:, :3]
        root = np.linalg.cholesky(S)
        out[k] = np.linalg.solve(root, innovation) * line.used[k][:, None, None]
        # the column pushes the true path, the filter does not know it: x is estimate minus truth
        x = x + gain @ innovation
        P = P - gain @ P[:, :3, :]
        x = F[k] @ x
        x[:, 3:6] -= dt * push[k]
        x -= 0.5 * dt**2 * A[k, :, :, 3:6] @ push[k]
        P = F[k] @ P @ F[k].transpose(0, 2, 1) + Q
        P = 0.5 * (P + P.transpose(0, 2, 1))
    return out.reshape(-1, len(columns))

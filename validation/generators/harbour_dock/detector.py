"""The ideal detector: whitened, refitted length of the trajectory change of a cause.

Seen at every `STEP` of a trial are x, y (m), heading, head angle (rad) and apparent length (m),
(times, 5).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from .engine import DT, Motion, Variants, simulate, variant_set
from .law import Law
from .plan import KNOT, Trials
from .robots import COEFFICIENTS, Robot
from .view import Track, View, observe, with_laws

STEP = 0.26
"""s."""
STRIDE = round(STEP / DT)
FIN_VALUES = ("fin_strength", "fin_behind")
NUDGE, SIZE_NUDGE = 0.004, 0.02
"""Relative, of coefficients and of the sizes of other causes."""
SCALE_ERROR, END_LABEL_ERROR = 8e-4, 5e-3
"""Prior standard deviations, relative: of the scale of each axis, of the apparent length."""
ERRORS = 8
"""Six of the starting state, servo, thrust."""
POSITION_ERROR, HEADING_ERROR = 0.02, 0.02
"""Nudges of the start, m and rad."""
FREE_START = 3.0
"""Factor on those, with which start and heading are as good as free."""


def _label_rows(trials: Trials) -> list[np.ndarray]:
    """Numbers of the steps inside each trial's duration."""
    return [np.arange(int(duration / STEP) + 1) for duration in trials.duration]


@dataclass(frozen=True)
class _Seen:
    """What a perfect camera sees of a motion, given at every `STEP`."""

    motion: Motion
    robot: Robot
    trials: Trials
    rows: list[np.ndarray]

    def of(self, variant: int, trial: int) -> np.ndarray:
        """(times, 5), with labels at core_center."""
        motion, rows = self.motion, self.rows[trial]
        at = (rows, variant, trial)
        robot = self.robot
        length = self.trials.head[trial] + robot.hinge_to_com + robot.com_to_tail
        return np.column_stack([
            motion.x[at] - motion.shift_x[at], motion.y[at] - motion.shift_y[at],
            motion.theta[at], motion.phi[at], np.full(len(rows), length),
        ])  # fmt: skip

    def all_of(self, variant: int) -> list[np.ndarray]:
        """For every trial."""
        return [self.of(variant, trial) for trial in range(len(self.rows))]


def _error_variants(robot: Robot, trials: Trials, laws: list[Law]) -> tuple[Variants, int, float]:
    """Truth, each error of the start, servo, thrust, water in x and y at each knot; knots; nudge.

    The nudge of the water is in m/s, all else is moved by its standard deviation.
    """
    knots = int(np.ceil(trials.duration.max() / KNOT)) + 1
    variants = variant_set(robot, trials, laws, 1 + ERRORS + 2 * knots)
    noise = trials.noise
    nudge = 2.0 * noise["water_sd_m_s"] / 4
    start_speed, start_rate = noise["start_speed_sd_m_s"], noise["start_yaw_rate_sd_rad_s"]
    start = [POSITION_ERROR, POSITION_ERROR, HEADING_ERROR, start_speed, start_speed, start_rate]
    for i in range(6):
        variants.start[1 + i, :, i] += start[i]
    variants.head_error[7] += np.deg2rad(noise["servo_sd_deg"])
    variants.thrust_error[8] += noise["thrust_sd_rel"]
    for knot in range(knots):
        variants.water[1 + ERRORS + knot, :, knot] += nudge
        variants.water[1 + ERRORS + knots + knot, :, knot] += 1j * nudge
    return variants, knots, nudge


class Whitener:
    """Cholesky factors per trial of the covariance of all errors.

    spread: standard deviation of the place at the end of a trial, m, from starting rates, servo and
    thrust.
    """

    def __init__(self, view: View, laws: list[Law], noise: dict[str, float]) -> None:
        robot, trials = view.robot, view.trials
        variants, knots, nudge = _error_variants(robot, trials, laws)
        motion = simulate(robot, trials, laws, variants, STRIDE)
        lag = np.abs(np.subtract.outer(np.arange(knots), np.arange(knots))) * KNOT
        water = (trials.noise["water_sd_m_s"] / nudge) ** 2 * np.exp(
            -lag / trials.noise["water_time_s"])  # fmt: skip
        label = float(np.hypot(noise["white_px"] / 2, noise["correlated_px"]))
        label = view.camera.metres_per_px * label
        self.rows = _label_rows(trials)
        self.factors: list[np.ndarray] = []
        self.spread = np.zeros(len(trials.phi))
        seen = _Seen(motion, robot, trials, self.rows)
        for trial, rows in enumerate(self.rows):
            effects = _effects(seen, trial, ERRORS + 2 * knots)
            covariance = _tracking(robot, trials.head[trial], rows * STEP, label, noise)
            covariance += effects[:, :ERRORS] @ effects[:, :ERRORS].T
            for first in (ERRORS, ERRORS + knots):
                of_water = effects[:, first : first + knots]
                covariance += of_water @ water @ of_water.T
            drift = np.diag(effects[:, 3:8] @ effects[:, 3:8].T).reshape(len(rows), 5)
            self.spread[trial] = np.sqrt(drift[-1, 0] + drift[-1, 1])
            jitter = 1e-12 * np.eye(5 * len(rows))
            self.factors.append(np.linalg.cholesky(covariance + jitter))

    def white(self, parts: list[np.ndarray]) -> np.ndarray:
        """Whitened long vector of per-trial arrays (times, 5)."""
        return np.concatenate([
            solve_triangular(factor, part.reshape(factor.shape[0], -1), lower=True).reshape(-1)
            for factor, part in zip(self.factors, parts, strict=True)
        ])  # fmt: skip


def _effects(seen: _Seen, trial: int, count: int) -> np.ndarray:
    """Changes of what is seen from the first variant to each of the next, (5 times, count)."""
    truth = seen.of(0, trial)
    changes = [(seen.of(variant, trial) - truth).ravel() for variant in range(1, 1 + count)]
    effects = np.stack(changes, 1)
    effects[:, :3] *= FREE_START
    return effects


def _tracking(
    robot: Robot, head: float, time: np.ndarray, label: float, noise: dict[str, float]
) -> np.ndarray:
    """Covariance of tracking errors; label: standard deviation of one label, m."""
    core = robot.hinge_to_com + robot.com_to_tail
    spread = np.array([label, label, 1.4 * label / head,
                       1.4 * label * np.hypot(1 / head, 1 / core), 2.0 * label])  # fmt: skip
    correlation = np.exp(-np.abs(np.subtract.outer(time, time)) / noise["correlation_s"])
    return np.kron(correlation + 1e-6 * np.eye(len(time)), np.diag(spread**2))


@dataclass
class _Columns:
    """Effects of what is refitted, whitened, with prior standard deviations.

    owner: names of coefficients and fin values, numbers of causes, `calibration`.
    """

    effects: list[np.ndarray] = field(default_factory=list)
    priors: list[float] = field(default_factory=list)
    owners: list[str | int] = field(default_factory=list)

    def add(self, effect: np.ndarray, owner: str | int, prior: float = 1.0) -> None:
        """One more column."""
        self.effects.append(effect)
        self.priors.append(prior)
        self.owners.append(owner)

    def left(self, target: np.ndarray, owners: tuple[str | int, ...]) -> float:
        """Length of `target` after the refit of all columns but those of `owners`."""
        kept = [i for i, owner in enumerate(self.owners) if owner not in owners]
        effects = np.stack(self.effects, 1)[:, kept]
        ridge = np.diag(1 / np.array([self.priors[i] for i in kept]) ** 2)
        normal, seen = effects.T @ effects + ridge, effects.T @ target
        squared = target @ target - seen @ cho_solve(cho_factor(normal), seen)
        length = float(np.sqrt(max(squared, 0.0)))
        return length if np.isfinite(length) else 1e6


class _Batch:
    """Truth, truth without each cause and the fin, and with each refitted number moved."""

    def __init__(self, view: View, fin: list[Law], causes: list[Law], whitener: Whitener) -> None:
        self.view, self.fin, self.causes, self.whitener = view, fin, causes, whitener
        self.laws = fin + causes
        self.names = list(COEFFICIENTS) + (list(FIN_VALUES) if fin else [])
        self.refitted = [k for k, law in enumerate(causes) if law.kind == "physics"]
        self.targets = len(causes) + len(fin)
        self.motion = simulate(view.robot, view.trials, self.laws, self._variants(), 1)
        coarse = self.motion.every(STRIDE)
        self.seen = _Seen(coarse, view.robot, view.trials, whitener.rows)
        self.truth = self.seen.all_of(0)

    def _variants(self) -> Variants:
        count = 1 + self.targets + len(self.names) + len(self.refitted)
        variants = variant_set(self.view.robot, self.view.trials, self.laws, count)
        for k in range(len(self.causes)):
            variants.sizes[len(self.fin) + k][1 + k] = 0.0
        if self.fin:
            variants.values["fin_strength"][1 + len(self.causes)] = 0.0
        at = 1 + self.targets
        for name in self.names:
            variants.values[name][at] *= 1 + NUDGE
            at += 1
        for k in self.refitted:
            variants.sizes[len(self.fin) + k][at] *= 1 + SIZE_NUDGE
            at += 1
        return variants

    def change(self, variant: int) -> np.ndarray:
        """Of the motion as a perfect camera sees it, whitened."""
        pairs = zip(self.seen.all_of(variant), self.truth, strict=True)
        return self.whitener.white([there - here for there, here in pairs])

    def _through_camera(self, sizes: list[float], variant: int) -> list[np.ndarray]:
        view, track = with_laws(self.view, self.laws, sizes), Track(self.motion, variant)
        return [
            observe(view, track, rows * STEP, trial)
            for trial, rows in enumerate(self.whitener.rows)
        ]

    def changes(self) -> list[np.ndarray]:
        """Whitened effect of the removal of every cause."""
        sizes = [law.size for law in self.laws]
        full: list[np.ndarray] | None = None
        found = []
        for k, law in enumerate(self.causes):
            if not law.seen:
                found.append(self.change(1 + k))
                continue
            full = full or self._through_camera(sizes, 0)
            without = list(sizes)
            without[len(self.fin) + k] = 0.0
            less = self._through_camera(without, 0 if law.kind == "measurement" else 1 + k)
            pairs = zip(full, less, strict=True)
            found.append(self.whitener.white([there - here for here, there in pairs]))
        return found

    def columns(self, changes: list[np.ndarray]) -> _Columns:
        """All that is refitted."""
        columns, variant = _Columns(), 1 + self.targets
        for name in self.names:
            columns.add(self.change(variant) / NUDGE, name)
            variant += 1
        for k in self.refitted:
            columns.add(self.change(variant) / SIZE_NUDGE, k)
            variant += 1
        for k, law in enumerate(self.causes):
            if law.kind == "measurement":
                columns.add(changes[k], k)
        for axis in (0, 1):
            middle = self.view.trials.pool[axis] / 2
            columns.add(self._calibration(0.5, axis, middle), "calibration", SCALE_ERROR)
        columns.add(self._calibration(1.0), "calibration", END_LABEL_ERROR)
        return columns

    def _calibration(
        self, of_length: float, axis: int | None = None, middle: float = 0.0
    ) -> np.ndarray:
        """Effect of a relative change of the apparent length, and of the scale of an axis."""
        parts = [np.zeros_like(truth) for truth in self.truth]
        for part, truth in zip(parts, self.truth, strict=True):
            if axis is not None:
                part[:, axis] = truth[:, axis] - middle
            part[:, 4] = of_length * truth[:, 4]
        return self.whitener.white(parts)


def sigmas(view: View, fin: list[Law], causes: list[Law], whitener: Whitener) -> list[float]:
    """Sigma of every cause (and, last, of the fin if there is one).

    Refitted are the coefficients, the fin's numbers and the sizes of the other causes. A cause that
    belongs to the measurement is switched off in the view; its derivative is its whole effect. The
    fin's own numbers are not refitted when the fin is removed.
    """
    batch = _Batch(view, fin, causes, whitener)
    changes = batch.changes()
    columns = batch.columns(changes)
    found = [columns.left(change, (k,)) for k, change in enumerate(changes)]
    if fin:
        found.append(columns.left(batch.change(1 + len(causes)), FIN_VALUES))
    return found

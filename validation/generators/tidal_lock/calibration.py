"""Magnitudes of the causes: the fin from stability, the others from the ideal detector."""

from dataclasses import dataclass, replace

import numpy as np

from .campaign import LONGEST, Campaign, case_of, inside
from .detector import Noise, sigmas
from .dynamics import Case, drive_factor, flow_rates, simulate
from .form import Active, Form, draw_parameters
from .observation import recorded_times
from .optics import Camera
from .robot import Robot
from .water import Ambient

SIGMA_LOW, SIGMA_HIGH = 8.0, 40.0
GRID = 6


@dataclass(frozen=True)
class Tank:
    """All that a study has in common: robot, plan, camera, tracking noise and water."""

    robot: Robot
    campaign: Campaign
    camera: Camera
    noise: Noise
    ambient: Ambient

    @property
    def instruments(self) -> tuple[Camera, Noise, Ambient]:
        """What the detector knows about the observation."""
        return self.camera, self.noise, self.ambient


def straight_growth(robot: Robot, fin: Active | None) -> float:
    """Largest growth rate (1/s) of heading, sideways speed and yaw rate, straight at full power."""
    one = np.ones(1)
    case = Case(
        robot,
        0 * one,
        robot.flap * one,
        robot.head * one,
        np.zeros(1, int),
        1,
        0 * one,
        () if fin is None else (fin,),
    )
    z = np.zeros((6, 1))
    z[3] = robot.speed_ref
    matrix = np.empty((3, 3))
    for column, state in enumerate((2, 4, 5)):
        perturbed = z.copy()
        perturbed[state] = 1e-5
        matrix[:, column] = flow_rates(0.0, perturbed, case)[[2, 4, 5], 0] / 1e-5
    values = np.linalg.eigvals(matrix)
    values = np.delete(values, np.argmin(np.abs(values)))  # turning the whole path
    return float(values.real.max())


def draw_stable_fin(rng: np.random.Generator, robot: Robot, form: Form, trials: int) -> Active:
    """A fin from 1.05 to 3 times the size at which the straight robot becomes stable."""
    fin = draw_parameters(rng, form, trials)
    low, high = 0.0, form.full(robot)
    for _ in range(30):
        middle = 0.5 * (low + high)
        stable = straight_growth(robot, fin.scaled(middle)) < 0
        low, high = (low, middle) if stable else (middle, high)
    return fin.scaled(high * np.exp(rng.uniform(np.log(1.05), np.log(3.0))))


def run(tank: Tank, active: tuple[Active, ...], variants: int = 1):
    """Simulate all trials: (case, times, states, valid samples)."""
    case = case_of(tank.robot, tank.campaign, active, tank.ambient, variants)
    start = np.tile(tank.campaign.start, (1, variants))
    duration = tank.campaign.duration
    times, states = simulate(case, start, min(duration.max() + 0.1, LONGEST + 2))
    valid = recorded(case, times, inside(times, states, tank.robot, np.tile(duration, variants)))
    case = replace(case, logged_ratio=logged_ratio(times, case, np.tile(duration, variants)))
    return case, times, states, valid


def recorded(case: Case, times: np.ndarray, valid: np.ndarray) -> np.ndarray:
    """`valid` (steps, rows) at the times that the recording states instead of the true ones."""
    when = recorded_times(case, times)
    place = np.clip(np.rint(when / times[1]), 0, len(times) - 1).astype(int)
    shown = valid[place, np.arange(valid.shape[1])] & (when < times[-1] - 0.05)
    return np.logical_and.accumulate(shown, axis=0)


def logged_ratio(times: np.ndarray, case: Case, duration: np.ndarray) -> np.ndarray:
    """Median of the drive's factor over each trial, (rows,)."""
    factor = drive_factor(times[:, None], case)
    return np.array([np.median(factor[times <= end, row]) for row, end in enumerate(duration)])


def achieved(tank: Tank, active: tuple[Active, ...], variants: int = 1) -> np.ndarray:
    """Sigma (variants, forms) of each form, the others projected out."""
    if not active:
        return np.zeros((1, 0))
    case, times, states, valid = run(tank, active, variants)
    return sigmas(
        times,
        states,
        case,
        valid=valid,
        chosen=list(range(len(active))),
        instruments=tank.instruments,
    )


def _crossing(magnitudes: np.ndarray, seen: np.ndarray, target: float) -> float | None:
    """Magnitude at which the sigma reaches `target`; proportional below the grid."""
    if seen[0] >= target:
        return float(magnitudes[0] * target / seen[0])
    for k in range(1, len(seen)):
        if seen[k] >= target:
            share = np.log(target / seen[k - 1]) / np.log(seen[k] / seen[k - 1])
            return float(np.exp(np.interp(share, [0, 1], np.log(magnitudes[k - 1 : k + 1]))))
    return None


def at_target(tank: Tank, others: tuple[Active, ...], form: Active, target: float) -> Active | None:
    """The form at the magnitude seen at `target` sigma; None if no plausible one is enough."""
    magnitudes = form.form.full(tank.robot) * np.geomspace(0.02, 1, GRID)
    rows = np.repeat(magnitudes, tank.campaign.trials)
    active = (*others, form.scaled(rows))
    seen = achieved(tank, active, GRID)[:, -1]
    magnitude = _crossing(magnitudes, np.nan_to_num(seen), target)
    return None if magnitude is None else form.scaled(magnitude)


def _corrected(tank: Tank, active: tuple[Active, ...], keep: int, targets: list[float]):
    """One proportional step of every magnitude after the first `keep` towards its target."""
    seen = achieved(tank, active)[0, keep:]
    adjusted = list(active)
    for j, (sigma, target) in enumerate(zip(seen, targets, strict=True), start=keep):
        magnitude = abs(float(active[j].p.amp)) * target / max(sigma, 1e-3)
        limit = active[j].form.full(tank.robot)
        adjusted[j] = active[j].scaled(min(magnitude, limit))
    return tuple(adjusted)


def calibrated_forms(
    rng: np.random.Generator, tank: Tank, fin: tuple[Active, ...], forms: list[Form]
) -> tuple[tuple[Active, ...], np.ndarray] | None:
    """Fin and forms at magnitudes seen at 8 to 40 sigma, and the sigmas; None if out of reach."""
    active = fin
    targets = [float(np.exp(rng.uniform(np.log(9.0), np.log(36.0)))) for _ in forms]
    for form, target in zip(forms, targets, strict=True):
        drawn = draw_parameters(rng, form, tank.campaign.trials)
        found = at_target(tank, active, drawn, target)
        if found is None:
            return None
        active = (*active, found)
    for _ in range(3):
        seen = achieved(tank, active)[0]
        hidden = seen[len(fin) :]
        if np.all((hidden >= SIGMA_LOW) & (hidden <= SIGMA_HIGH)):
            return active, seen
        active = _corrected(tank, active, len(fin), targets)
    return None

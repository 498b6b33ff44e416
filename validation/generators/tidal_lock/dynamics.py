"""Equations of motion of the two-plate robot with any set of forms, integrated by RK4."""

from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np

from .form import Active
from .robot import WATER_DENSITY, Robot

TIME_STEP = 0.02  # s
FAR = 1e3  # bound of all states, met only far outside the pool
BASE_STATES = 6  # x, y, theta, x_dot, y_dot, theta_dot


def still_water(_t, x, _y, _trial):
    """Water at rest."""
    return np.zeros_like(x, complex)


@dataclass(frozen=True)
class Case:
    """Robot, conditions of each row, and the forms at work.

    `phi`, `frequency`, `head`, `trial`, `theta_start` and `logged_ratio` have one value a row;
    `logged_ratio` is the median of the drive's factor, which the log shows as a frequency.
    """

    robot: Robot
    phi: np.ndarray
    frequency: np.ndarray
    head: np.ndarray
    trial: np.ndarray
    trials: int
    theta_start: np.ndarray
    active: tuple[Active, ...] = ()
    ambient: Callable[..., np.ndarray] = still_water
    logged_ratio: np.ndarray | float = 1.0
    coefficients: dict[str, float] = field(default_factory=dict)

    def states(self) -> int:
        """Length of the state vector."""
        return BASE_STATES + sum(a.form.states for a in self.active)


def _geometry(t, z, case: Case) -> SimpleNamespace:
    """Flow state before any law acted."""
    robot = case.robot
    return SimpleNamespace(
        t=t,
        x=z[0],
        y=z[1],
        theta=z[2],
        r=z[5],
        b=robot,
        head=case.head,
        trial=case.trial,
        trials=case.trials,
        theta_start=case.theta_start,
        area=case.head * robot.span,
        arm=robot.arm(case.head),
        power=case.frequency / robot.flap,
    )


def _slots(case: Case) -> list[tuple[Active, slice]]:
    slots, start = [], BASE_STATES
    for active in case.active:
        slots.append((active, slice(start, start + active.form.states)))
        start += active.form.states
    return slots


def _relative_flow(s, z, water) -> None:
    """Velocity relative to the water in world and core axes, angle of attack."""
    relative = z[3] + 1j * z[4] - water
    s.core = np.exp(1j * (s.theta + s.phi))
    s.V = np.abs(relative)
    s.direction = relative / (s.V + 1e-12)
    s.hat = s.direction * np.conj(s.core)
    s.u, s.v = s.V * s.hat.real, s.V * s.hat.imag
    s.ratio = s.V / s.b.speed_ref
    s.alpha = np.where(s.V > 1e-9, np.angle(np.exp(1j * s.theta) * np.conj(s.direction)), 0.0)


def _plate_coefficients(s, case: Case) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """C_L, C_D and C_M of Eqs. 5 to 7."""
    C = {**case.robot.coefficients, **case.coefficients}
    sine, cosine = np.sin(2 * s.alpha), np.cos(2 * s.alpha)
    return C["C_La"] * sine, C["C_D0"] + C["C_Da"] * (1 - cosine), C["C_Ma"] * sine


def _accelerations(s, case: Case, force, moment, masses) -> tuple[np.ndarray, np.ndarray]:
    """Acceleration (world, complex) and yaw acceleration; `force` is in core axes."""
    m, inertia = case.robot.mass, case.robot.inertia
    if masses is None:
        return force * s.core / m, moment / inertia
    a11, a22, a26, a66 = (masses[name] for name in ("a11", "a22", "a26", "a66"))
    X = force.real + (a22 - a11) * s.v * s.r + a26 * s.r**2
    Y = force.imag + (a22 - a11) * s.u * s.r
    N = moment - masses["munk"] * (a22 - a11) * s.u * s.v
    determinant = (m + a22) * (inertia + a66) - a26**2
    ax = X / (m + a11)
    ay = ((inertia + a66) * Y - a26 * N) / determinant
    return (ax + 1j * ay) * s.core, ((m + a22) * N - a26 * Y) / determinant


def flow_rates(t, z, case: Case, skip: frozenset[int] = frozenset()) -> np.ndarray:
    """Time derivative of the state; forms whose index is in `skip` do not act."""
    s = _geometry(t, z, case)
    dz = np.zeros_like(z)
    by_stage: dict[str, list[tuple[Active, slice]]] = {}
    for index, (active, slot) in enumerate(_slots(case)):
        if index not in skip:
            by_stage.setdefault(active.form.stage, []).append((active, slot))
    s.phi, s.frequency = case.phi + 0 * z[0], case.frequency + 0 * z[0]
    for active, _ in by_stage.get("servo", []):
        s.phi = active.form.law(s, s.phi, active.p)
    drives = by_stage.get("drive", [])
    for active, _ in drives:
        s.frequency = s.frequency * active.form.law(s, active.p)
    if skip and not drives:
        s.frequency = s.frequency * case.logged_ratio
    water = case.ambient(t, s.x, s.y, case.trial)
    for active, _ in by_stage.get("water", []):
        water = water + active.form.law(s, active.p)
    _relative_flow(s, z, water)
    acceleration, yaw_acceleration = _loads(s, case, by_stage, z, dz)
    dz[0:3] = z[3:6]
    dz[3], dz[4], dz[5] = acceleration.real, acceleration.imag, yaw_acceleration
    return dz


def _loads(s, case: Case, by_stage, z, dz):
    """Accelerations from thrust, plate forces and all forms; fills the memory's rates in `dz`."""
    coefficients = {**case.robot.coefficients, **case.coefficients}
    s.T = coefficients["C_T"] * 0.5 * WATER_DENSITY * s.area * s.frequency**2
    for active, _ in by_stage.get("thrust", []):
        s.T = s.T * active.form.law(s, active.p)
    s.quasi = _plate_coefficients(s, case)
    C = s.quasi
    for active, slot in by_stage.get("coefficients", []):
        s.memory = z[slot]
        s.quasi = C
        C = active.form.law(s, active.p, C)
        if active.form.states:
            dz[slot] = active.form.rates(s, active.p)
    q = 0.5 * WATER_DENSITY * s.area * s.V**2
    s.plate_force = q * s.direction * (1j * C[0] - C[1])
    normal = (s.plate_force * np.conj(1j * np.exp(1j * s.theta))).real
    moment = q * C[2] - coefficients["C_Md"] * s.r * np.abs(s.r) + normal * s.arm
    force = s.T + s.plate_force * np.conj(s.core)
    for active, _ in by_stage.get("force", []):
        more, turn = active.form.law(s, active.p)
        force, moment = force + more, moment + turn
    for active, _ in by_stage.get("centre", []):
        moment = moment - (np.conj(active.form.law(s, active.p)) * force).imag
    masses = [active.form.law(s, active.p) for active, _ in by_stage.get("inertia", [])]
    return _accelerations(s, case, force, moment, masses[0] if masses else None)


def head_angles(t, case: Case, skip: frozenset[int] = frozenset()) -> np.ndarray:
    """Actual head angle at time t, rad."""
    s = SimpleNamespace(t=t, trial=case.trial, b=case.robot)
    phi = case.phi + 0 * t
    for index, active in enumerate(case.active):
        if active.form.stage == "servo" and index not in skip:
            phi = active.form.law(s, phi, active.p)
    return phi


def drive_factor(t, case: Case) -> np.ndarray:
    """Factor of the drive's forms on the flapping frequency at time t."""
    s = SimpleNamespace(t=t, trial=case.trial, power=case.frequency / case.robot.flap)
    factor = np.ones(np.broadcast_shapes(np.shape(t), np.shape(case.frequency)))
    for active in case.active:
        if active.form.stage == "drive":
            factor = factor * active.form.law(s, active.p)
    return factor


def simulate(case: Case, start: np.ndarray, duration: float) -> tuple[np.ndarray, np.ndarray]:
    """Times (steps,) and states (steps, states, rows) from rest at `start` (3, rows)."""
    times = np.arange(int(np.ceil(duration / TIME_STEP)) + 2) * TIME_STEP
    z = np.zeros((case.states(), start.shape[1]))
    z[:3] = start
    history = np.empty((len(times), *z.shape))
    h = TIME_STEP
    for k, t in enumerate(times):
        history[k] = z
        k1 = flow_rates(t, z, case)
        k2 = flow_rates(t + h / 2, z + h / 2 * k1, case)
        k3 = flow_rates(t + h / 2, z + h / 2 * k2, case)
        k4 = flow_rates(t + h, z + h * k3, case)
        z = np.clip(z + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), -FAR, FAR)
    return times, history

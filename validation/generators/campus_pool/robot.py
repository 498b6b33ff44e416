"""Drawing of robots: dimensions, coefficients, a tail fin, and checks of steady swimming."""

from __future__ import annotations

import numpy as np

from .dynamics import evaluate
from .registry import FORMS, Law
from .simulate import integrate
from .world import Pool, Robot, Scales, Trials, World

REFERENCE_M = 0.331


def draw_robot(rng: np.random.Generator) -> tuple[Robot, dict[str, float], Scales]:
    """Dimensions and the six coefficients, scaled from the published robot and scattered."""
    size = float(np.exp(rng.uniform(np.log(0.25), np.log(1.2))))
    s = size / REFERENCE_M
    mass = 0.68 * s**3 * rng.uniform(0.75, 1.35)
    robot = Robot(
        mass=mass,
        inertia=0.1275 * mass * size**2 * rng.uniform(0.8, 1.2),
        body=size,
        head=size * rng.uniform(0.28, 0.42),
        span=size * rng.uniform(0.17, 0.25),
        hinge_to_com=size * rng.uniform(0.08, 0.16),
        tail=size * rng.uniform(0.15, 0.25),
        depth=size * rng.uniform(0.06, 0.2),
        density=float(rng.choice([1000.0, 998.0])),
    )
    f100 = 5.8 * s**-0.6 * rng.uniform(0.65, 1.15)
    top = size * rng.uniform(1.0, 2.0) * s**-0.35
    cd0 = rng.uniform(0.35, 0.75)
    coef = {
        "C_T": cd0 * (top / f100) ** 2,
        "C_D0": cd0,
        "C_Da": rng.uniform(0.3, 3.0),
        "C_La": rng.uniform(2.0, 4.0),
        "C_Ma": 0.1 * s * rng.uniform(0.4, 1.4),
        "C_Md": 0.12 * s**5 * rng.uniform(0.7, 2.2),
    }
    speed = 0.7 * top
    rate = speed / (1.6 * size)
    drag = 0.5 * robot.density * robot.head * robot.span * cd0 * speed**2
    scales = Scales(speed, drag, rate, coef["C_Md"] * rate**2, size, size / speed, f100)
    return robot, {k: float(v) for k, v in coef.items()}, scales


def bare_trials(
    power: np.ndarray, phi: np.ndarray, frequency: np.ndarray, head: np.ndarray, speed: np.ndarray
) -> Trials:
    """Trials without disturbances, already swimming at a given speed along x."""
    k = power.size
    col = power.reshape(-1, 1) * 1.0
    zero = np.zeros((k, 1))
    start = np.zeros((6, k))
    start[3] = speed
    return Trials(
        power=col,
        phi_cmd=phi.reshape(-1, 1),
        phi_err=zero,
        phi_before=zero,
        f_nom=frequency.reshape(-1, 1),
        head=head.reshape(-1, 1),
        t_on=zero,
        rest=zero,
        thrust=zero + 1,
        order=zero,
        z=zero,
        end=zero[:, 0],
        start=start,
        mode_amp=np.zeros((k, 1, 1)),
        mode_omega=np.zeros((k, 1, 1)),
        mode_phase=np.zeros((k, 1, 1)),
    )


def body_matrix(world: World, state: np.ndarray, laws: list[Law]) -> np.ndarray:
    """Jacobians (K, 3, 3) of surge, sway and yaw rate in the head's axes."""

    def rate(v: np.ndarray) -> np.ndarray:
        """Body-axes derivative for body-axes velocities (3, K)."""
        full = state.copy()
        head = np.exp(1j * state[2, :, 0])
        vel = (v[0] + 1j * v[1]) * head
        full[3, :, 0], full[4, :, 0], full[5, :, 0] = vel.real, vel.imag, v[2]
        d = evaluate(world, np.float64(0.0), full, laws)
        accel = (d[3, :, 0] + 1j * d[4, :, 0]) * np.conj(head) - 1j * v[2] * (v[0] + 1j * v[1])
        return np.stack([accel.real, accel.imag, d[5, :, 0]])

    body = (state[3, :, 0] + 1j * state[4, :, 0]) * np.exp(-1j * state[2, :, 0])
    v0 = np.stack([body.real, body.imag, state[5, :, 0]])
    out = np.zeros((v0.shape[1], 3, 3))
    for j, h in enumerate(
        (1e-4 * world.scales.speed, 1e-4 * world.scales.speed, 1e-4 * world.scales.rate)
    ):
        up, down = v0.copy(), v0.copy()
        up[j] += h
        down[j] -= h
        out[:, :, j] = ((rate(up) - rate(down)) / (2 * h)).T
    return out


def straight_growth(world: World, laws: list[Law]) -> float:
    """Greatest growth rate (per convective time) of straight swimming at the typical speed."""
    state = np.zeros((8, 1, 1))
    state[3] = world.scales.speed
    one = bare_trials(
        np.array([70.0]),
        np.zeros(1),
        np.array([0.7 * world.scales.frequency]),
        np.array([world.robot.head]),
        np.array([world.scales.speed]),
    )
    old, world.trials = world.trials, one
    growth = float(np.max(np.linalg.eigvals(body_matrix(world, state, laws)).real))
    world.trials = old
    return growth * world.scales.time


def draw_fin(rng: np.random.Generator, world: World) -> Law | None:
    """A tail fin that makes straight swimming stable, marginally to strongly; None if it cannot."""
    forms = FORMS["tail_fin_lift"]
    law = forms[int(rng.integers(len(forms)))].draw(rng)
    goal = -float(np.exp(rng.uniform(np.log(0.03), np.log(0.6))))
    if straight_growth(world, [law.with_amp(20.0)]) > goal:
        return None
    low, high = 0.0, 20.0
    for amp in np.linspace(0.5, 20.0, 40):
        if straight_growth(world, [law.with_amp(amp)]) < goal:
            high = float(amp)
            break
        low = float(amp)
    for _ in range(20):
        mid = 0.5 * (low + high)
        if straight_growth(world, [law.with_amp(mid)]) < goal:
            high = mid
        else:
            low = mid
    return law.with_amp(high)


def turns_are_steady(world: World, laws: list[Law], trials: Trials) -> bool:
    """Whether all turning conditions end in stable turns of plausible radius and right sign."""
    old, old_duration = world.trials, world.duration
    world.trials = trials
    try:
        path = integrate(world, laws, 25.0 * world.scales.time)
        last = path.state[:, :, -1:]
        speed = np.hypot(last[3, :, 0], last[4, :, 0])
        rate, phi = last[5, :, 0], trials.phi_cmd[:, 0]
        turning = np.abs(phi) > 0.1
        radius = speed / (np.abs(rate) + 1e-9) / world.robot.body
        good = np.where(
            turning, (np.sign(rate) == -np.sign(phi)) & (radius < 8) & (radius > 0.45), True
        )
        eig = np.linalg.eigvals(body_matrix(world, last, laws)).real.max(axis=1)
        slip = np.abs(
            np.angle(np.exp(1j * last[2, :, 0]) * np.conj(last[3, :, 0] + 1j * last[4, :, 0]))
        )
        good &= np.where(turning, (eig < 0) & (slip < 1.2), True)
        return bool(good.all())
    finally:
        world.trials, world.duration = old, old_duration


def stub_world(rng: np.random.Generator) -> World:
    """A world with a robot and nothing else yet."""
    robot, coef, scales = draw_robot(rng)
    none = bare_trials(
        np.array([70.0]),
        np.zeros(1),
        np.array([1.0]),
        np.array([robot.head]),
        np.array([scales.speed]),
    )
    return World(robot, robot, coef, scales, Pool(1.0, 1.0, 1.0), None, none, {}, 30.0, 1.0)

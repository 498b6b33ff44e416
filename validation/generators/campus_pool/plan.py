"""A lab's plan: pool, camera, powers, head angles, repeats, starts, and the disturbances."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .optics import hang
from .registry import Law
from .robot import bare_trials, draw_fin, stub_world, turns_are_steady
from .simulate import integrate, keeps_inside, outline
from .world import Pool, Trials, World

RATES = (25.0, 30000 / 1001, 30.0, 50.0, 60000 / 1001, 60.0, 90.0, 100.0, 120.0)


def conditions(
    rng: np.random.Generator, count: int, heads: list[float], steep: bool = False
) -> list[tuple]:
    """Rows of power, head angle (deg) and head factor, with repeats and both signs."""
    low = float(rng.choice([30, 35, 40, 45, 50]))
    powers = np.round(np.linspace(low, 100.0, int(rng.integers(3, 6 if count > 12 else 4))) / 5) * 5
    sizes = sorted(
        {
            int(a)
            for a in rng.choice(
                [10, 12, 15, 18, 20, 25, 30, 35, 40, 45], 3 if count > 12 else 2, replace=False
            )
        }
    )
    if steep:
        sizes = sorted({*sizes[:-1], int(rng.choice([35, 40, 45]))})
    angles = [0] + [s * a for a in sizes for s in (1, -1)]
    pool = [(float(p), float(a)) for p in powers for a in angles]
    while True:
        distinct = min(len(pool), int(rng.integers(count // 2, max(count // 2 + 2, count - 2))))
        chosen = [pool[i] for i in rng.choice(len(pool), distinct, replace=False)]
        rows = [(*chosen[i % distinct], heads[int(rng.integers(len(heads)))]) for i in range(count)]
        a = np.array([r[1] for r in rows])
        p = np.array([r[0] for r in rows])
        straight = set(p[a == 0])
        need = 2 if count > 12 else 1
        if (
            len(straight) >= need
            and min((a > 0).sum(), (a < 0).sum()) >= count // 5
            and len(set(p[a > 0])) > 1
            and len(set(p[a < 0])) > 1
            and len({r[2] for r in rows}) == min(len(heads), 3)
        ):
            break
    order = rng.permutation(count) if rng.uniform() < 0.7 else np.lexsort((a, p))
    return [rows[i] for i in order]


def disturb(rng: np.random.Generator, world: World, trials: Trials) -> None:
    """Servo errors, thrust scatter, weak moving water, frequency scatter."""
    k = trials.count
    trials.phi_err = np.radians(rng.normal(0, 0.3, (k, 1)))
    trials.thrust = 1 + rng.normal(0, 0.005, (k, 1))
    trials.f_nom = trials.f_nom * (1 + rng.normal(0, 0.008, (k, 1)))
    trials.z = np.clip(rng.normal(0, 1, (k, 1)), -2.5, 2.5)
    tau, sigma = world.noise["water_tau_s"], world.noise["water_m_s"]
    modes = 10
    omega = np.clip(np.abs(rng.standard_cauchy((k, 1, modes))), 0.02, 8.0) / tau
    amp = rng.normal(0, 1, (k, 1, modes)) + 1j * rng.normal(0, 1, (k, 1, modes))
    trials.mode_amp = amp * sigma * np.sqrt(2.0 / modes)
    trials.mode_omega = omega
    trials.mode_phase = rng.uniform(0, 2 * np.pi, (k, 1, modes))


def noise_of(rng: np.random.Generator, world: World) -> dict[str, float]:
    """Magnitudes of the tracking errors and of the water, and the detector's equivalent."""
    cam = world.camera
    pixel = cam.size[0] / 1920.0
    per_metre = cam.focal[0] / cam.position[2]
    white, corr = rng.uniform(0.25, 0.7) * pixel, rng.uniform(0.25, 0.8) * pixel
    tau = rng.uniform(0.12, 0.45)
    rho = np.exp(-1 / 15 / tau)
    effective = np.sqrt(white**2 * min(1.0, 15 / world.fps) + corr**2 * (1 + rho) / (1 - rho))
    return {
        "white_px": white,
        "correlated_px": corr,
        "correlation_s": tau,
        "outlier_share": rng.uniform(0.002, 0.01),
        "gap_rate_hz": rng.uniform(0.02, 0.1),
        "recoil_rad": np.radians(rng.uniform(0.6, 3.0)),
        "recoil_sway_m": world.robot.body * rng.uniform(0.001, 0.005),
        "tail_rad": np.radians(rng.uniform(8, 25)),
        "water_m_s": world.scales.speed * rng.uniform(0.002, 0.008),
        "water_tau_s": rng.uniform(1.0, 4.0),
        "servo_deg": 0.3,
        "thrust_share": 0.005,
        "dimension_share": 0.003,
        "effective_m": float(effective / per_metre),
    }


def place_paths(rng: np.random.Generator, world: World, laws: list[Law]) -> float:
    """Give each trial a start from which it stays in the pool long; the least inside share."""
    path = integrate(world, laws, world.duration).thin(4)
    z0 = outline(world, path)
    margin = 0.1 * world.robot.body
    shares = []
    for i in range(world.trials.count):
        best, keep = -1.0, (0.0, 0j)
        for _ in range(80):
            angle = rng.uniform(-np.pi, np.pi)
            z = z0[:, i] * np.exp(1j * angle)
            room_x = world.pool.length - 2 * margin - np.ptp(z.real)
            room_y = world.pool.width - 2 * margin - np.ptp(z.imag)
            if room_x > 0 and room_y > 0:
                move = (
                    margin
                    - z.real.min()
                    + rng.uniform() * room_x
                    + 1j * (margin - z.imag.min() + rng.uniform() * room_y)
                )
            else:
                move = rng.uniform(margin, world.pool.length - margin) + 1j * rng.uniform(
                    margin, world.pool.width - margin
                )
            q = z + move
            out = ~keeps_inside(world, q, 0.08)
            share = 1.0 if not out.any() else float(np.argmax(out)) / out.size
            if share > best:
                best, keep = share, (angle, move)
            if share == 1.0:
                break
        start = world.trials.start
        v = (start[3, i] + 1j * start[4, i]) * np.exp(1j * keep[0])
        start[0, i], start[1, i] = keep[1].real, keep[1].imag
        start[2, i] += keep[0]
        start[3, i], start[4, i] = v.real, v.imag
        shares.append(best)
    return min(shares)


def build(
    rng: np.random.Generator, count: int, fin: bool, names: list[str]
) -> tuple[World, list[Law]]:
    """A world with `count` trials whose turns are steady, and the fin as the only law."""
    for _ in range(200):
        world = stub_world(rng)
        law = draw_fin(rng, world) if fin else None
        if fin and law is None:
            continue
        laws = [law] if law else []
        several = "thrust_area" in names or rng.uniform() < 0.4
        heads = [1.0, float(rng.uniform(1.2, 1.5))] if several else [1.0]
        if several and count > 12 and rng.uniform() < 0.4:
            heads.append(float(rng.uniform(0.7, 0.85)))
        rows = conditions(rng, count, heads, "stall" in names)
        power = np.array([r[0] for r in rows])
        idle = rng.uniform(0.0, 0.1)
        f = world.scales.frequency * (idle + (1 - idle) * power / 100.0)
        speed = 0.7 * world.scales.speed / 0.7 * f / world.scales.frequency
        trials = bare_trials(
            power,
            np.radians([r[1] for r in rows]),
            f,
            world.robot.head * np.array([r[2] for r in rows]),
            speed,
        )
        if turns_are_steady(world, laws, trials):
            break
    else:
        raise RuntimeError("no steady robot was found")
    _surround(rng, world, trials, names)
    world.trials = trials
    if place_paths(rng, world, laws) < 0.3:
        return build(rng, count, fin, names)
    return world, laws


def _surround(rng: np.random.Generator, world: World, trials: Trials, names: list[str]) -> None:
    """Pool, camera, clocks, starts, stated dimensions and disturbances."""
    rb, sc, k = world.robot, world.scales, trials.count
    length = rb.body * rng.uniform(*((6.0, 8.5) if "wall_effect" in names else (7.5, 13.0)))
    world.pool = Pool(
        round(length, 2),
        round(length * rng.uniform(0.55, 0.85), 2),
        round(rb.depth + rb.span * rng.uniform(7, 10), 2),
    )
    world.index = float(rng.choice([1.333, 1.333, 1.334]))
    world.camera = hang(rng, world.pool.length, world.pool.width)
    world.extra["mark_height"] = float(round(rng.choice([0.0, 0.02, 0.05]) * rb.body * 3, 3))
    world.fps = float(rng.choice(RATES))
    world.duration = float(np.clip(rng.uniform(8, 15) * sc.time, 4.0, 14.0))
    if "wake_reentry" in names:
        world.duration = float(np.clip(rng.uniform(14, 20) * sc.time, 6.0, 16.0))
    world.log = bool(rng.uniform() < 0.5)
    if "time_offset" in names:
        world.log = True
    elif names and set(names) & {"motor_spin_up", "battery_sag"}:
        world.log = bool(rng.uniform() < 0.3)
    world.noise = {a: float(b) for a, b in noise_of(rng, world).items()}
    share = rng.uniform(0.3, 0.6)
    if set(names) & {"motor_spin_up", "time_offset", "added_mass", "lift_lag"}:
        share = rng.uniform(0.6, 0.9)
    rest = rng.permutation(k) < max(2, round(share * k))
    trials.rest = rest.astype(float).reshape(-1, 1)
    trials.t_on = np.where(rest, rng.uniform(0.15, 0.6, k) if world.log else 0.03, 0.0).reshape(
        -1, 1
    )
    trials.order = np.linspace(0, 1, k).reshape(-1, 1)
    phi = trials.phi_cmd
    trials.phi_before = np.vstack([[[0.0]], phi[:-1]]) if rng.uniform() < 0.4 else 0 * phi
    disturb(rng, world, trials)
    start = np.zeros((6, k))
    pace = trials.start[3] * rng.uniform(0.45, 1.0, k)
    slip = rng.normal(0, 0.04, k)
    start[3], start[4] = pace * np.cos(slip), pace * np.sin(slip)
    start[5] = rng.normal(0, 0.06 * sc.rate, k)
    start[2] = 0.0
    start[3:] = np.where(rest, 0.0, start[3:])
    trials.start = start
    off = {
        key: getattr(rb, key) * (1 + rng.normal(0, 0.003))
        for key in ("mass", "inertia", "body", "head", "span", "hinge_to_com", "tail", "depth")
    }
    world.stated_robot = replace(rb, **off)

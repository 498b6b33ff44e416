"""Signals of laws, coefficients and rivals along the true motion, and their significance.

A signal is what a law does to the state over each interval of `INTERVAL` when it is removed, and
what it does to what is seen. Rows beside those of the filter: lengths of the body in the picture
and the tail beat in the picture against the motor.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .drive_laws import head_angle
from .here import Law, Setting
from .kalman import Linear, Noise, whitened
from .motion import Plant, advance
from .registry import MEASUREMENT
from .robots import COEFFICIENTS, Array, Fin
from .session import STEP, Run
from .sight import Scene, apparent, clock_error, with_delay

INTERVAL = 0.2
LENGTH_ERROR = 0.006
BEAT_ERROR = 0.006
"""Relative errors: of lengths of the body in a study, of the tail beat in a trial."""
NUDGES = np.array([1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-3])


@dataclass(frozen=True)
class Bench:
    """The starts of all intervals. state: (ROWS, trials * intervals); time: trials x intervals."""

    plant: Plant
    scene: Scene
    laws: tuple[Law, ...]
    run: Run
    setting: Setting
    state: Array
    time: Array
    used: Array


def bench_of(plant: Plant, scene: Scene, laws: tuple[Law, ...], run: Run) -> Bench:
    """Cut a motion into intervals. laws: all, those of measurement included."""
    every = round(INTERVAL / STEP)
    steps = np.arange(0, len(run.times) - every, every)
    count = run.states.shape[1]
    used = run.times[steps] <= run.setting.span[:, None]
    last = used.sum(axis=1) - 1  # what follows is not used and may lie beyond a wall
    kept = steps[np.minimum(np.arange(len(steps)), last[:, None])]
    time = run.times[kept]
    state = run.states[:, np.arange(count)[:, None], kept].reshape(len(run.states), -1)
    setting = run.setting.columns(np.repeat(np.arange(count), len(steps)))
    return Bench(plant, scene, laws, run, setting.but(since=time.ravel()), state, time, used)


def _ends(plant: Plant, setting: Setting, state: Array) -> Array:
    """The first six rows of the state after the intervals."""
    return advance(plant, setting, state, INTERVAL)[:6]


def _split(bench: Bench, ends: Array) -> Array:
    """As trials x intervals x 6."""
    return ends.reshape(6, *bench.time.shape).transpose(1, 2, 0)


def linearise(bench: Bench) -> tuple[Linear, Array]:
    """Motion and effects of coefficients and of the fin, (trials, intervals, 6, 6 or 8)."""
    state, setting, plant = bench.state, bench.setting, bench.plant
    cases: list[tuple[Setting, Array, float]] = []
    for row, size in enumerate(NUDGES):
        moved = state.copy()
        moved[row] += size
        cases.append((setting, moved, size))
    torque = 0.01 * plant.robot.drag * plant.robot.body_length
    for row, size in enumerate((1e-3, 1e-3, torque)):
        push = setting.push.copy()
        push[row] += size
        cases.append((setting.but(push=push), state, size))
    cases.append((setting.but(phi=setting.phi + 1e-3), state, 1e-3))
    cases.append((setting.but(thrust=setting.thrust * 1.001), state, 1e-3))
    for row in range(len(COEFFICIENTS)):
        changed = setting.coefficients.copy()
        changed[row] *= 1.01
        cases.append((setting.but(coefficients=changed), state, 0.01))
    for row in range(2 if plant.robot.fin else 0):
        changed = setting.fin.copy()
        changed[row] *= 1.01
        cases.append((setting.but(fin=changed), state, 0.01))
    base = _ends(plant, setting, state)
    found = [
        _split(bench, (_ends(plant, case, start) - base) / size) for case, start, size in cases
    ]
    stacked = np.stack(found, axis=-1)
    linear = Linear(stacked[..., :6], stacked[..., 6:9], stacked[..., 9:11], bench.used)
    return linear, stacked[..., 11:]


@dataclass(frozen=True)
class Signal:
    """kicks: trials x intervals x 6; sights: trials x intervals x 3; beside: extra rows."""

    kicks: Array
    sights: Array
    beside: Array


def law_signal(bench: Bench, law: Law) -> Signal:
    """Of a law that acts."""
    rest = tuple(one for one in bench.laws if one is not law)
    return _signal(bench, law, bench.laws, rest)


def probe_signal(bench: Bench, law: Law) -> Signal:
    """Of a law that does not act, at a small size."""
    return _signal(bench, law, (*bench.laws, law), bench.laws)


def fin_signal(bench: Bench, robot_fin: Fin | None = None) -> Signal:
    """Of the robot's own fin, or of a fin that it lacks."""
    with_fin, with_setting = bench.plant, bench.setting
    if robot_fin:
        robot = replace(bench.plant.robot, fin=robot_fin)
        with_fin = replace(bench.plant, robot=robot)
        ones = np.ones(bench.state.shape[1])
        with_setting = bench.setting.but(fin=np.outer([robot_fin.strength, robot_fin.arm], ones))
    without = replace(bench.plant, robot=replace(bench.plant.robot, fin=None))
    kicks = _ends(with_fin, with_setting, bench.state) - _ends(without, bench.setting, bench.state)
    return Signal(_split(bench, kicks), np.zeros((*bench.time.shape, 3)), np.zeros(3))


def _signal(bench: Bench, law: Law, acting: tuple[Law, ...], rest: tuple[Law, ...]) -> Signal:
    kicks = np.zeros((6, bench.state.shape[1]))
    if law.name == "time_offset":
        late = with_delay(bench.setting.but(delay=0 * bench.setting.delay), law)
        early = bench.setting.but(delay=0 * bench.setting.delay)
        kicks = _ends(bench.plant, late, bench.state) - _ends(
            bench.plant, early, bench.state)  # fmt: skip
    elif law.name not in MEASUREMENT:
        after = [
            replace(bench.plant, laws=tuple(one for one in laws if one.name not in MEASUREMENT))
            for laws in (acting, rest)
        ]
        kicks = _ends(after[0], bench.setting, bench.state) - _ends(
            after[1], bench.setting, bench.state)  # fmt: skip
    one, other = _seen(bench, acting), _seen(bench, rest)
    sights = one[0] - other[0]
    if law.name == "servo_lag":
        sights = 0 * sights  # the swing itself, which every frame shows, would hide the path
    beside = np.array([np.mean((one[1] - other[1])[bench.used]) / LENGTH_ERROR, 0.0, 0.0])
    if law.name == "clock_error":
        wrong, order = clock_error(law, bench.run.setting.order), bench.run.setting.order
        for row, part in ((1, order < 0.5), (2, order >= 0.5)):
            beside[row] = wrong[part].mean() * np.sqrt(part.sum()) / BEAT_ERROR
    return Signal(_split(bench, kicks), sights, beside)


def _seen(bench: Bench, laws: tuple[Law, ...]) -> tuple[Array, Array]:
    """Seen place and direction of the core at the starts of intervals; length ratio."""
    shape = bench.time.shape
    setting, state = bench.run.setting, bench.state.reshape(-1, *shape)
    place, phi = state[0] + 1j * state[1], np.tile(setting.phi[:, None], (1, shape[1]))
    velocity = (state[3] + 1j * state[4]) * np.exp(1j * state[2])
    awake = np.maximum(bench.time - setting.delay[:, None], 0)
    theta = state[2]
    for law in laws:
        if law.name in ("servo_lag", "head_angle_offset"):
            phi = head_angle(law, phi, awake, setting.phi[:, None])
        elif law.name == "clock_error":
            early = clock_error(law, setting.order)[:, None] * bench.time
            place, theta = place + velocity * early, theta + state[5] * early
    seen, core, ratio = apparent(laws, bench.scene, setting, bench.time, place=place,
                                 core=theta + phi)  # fmt: skip
    return np.stack([seen.real, seen.imag, core], axis=-1), ratio


def rows(linear: Linear, noise: Noise, signals: list[Signal]) -> Array:
    """Whitened signals, rows x columns."""
    kicks = np.stack([one.kicks for one in signals], axis=-1)
    sights = np.stack([one.sights for one in signals], axis=-1)
    white = whitened(linear, noise, kicks, sights)
    beside = np.stack([one.beside for one in signals], axis=-1)
    return np.concatenate([white.reshape(-1, len(signals)), beside])


def nuisances(bench: Bench, effects: Array) -> list[Signal]:
    """Coefficients and fin as signals."""
    still, none = np.zeros((*bench.time.shape, 3)), np.zeros(3)
    return [Signal(effects[..., k], still, none) for k in range(effects.shape[-1])]

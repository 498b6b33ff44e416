"""Stability of straight swimming, and the strength of a fin from it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .craft import Robot, draw_robot
from .eddies import draw_water_motion
from .form import Form, HiddenForm, draw_hidden
from .impulse import RIGID_STATE_ROWS, StudyWorld, initial_state, state_derivative
from .lanes import ParallelTrials, draw_trials

STRENGTHS = np.geomspace(0.02, 20.0, 120)


def still_water_trials(craft: Robot, laws, hertz, angle=0.0) -> tuple[StudyWorld, ParallelTrials]:
    """Lanes of equal trials in still water without errors; one for each frequency in `hertz`."""
    n = len(hertz)
    rng = np.random.default_rng(0)
    water = replace(draw_water_motion(rng, n), drift=0.0, eddy=0.0)
    row = np.zeros(n, dtype=int)
    some = draw_trials(rng, craft, water, few=True)
    zero = np.zeros(n)
    lanes = ParallelTrials(
        np.arange(n),
        zero + 100,
        zero + angle,
        zero,
        np.asarray(hertz, dtype=float),
        zero + craft.head_length,
        np.zeros((6, n)),
        np.zeros((2, n)),
        some.eddies[..., row] * 0,
        some.coefficients[:, row],
        np.array([h.strength + zero for h in laws]).reshape(len(laws), n),
    )
    pool = (1e3, 1e3, 0.5)
    return StudyWorld(craft, water, pool, tuple(laws), np.zeros((4000, n))), lanes


def straight_growth_rate(craft: Robot, laws, hertz: float, strengths=None) -> np.ndarray:
    """Largest real eigenvalue (1/s) of sway, yaw and the laws' states in straight swimming.

    strengths: one value each of the last law; else its own.
    """
    n = 1 if strengths is None else len(strengths)
    world, lanes = still_water_trials(craft, laws, np.full(n, hertz))
    if strengths is not None:
        lanes = replace(lanes, strengths=np.vstack([lanes.strengths[:-1], strengths]))
    C_T, C_D0 = lanes.coefficients[:2]
    start = np.zeros((6, n))
    start[3] = hertz * np.sqrt(C_T / C_D0)
    lanes = replace(lanes, start=start)
    row = (lanes.flap, np.zeros(n) + np.pi / 4, np.zeros(n))  # cos 2 phase = 0: mean thrust
    state = initial_state(world, lanes, row)
    rows = [4, 5, *range(RIGID_STATE_ROWS, len(state))]
    J = np.empty((n, len(rows), len(rows)))
    for j, r in enumerate(rows):
        up, down = state.copy(), state.copy()
        up[r] += 1e-6
        down[r] -= 1e-6
        change = state_derivative(world, lanes, up, 1.0, row) - state_derivative(
            world, lanes, down, 1.0, row
        )
        J[:, :, j] = change[rows].T / 2e-6
    return np.linalg.eigvals(J).real.max(axis=1)


def draw_fin(rng: np.random.Generator, craft: Robot, form: Form, hertz: float) -> HiddenForm | None:
    """A fin 1.15 to 3 times as strong as the weakest that makes straight swimming stable."""
    fin = draw_hidden(rng, form)
    stable = straight_growth_rate(craft, [fin], hertz, STRENGTHS) < 0
    if not stable.any() or not stable[-1]:
        return None
    first = STRENGTHS[len(stable) - int(np.argmin(stable[::-1]))]
    return replace(fin, strength=float(first * np.exp(rng.uniform(np.log(1.15), np.log(3.0)))))


__all__ = ["draw_fin", "draw_robot", "still_water_trials", "straight_growth_rate"]

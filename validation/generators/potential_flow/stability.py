"""Stability of straight swimming, and the strength of a fin from it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .craft import Craft, draw_craft
from .eddies import draw_water
from .form import Form, Hidden, draw
from .impulse import FIXED, World, derivative, initial
from .lanes import Lanes, draw_lanes

STRENGTHS = np.geomspace(0.02, 20.0, 120)


def still(craft: Craft, laws, hertz, angle=0.0) -> tuple[World, Lanes]:
    """Lanes of equal trials in still water without errors; one for each frequency in `hertz`."""
    n = len(hertz)
    rng = np.random.default_rng(0)
    water = replace(draw_water(rng, n), drift=0.0, eddy=0.0)
    row = np.zeros(n, dtype=int)
    some = draw_lanes(rng, craft, water, few=True)
    zero = np.zeros(n)
    lanes = Lanes(np.arange(n), zero + 100, zero + angle, zero, np.asarray(hertz, dtype=float),
                  zero + craft.head_length, np.zeros((6, n)), np.zeros((2, n)),
                  some.eddies[..., row] * 0, some.coefficients[:, row],
                  np.array([h.strength + zero for h in laws]).reshape(len(laws), n))  # fmt: skip
    pool = (1e3, 1e3, 0.5)
    return World(craft, water, pool, tuple(laws), np.zeros((4000, n))), lanes


def growth(craft: Craft, laws, hertz: float, strengths=None) -> np.ndarray:
    """Largest real eigenvalue (1/s) of sway, yaw and the laws' states in straight swimming.

    strengths: one value each of the last law; else its own.
    """
    n = 1 if strengths is None else len(strengths)
    world, lanes = still(craft, laws, np.full(n, hertz))
    if strengths is not None:
        lanes = replace(lanes, strengths=np.vstack([lanes.strengths[:-1], strengths]))
    C_T, C_D0 = lanes.coefficients[:2]
    start = np.zeros((6, n))
    start[3] = hertz * np.sqrt(C_T / C_D0)
    lanes = replace(lanes, start=start)
    row = (lanes.flap, np.zeros(n) + np.pi / 4, np.zeros(n))  # cos 2 phase = 0: mean thrust
    state = initial(world, lanes, row)
    rows = [4, 5, *range(FIXED, len(state))]
    J = np.empty((n, len(rows), len(rows)))
    for j, r in enumerate(rows):
        up, down = state.copy(), state.copy()
        up[r] += 1e-6
        down[r] -= 1e-6
        change = derivative(world, lanes, up, 1.0, row) - derivative(world, lanes, down, 1.0, row)
        J[:, :, j] = change[rows].T / 2e-6
    return np.linalg.eigvals(J).real.max(axis=1)


def draw_fin(rng: np.random.Generator, craft: Craft, form: Form, hertz: float) -> Hidden | None:
    """A fin 1.15 to 3 times as strong as the weakest that makes straight swimming stable."""
    fin = draw(rng, form)
    stable = growth(craft, [fin], hertz, STRENGTHS) < 0
    if not stable.any() or not stable[-1]:
        return None
    first = STRENGTHS[len(stable) - int(np.argmin(stable[::-1]))]
    return replace(fin, strength=float(first * np.exp(rng.uniform(np.log(1.15), np.log(3.0)))))


__all__ = ["draw_craft", "draw_fin", "growth", "still"]

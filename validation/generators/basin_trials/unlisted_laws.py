"""Forces that no candidate cause describes; `k` is the size of the law."""

from __future__ import annotations

import numpy as np

from .form import POOL_LENGTH, HiddenLaw, Situation


def compass(now: Situation, law: HiddenLaw) -> None:
    """Moment of a magnet towards one axis of the pool: -k sin 2 (psi - psi_0)."""
    now.N = now.N - law.size * np.sin(2 * (now.psi - np.pi * law.shape[0]))


def curtain(now: Situation, law: HiddenLaw) -> None:
    """Resistance of a curtain of bubbles across the pool, within about 0.2 m of its x."""
    x0 = POOL_LENGTH * (0.35 + 0.3 * law.shape[0])
    now.X = now.X - law.size * np.exp(-(((now.x - x0) / 0.2) ** 2)) * np.tanh(now.u / 0.05)


def hunting(now: Situation, law: HiddenLaw) -> None:
    """Moment that swings in time as a triangle wave of 1.6 to 3.4 s."""
    period = 1.6 + 1.8 * law.shape[0]
    phase = 2 * np.pi * (now.t / period + law.shape[1])
    now.N = now.N + law.size * 2 / np.pi * np.arcsin(np.sin(phase))


def snag(now: Situation, law: HiddenLaw) -> None:
    """Pull of a hose for 1.5 s in the middle of every trial, a raised cosine."""
    s = (now.t - 2.0 - law.shape[0]) / 0.75
    now.X = now.X - law.size * np.where(np.abs(s) < 1, 0.5 * (1 + np.cos(np.pi * s)), 0.0)


def pitch_up(now: Situation, law: HiddenLaw) -> None:
    """Surge force that a turning robot loses by its pitch: -k |r|^1.5."""
    now.X = now.X - law.size * np.abs(now.r) ** 1.5

"""What is true of a trial's path, and how close the true laws come to it without its eddies."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from bluekoi.synthetic.concealed.strength import HEADING_ARM_M, KEEP, STEP_S, paths
from bluekoi.synthetic.concealed.trials import Swum
from bluekoi.synthetic.swimmer.quantities import Body, Command, Laws

__all__ = ["path_truth", "true_law_error"]

SAMPLE_S = STEP_S * KEEP
STARTS = {"x": 1e-3, "y": 1e-3, "psi": 1e-3, "u": 0.002, "v": 0.002, "r": 0.01}
ROUNDS = 5


def path_truth(one: Swum) -> dict[str, Any]:
    """Command and mean motion of a trial: rows x, y (m), heading (rad), u, v (m/s), r (rad/s),
    every 1/15 s from release.
    """
    at_s = np.arange(0.0, max(float(one.trial.time_s[-1]), 10 * SAMPLE_S), SAMPLE_S)
    mean = one.trial.motion.mean(at_s)
    own = (mean[:, 3] + 1j * mean[:, 4]) * np.exp(-1j * mean[:, 2])
    rows = np.column_stack([mean[:, :3], own.real, own.imag, mean[:, 5]])
    return {"command": one.command._asdict(), "mean": np.round(rows, 6)}


def true_law_error(truth: Mapping[str, Any], trials: Sequence[str], stretch_s: float) -> float:
    """Path error (m, rms) that the true laws make in still water over stretches of some trials.

    True numbers, pulse left out, each stretch from the state that suits it best: what a model with
    the right law can reach in a free simulation, but for the measuring noise.
    """
    body, laws = Body(**truth["body"]), Laws(**truth["laws"])
    squares = []
    for name in trials:
        told = truth["paths"][name]
        rows, release = np.array(told["mean"]), Command(**told["command"])
        count = max(1, int(np.ceil((len(rows) - 1) * SAMPLE_S / stretch_s - 1e-6)))
        for low, high in pairwise(np.linspace(0, len(rows), count + 1).astype(int)):
            squares.append(_stretch(body, laws, release, rows[low:high], low * SAMPLE_S))
    return float(np.sqrt(np.mean(np.concatenate(squares)))) if squares else float("nan")


def _stretch(
    body: Body, laws: Laws, release: Command, rows: np.ndarray, begin_s: float
) -> np.ndarray:
    """Squared path errors (m^2) along one stretch."""
    x, y, psi, u, v, r = (float(value) for value in rows[0])
    start = release._replace(x=x, y=y, psi=psi, u=u, v=v, r=r, time_s=begin_s,
                             turned=psi - release.psi)  # fmt: skip
    duration = (len(rows) - 1) * SAMPLE_S + 0.5 * STEP_S
    seen = rows[:, :3].T * np.array([[1.0], [1.0], [HEADING_ARM_M]])

    def off(command: Command) -> np.ndarray:
        return paths(body, laws, [(command, duration)]) - seen

    left = off(start)
    for _ in range(ROUNDS):
        better = _closer(off, start, left)
        if better is None:
            break
        start, left = better
    return np.asarray(np.sum(left[:2] ** 2, axis=0))


def _closer(off: Any, start: Command, left: np.ndarray) -> tuple[Command, np.ndarray] | None:
    """A Gauss-Newton step of the starting state, shortened until it helps; None if it cannot."""
    slopes = [
        (off(start._replace(**{n: getattr(start, n) + h})) - left).ravel() / h
        for n, h in STARTS.items()
    ]
    change = -np.linalg.lstsq(np.stack(slopes, axis=1), left.ravel(), rcond=1e-9)[0]
    for share in (1.0, 0.3, 0.1):
        moved = {
            n: getattr(start, n) + share * float(d) for n, d in zip(STARTS, change, strict=True)
        }
        tried = start._replace(**moved)
        now = off(tried)
        if np.sum(now**2) < 0.999 * np.sum(left**2):
            return tried, now
    return None

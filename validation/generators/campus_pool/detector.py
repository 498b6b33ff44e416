"""Ideal detector: information of all trials about hidden laws, everything else marginalised.

A Kalman filter is linearised about the true paths.  Its state holds the six states, a weak moving
water (Ornstein-Uhlenbeck), a servo error and a thrust scatter of the trial, and the recoil.  Each
law is a column: its effect on the accelerations along the path and on the read labels.
"""

from __future__ import annotations

import numpy as np

from .dynamics import commands, evaluate
from .observe import SEEN, delays, keypoints, optical, optical_shift
from .registry import FORMS, Law
from .simulate import Path
from .world import COEFFICIENTS, World

NX = 12
DIMS = 3
PRIOR_DIM = 0.003


class Column:
    """Effect of one parameter: accelerations (6, K, N) and label displacements (SEEN, K, N)."""

    def __init__(self, rate: np.ndarray, shift: np.ndarray) -> None:
        """Store the two parts."""
        self.rate, self.shift = rate, shift


class Detector:
    """Linearisation of a study about its true paths, and the information it carries."""

    def __init__(self, world: World, laws: list[Law], path: Path) -> None:
        """Prepare the linearisation on a grid of 30 Hz."""
        self.world, self.laws = world, laws
        self.path = path.thin(2)
        self.shape = self.path.phi.shape
        self.t = self.path.grid
        self.dt = float(self.path.t[1] - self.path.t[0])
        self.base = evaluate(world, self.t, self.path.state, laws)
        self.points = keypoints(world, self.path, laws)
        self.phase = 2 * np.pi * np.cumsum(self.path.f, axis=1) * self.dt
        self.zero_shift = np.zeros((SEEN, *self.shape), complex)
        self._linearise()
        self.nuisance = self._coefficients() + self._dimensions()

    def _linearise(self) -> None:
        """Matrices of the filter: dynamics (N, K, NX, NX) and readings (N, K, 2 SEEN, NX)."""
        w, s = self.world, self.path.state
        k, n = self.shape
        a = np.zeros((k, n, NX, NX))
        steps = [1e-4, 1e-4, 1e-4, 1e-4 * w.scales.speed, 1e-4 * w.scales.speed, 1e-4]
        for j, h in enumerate(steps):
            up, down = s.copy(), s.copy()
            up[j] += h
            down[j] -= h
            slope = (evaluate(w, self.t, up, self.laws) - evaluate(w, self.t, down, self.laws)) / (
                2 * h
            )
            a[:, :, :6, j] = np.moveaxis(slope[:6], 0, -1)
        h = 1e-4 * w.scales.speed
        for j, args in (
            (6, {"water": h}),
            (7, {"water": 1j * h}),
            (8, {"phi": h}),
            (9, {"thrust": 1 + h}),
        ):
            slope = (evaluate(w, self.t, s, self.laws, **args) - self.base) / h
            a[:, :, :6, j] = np.moveaxis(slope[:6], 0, -1)
        tau = w.noise["water_tau_s"]
        a[:, :, 6, 6] = a[:, :, 7, 7] = -1.0 / tau
        step = a * self.dt
        self.phi = np.moveaxis(np.eye(NX) + step + 0.5 * step @ step, 1, 0)
        q = np.zeros(NX)
        q[6] = q[7] = 2 * w.noise["water_m_s"] ** 2 / tau * self.dt
        q[2], q[5] = 1e-14, 1e-12
        self.q = np.diag(q)
        p = self.points
        c = np.zeros((SEEN, k, n, NX), complex)
        c[..., 0], c[..., 1] = 1.0, 1j
        rock = [1j * (p[i] - p[2]) for i in range(SEEN)]
        bend = [1j * (p[min(i, 3) if i else 1] - p[2]) for i in range(SEEN)]
        for i in range(SEEN):
            c[i, :, :, 2], c[i, :, :, 8] = rock[i], bend[i]
            c[i, :, :, 10] = rock[i] * np.cos(self.phase)
            c[i, :, :, 11] = rock[i] * np.sin(self.phase)
        self.c = self._stack(c)

    @staticmethod
    def _stack(c: np.ndarray) -> np.ndarray:
        """Complex (SEEN, K, N, P) to real (N, K, 2 SEEN, P)."""
        return np.moveaxis(np.concatenate([c.real, c.imag]), (0, 1, 2), (2, 1, 0))

    def _coefficients(self) -> list[Column]:
        """Columns of the six coefficients (relative changes)."""
        out = []
        for name in COEFFICIENTS:
            old = self.world.coef[name]
            self.world.coef[name] = old * 1.001
            out.append(Column(1e3 * (self._rate(self.laws) - self.base)[:6], self.zero_shift))
            self.world.coef[name] = old
        return out

    def _dimensions(self) -> list[Column]:
        """Columns of the stated lengths, with a prior of 0.3 per cent."""
        out = []
        for j in range(DIMS):
            sizes = [1.0, 1.0, 1.0]
            sizes[j] = 1.001
            moved = keypoints(self.world, self.path, self.laws, sizes=sizes)
            shift = 1e3 * (np.stack(moved[:SEEN]) - np.stack(self.points[:SEEN]))
            out.append(Column(0 * self.base[:6], shift))
        return out

    def _rate(self, laws: list[Law], state: np.ndarray | None = None) -> np.ndarray:
        """Time derivative along the path under other laws."""
        return evaluate(self.world, self.t, self.path.state if state is None else state, laws)

    def _memory(self, law: Law) -> np.ndarray:
        """States with the lift memories that a lag law would have along the path."""
        state = self.path.state.copy()
        for i in range(self.shape[1] - 1):
            now = state[:, :, i : i + 1]
            for _ in range(3):
                rate = evaluate(self.world, self.t[:, i : i + 1], now, [law])[6:8]
                limit = 5.0 * (np.abs(self.world.coef["C_La"]) + 1)
                now = now.copy()
                now[6:8] = np.clip(now[6:8] + rate * self.dt / 3, -limit, limit)
            state[6:8, :, i + 1 : i + 2] = now[6:8]
        return state

    def column(self, law: Law, present: bool) -> Column:
        """Effect of a law that is present in the truth, or of one added to it."""
        other = [one for one in self.laws if one is not law] if present else [*self.laws, law]
        sign = -1.0 if present else 1.0
        shift = self.zero_shift
        rate = 0 * self.base[:6]
        if law in optical([law]):
            return Column(rate, optical_shift(self.world, self.path, self.points, [law]))
        if law.stage == "clock":
            still = np.stack(self.points[:SEEN])
            angle = self.world.noise["recoil_rad"] * np.sin(self.phase)
            rocked = still + 1j * angle * (still - self.points[2])
            pace = np.gradient(rocked, self.dt, axis=2)
            return Column(rate, pace * delays(self.world, self.path, [law]))
        if law.stage != "label":
            state = self._memory(law) if law.name == "lift_lag" and not present else None
            rate = sign * (self._rate(other, state) - self.base)[:6]
        if law.stage in ("label", "command") or law.name == "centre_of_mass_shift":
            phi, _f = commands(self.world, self.t, self.path.state, other)
            path = Path(self.path.t, self.path.state, phi, self.path.f, self.path.end)
            moved = np.stack(keypoints(self.world, path, other)[:SEEN])
            shift = sign * (moved - np.stack(self.points[:SEEN]))
        return Column(rate, shift)

    def information(self, columns: list[Column]) -> np.ndarray:
        """Information matrix of the columns with the filter's own states marginalised."""
        w, (k, n) = self.world, self.shape
        b = np.moveaxis(np.stack([c.rate for c in columns], -1), (0, 1, 2), (2, 1, 0))
        shifts = self._stack(np.stack([c.shift for c in columns], -1))
        count = len(columns)
        e = np.zeros((k, NX, count))
        rest = w.trials.rest[:, 0] > 0
        p = np.zeros((k, NX, NX))
        first = (
            np.array(
                [
                    1,
                    1,
                    1,
                    1,
                    1,
                    1,
                    w.noise["water_m_s"],
                    w.noise["water_m_s"],
                    np.radians(0.3),
                    0.005,
                    0.1,
                    0.1,
                ]
            )
            ** 2
        )
        p[:] = np.diag(first)
        p[rest, 3, 3] = p[rest, 4, 4] = (0.005 * w.scales.speed) ** 2
        p[rest, 5, 5] = (0.005 * w.scales.rate) ** 2
        r = np.eye(2 * SEEN) * w.noise["effective_m"] ** 2
        total = np.zeros((count, count))
        for i in range(n):
            live = self.path.t[i] <= self.path.end
            if not live.any():
                break
            if i:
                e = self.phi[i - 1] @ e
                e[:, :6] += 0.5 * self.dt * (b[i - 1] + b[i])
                p = self.phi[i - 1] @ p @ np.swapaxes(self.phi[i - 1], 1, 2) + self.q
                p = 0.5 * (p + np.swapaxes(p, 1, 2))
            if i % 2:
                continue
            c = self.c[i]
            pc = p @ np.swapaxes(c, 1, 2)
            s = c @ pc + r
            root = np.linalg.inv(np.linalg.cholesky(s)) * live[:, None, None]
            new = root @ (c @ e + shifts[i])
            flat = new.reshape(-1, count)
            total += flat.T @ flat
            gain = pc @ np.swapaxes(root, 1, 2)
            e = e - gain @ new
            p = p - gain @ np.swapaxes(gain, 1, 2)
        return total


def remaining(info: np.ndarray, keep: int, free: list[int], prior: np.ndarray) -> float:
    """Sigma of column `keep` (its full effect is one) with the columns `free` marginalised."""
    free = [j for j in free if info[j, j] > 1e-6]
    if not free:
        return float(np.sqrt(max(info[keep, keep], 0.0)))
    a = info[np.ix_(free, free)] + np.diag(prior[free])
    scale = 1 / np.sqrt(np.diag(a))
    values, vectors = np.linalg.eigh(a * scale[:, None] * scale)
    row = (info[keep, free] * scale) @ vectors
    good = values > 1e-8
    left = info[keep, keep] - np.sum(row[good] ** 2 / values[good])
    return float(np.sqrt(max(left, 0.0)))


def rivals(rng: np.random.Generator, skip: set[str]) -> list[tuple[str, list[Law]]]:
    """Rival laws: each form of each cause that is not hidden, with two draws of its shape."""
    out = []
    for name, forms in FORMS.items():
        if name in skip:
            continue
        for one in forms:
            out.append((name, [one.draw(rng), one.draw(rng)]))
    return out

# ruff: noqa: PLR0917
# Compiled laws take no keywords.
"""Detectability of every hidden effect, in sigma, for an ideal observer.

A Kalman filter along the true path (blocks of 0.2 s, tangent-linear dynamics) whitens what an
effect
changes. The filter state is pose and rates (6), random water (2), tracking errors (4, first-order
autoregressive), servo error, frequency error and residual swirl. An effect enters as the
difference g
of one block's motion with and without it from the same true state, and as the difference dy of
what is
read from the pixels. The deviation z between truth and the observer's prediction obeys

    e = H z + dy,   z' = F (z - K e) + g,

which is stable where open-loop paths are not. Starting poses are diffuse. Whitened columns of
the six
coefficients and of the other effects are projected out by least squares; the norm of the rest
is sigma.
Where body lengths are read (measurement errors, sinking), their per-trial scale enters with 0.15 %
per trial and 0.3 % label placement per study; a wrong clock also shows as a tail-beat frequency
that disagrees with the log (0.4 % per trial).

Checked by brute force (tests): the joint covariance of all block observations of one trial,
built from
the same linear model without recursion, gives the same norm to 1e-6.
"""

import math

import numpy as np

from . import camera as cam
from . import dynamics as dyn
from . import effects as eff
from . import world as wd
from .forces import jit

BLOCK_STEPS = 200
STATE_SIZE = 15
OBSERVATION_EFFECTS = (*eff.MEASUREMENT, "sinking")


@jit
def advance_blocks(b, c, states, f, phi, w, swirl, k, p, hist, dstate, dw):
    """End states (blocks, 8) of blocks started at the true states plus ``dstate``, water plus
    ``dw``.
    """
    n = (len(states) - 1) // BLOCK_STEPS
    out = np.empty((n, 8))
    for j in range(n):
        i = j * BLOCK_STEPS
        out[j] = dyn.advance_state(
            b, c, states[i] + dstate, i, BLOCK_STEPS, f, phi, w + dw, swirl, k, p, hist
        )
    return out


def linearise_blocks(
    world: wd.StudyWorld, trial: wd.Trial, states: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Transition matrices (blocks, 15, 15) and forcings (blocks, 15, effects + 6)."""
    b, c = world.body(trial.head_length), world.coefficients
    k, p = eff.effect_table(world.effects)
    f, phi = wd.trial_inputs(world, trial)
    tail = eff.step_times(len(states) - 1)[::20]
    hist = np.column_stack([states[::20, :2], 0 * tail, tail])
    w, swirl, zero = trial.water, trial.swirl, np.zeros(8)

    def run(c=c, f=f, phi=phi, swirl=swirl, k=k, d=zero, dw=0j):
        return advance_blocks(b, c, states, f, phi, w, swirl, k, p, hist, d, dw)[:, :6]

    base = run()
    F = np.zeros((len(base), STATE_SIZE, STATE_SIZE))
    for i, eps in enumerate((1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-3)):
        F[:, :6, i] = (run(d=eps * np.eye(8)[i]) - base) / eps
    for i, dw in enumerate((1e-4, 1e-4j)):
        F[:, :6, 6 + i] = (run(dw=dw) - base) / 1e-4
    F[:, :6, 12] = (run(phi=phi + 1e-4) - base) / 1e-4
    F[:, :6, 13] = (run(f=f * 1.001) - base) / 1e-3
    F[:, :6, 14] = (run(swirl=swirl + 1e-3) - base) / 1e-3
    ar, ou = np.exp(-0.2 / np.array([world.noise["track_tau_s"], world.noise["water_tau_s"]]))
    diag = np.array([ou] * 2 + [ar] * 4 + [1.0] * 3)
    F[:, range(6, STATE_SIZE), range(6, STATE_SIZE)] = diag
    g = np.zeros((len(base), STATE_SIZE, len(world.effects) + 6))
    for j, e in enumerate(world.effects):
        k_off = k.copy()
        if e.name in dyn.EFFECT_ROW:
            k_off[dyn.EFFECT_ROW[e.name]] = 0
        f_off, phi_off = wd.trial_inputs(world, trial, e.name)
        g[:, :6, j] = base - run(k=k_off, f=f_off, phi=phi_off)
    for j, name in enumerate(c._fields):
        g[:, :6, len(world.effects) + j] = (
            run(c=c._replace(**{name: 1.01 * getattr(c, name)})) - base
        )
    return F, g


def observed_pose(xy: np.ndarray) -> np.ndarray:
    """Observed x, y, head heading and core heading (n, 4) of marked points (n, 5, 2)."""
    head, core = xy[:, 0] - xy[:, 1], xy[:, 1] - xy[:, 3]
    both = [np.unwrap(np.arctan2(v[:, 1], v[:, 0])) for v in (head, core)]
    return np.column_stack([xy[:, 2], *both])


def observation_changes(
    world: wd.StudyWorld, n_trial: int, states: np.ndarray
) -> tuple[np.ndarray, float]:
    """Change dy (blocks, 4) of the reading by hidden measurement errors, and of the body's
    scale.
    """
    trial = world.trials[n_trial]
    t_said = 0.2 * np.arange(1, (len(states) - 1) // BLOCK_STEPS + 1)
    t = t_said * wd.stated_clock_rate(world, n_trial)
    grid = eff.step_times(len(states) - 1)
    s = np.stack([np.interp(t_said, grid, states[:, i]) for i in range(6)], 1)
    ideal = np.column_stack([s[:, :3], s[:, 2]])
    s_t = np.stack([np.interp(t, grid, states[:, i]) for i in range(6)], 1)
    s_t[:, :3] += s_t[:, 3:6] * np.maximum(t - grid[-1], 0)[:, None]
    phi = wd.trial_inputs(world, trial)[1]
    active = world.by_name()
    for name in ("servo_lag", "head_angle_offset"):
        if name in active:
            break
    else:
        name = ""
    phi_off = wd.trial_inputs(world, trial, name)[1]
    at = np.minimum(np.round(1000 * t).astype(int), len(phi) - 1)
    xy = wd.keypoint_positions(world, trial, s_t, phi[at])
    px = wd.keypoint_pixels(world, n_trial, xy, t)
    c, depth, index, _ = wd.stated_optics(world, wd.corner_pixels(world))
    read = cam.pixels_to_pool(c, px.reshape(-1, 2), depth, index).reshape(-1, 5, 2)
    dy = observed_pose(read) - ideal - np.column_stack([0 * t, 0 * t, 0 * t, phi_off[at]])
    dy[:, 2:] = (dy[:, 2:] + np.pi) % (2 * np.pi) - np.pi
    gone = np.concatenate([[0.0], np.cumsum(phi - phi_off)])
    block = np.minimum(np.round(1000 * t_said).astype(int), len(phi) - 1)
    dy[:, 3] += (gone[block] - gone[block - BLOCK_STEPS]) / BLOCK_STEPS - (phi - phi_off)[at]
    scale = np.linalg.norm(read[:, 1] - read[:, 3], axis=1) / world.body(0.12).core - 1
    return dy, float(scale.mean())


def noise_model(world: wd.StudyWorld, trial: wd.Trial) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Process covariance Q, block-averaged white R and starting covariance P of the filter."""
    n, ppm = world.noise, world.camera.fx / world.camera.C[2]
    lever = np.array([1, 1, math.sqrt(2) / trial.head_length, math.sqrt(2) / world.body(0.12).core])
    x = 0.2 / n["track_tau_s"]
    ar_var = (n["track_px"] * trial.light / ppm * lever) ** 2 * 2 * (x - 1 + math.exp(-x)) / x**2
    ou = math.exp(-0.2 / n["water_tau_s"])
    Q = np.zeros(STATE_SIZE)
    Q[:6] = 1e-12
    Q[6:8] = n["water_m_s"] ** 2 * (1 - ou**2)
    Q[8:12] = ar_var * (1 - math.exp(-2 * x))
    R = np.diag((n["white_px"] * trial.light / ppm * lever) ** 2 / (0.2 * n["fps"]))
    P = np.diag([
        1, 1, 1, 4e-4, 4e-4, 1e-3, *[n["water_m_s"] ** 2] * 2, *ar_var,
        n["servo_rad"] ** 2, n["flap_share"] ** 2, n["swirl_per_s"] ** 2 + 1e-12,
    ])  # fmt: skip
    return np.diag(Q), R, P


OBSERVATION_MATRIX = np.zeros((4, STATE_SIZE))
OBSERVATION_MATRIX[[0, 1, 2, 3], [0, 1, 2, 2]] = 1.0
OBSERVATION_MATRIX[range(4), range(8, 12)] = 1.0
OBSERVATION_MATRIX[3, 12] = 1.0


def whitened_innovations(F: np.ndarray, g: np.ndarray, dy: np.ndarray, noise: tuple) -> np.ndarray:
    """Whitened innovations (4 blocks, columns) that forcings ``g`` and misreadings ``dy`` cause."""
    Q, R, P = noise
    z = np.zeros((STATE_SIZE, g.shape[2]))
    rows = []
    for j in range(len(F)):
        P = F[j] @ P @ F[j].T + Q
        z = F[j] @ z + g[j]
        S = OBSERVATION_MATRIX @ P @ OBSERVATION_MATRIX.T + R
        e = OBSERVATION_MATRIX @ z + dy[j]
        rows.append(np.linalg.solve(np.linalg.cholesky(S), e))
        K = np.linalg.solve(S, OBSERVATION_MATRIX @ P).T
        P = P - K @ S @ K.T
        P = 0.5 * (P + P.T)
        z = z - K @ e
    return np.concatenate(rows) if rows else np.zeros((0, g.shape[2]))


def whitened_columns(world: wd.StudyWorld) -> np.ndarray:
    """Whitened columns (rows, effects + 6 + 1) of all trials; the last is the label placement
    scale.
    """
    n_eff, out, extra = len(world.effects), [], []
    reads = [
        e.name in (*OBSERVATION_EFFECTS, "servo_lag", "head_angle_offset", "centre_of_mass_shift")
        for e in world.effects
    ]
    for i, trial in enumerate(world.trials):
        states = wd.trial_path(world, trial)
        if len(states) <= BLOCK_STEPS:
            continue
        F, g = linearise_blocks(world, trial, states)
        dy, scale = np.zeros((len(F), 4, n_eff + 6)), np.zeros(n_eff + 7)
        for j in np.flatnonzero(reads):
            alone = wd.replace(world, effects=(world.effects[j],))
            dy[:, :, j], change = observation_changes(alone, i, states)
            scale[j] = change if world.effects[j].name in OBSERVATION_EFFECTS else 0.0
        e = whitened_innovations(F, g, dy, noise_model(world, trial))
        out.append(np.column_stack([e, np.zeros(len(e))]))
        beat = np.zeros(n_eff + 7)
        for j, effect in enumerate(world.effects):
            if effect.name == "clock_error":
                beat[j] = (wd.stated_clock_rate(world, i) - 1) / 0.004
        scale[-1] = 0.003
        extra += [scale / 0.0015, beat]
    prior = np.zeros(n_eff + 7)
    prior[-1] = 1.0
    return np.concatenate([*out, np.array(extra), prior[None]])


def detectability_sigmas(world: wd.StudyWorld) -> dict[str, float]:
    """Sigma of every effect of ``world`` after projecting out coefficients and the other
    effects.
    """
    M = whitened_columns(world)
    size = np.linalg.norm(M, axis=0)
    M = M[:, size > 0] / size[size > 0]
    kept = np.flatnonzero(size > 0)
    found = {}
    for j, e in enumerate(world.effects):
        col = np.flatnonzero(kept == j)
        if not len(col):
            found[e.name] = 0.0
            continue
        rest = np.delete(M, col[0], axis=1)
        target = M[:, col[0]]
        left = target - rest @ np.linalg.lstsq(rest, target, rcond=1e-9)[0]
        found[e.name] = float(np.linalg.norm(left) * size[j])
    return found

"""Detectability of hidden effects by an ideal linear-Gaussian observer.

Every trial is cut into blocks of about 0.2 s. From each block's true state the integrator is
restarted
with perturbed states, coefficients, water, head angle and frequency, and with each effect off; the
differences at the block's end give a linear time-varying model. A Kalman filter (state: dynamics,
water
motion as an Ornstein-Uhlenbeck process, per-trial servo and frequency errors with their stated
spread,
correlated tracking error) turns the observable change (x, y, heading) into whitened innovations;
because
the filter is closed along the path, unstable swimming does not matter. Per-trial starts are in the
filter's first covariance. The six coefficients and the strengths of the other effects are
projected out.
Measurement errors also change apparent body shape (labels assumed placed to 1 mm) and, for the
clock,
the tail-beat frequency (known to 1 % a trial); these are added in quadrature.

Checked by brute force in `test_sigma_equals_that_of_full_covariance`: on a stable finned robot, the
whitened norm of the plain difference of two simulated trials, with the covariance of full-length
trials
simulated in Monte Carlo water, agrees with the filter.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from validation.generators.strip_theory.camera import Camera
from validation.generators.strip_theory.dynamics import STATE_SIZE, block_ends
from validation.generators.strip_theory.effects import Form
from validation.generators.strip_theory.noise import Noise
from validation.generators.strip_theory.optics import StatedSetup, apparent_poses, stated_optics
from validation.generators.strip_theory.parameters import COEFFICIENTS, INDEX, KEYS
from validation.generators.strip_theory.tank import SimulatedTrial, input_series

Floats = NDArray[np.float64]
BLOCK_S = 0.2
WATER_CORRELATION_S = 2.0  # s
SERVO_STD, FLAP_STD = math.radians(0.3), 0.003
START_STD = np.array([1.0, 1.0, 0.01, 0.01, 1.0, 0.05, 1.0, 1.0])
LABEL_STD, BEAT_STD = 1e-3, 0.01  # m; share of the frequency a trial
OBSERVATION_SWITCHES = {"SINK", "COM_SHIFT", "SCALE", "CLOCK", "SHIFT", "REFR", "LENS", "BIAS"}
FILTER_STATE_SIZE = STATE_SIZE + 7  # water 2, servo, flap, correlated tracking error 3


@dataclass(frozen=True)
class ObservationScene:
    """True camera, true keypoint depth (m) and noise of the study."""

    camera: Camera
    depth: float
    noise: Noise

    @property
    def metres_per_pixel(self) -> float:
        """Scale at the pool's middle."""
        return self.camera.position[2] / self.camera.focal[0]


def frames_per_block(run: SimulatedTrial) -> int:
    """Frames a block."""
    return max(2, round(BLOCK_S * run.trial.fps))


def block_end_states(run: SimulatedTrial, Y: Floats, P: Floats, **change: Floats) -> Floats:
    """End states of the blocks, with changed parameters or series."""
    phi, freq = change.get("phi", run.phi), change.get("freq", run.freq)
    extra = change.get("extra", run.extra)
    return block_ends(
        Y, frames_per_block(run), run.dt, run.sub, phi, freq, extra, P, run.trial.modes
    )


def block_jacobians(run: SimulatedTrial, Y: Floats) -> Floats:
    """Block Jacobians `(blocks, 8, 12)`: state, water velocity, head angle, relative frequency."""
    base, h = block_end_states(run, Y, run.P), 1e-5
    columns = [(block_end_states(run, Y + h * d, run.P) - base) / h for d in np.eye(STATE_SIZE)]
    columns += [
        (block_end_states(run, Y, run.P, extra=run.extra + h * u) - base) / h for u in (1.0, 1j)
    ]
    columns.append((block_end_states(run, Y, run.P, phi=run.phi + h) - base) / h)
    columns.append((block_end_states(run, Y, run.P, freq=run.freq * (1 + h)) - base) / h)
    return np.stack(columns, axis=2)


def block_changes(run: SimulatedTrial, Y: Floats, forms: list[Form]) -> Floats:
    """Change of the blocks' end states `(blocks, 8, 6 + effects)` by coefficients and effects."""
    base, out = block_end_states(run, Y, run.P), []
    for name in COEFFICIENTS:
        P = run.P.copy()
        P[INDEX[name]] *= 1.001
        out.append((block_end_states(run, Y, P) - base) / 1e-3)
    for form in forms:
        off = form.without(run.P)
        _, _, phi, freq = input_series(run.trial, off, len(run.Y))
        change = {"phi": phi[: len(run.phi)], "freq": freq[: len(run.freq)]}
        if form.strength == "WAKE":
            change["extra"] = np.zeros_like(run.extra)
        out.append(base - block_end_states(run, Y, off, **change))
    return np.stack(out, axis=2)


def tracking_variances(run: SimulatedTrial, scene: ObservationScene) -> tuple[Floats, Floats]:
    """Variances of the pose (x, y, heading): white part of a block, and correlated part.

    Rigid fit of n = 4 points with spread r^2 (sum of squared distances from their mean).
    """
    x = np.array([run.P[KEYS.HINGE] + run.P[KEYS.HEAD], run.P[KEYS.HINGE], 0.0, -run.P[KEYS.AFT]])
    spread = np.sum((x - x.mean()) ** 2)
    px, n = scene.metres_per_pixel, scene.noise
    own = np.array([1 / 4, 1 / 4, 1 / spread])
    white = (n.white_px * px) ** 2 * own / frames_per_block(run)
    return white, (n.correlated_px * px) ** 2 * 0.5 * (own + np.array([1.0, 1.0, 0.0]))


def whitened_innovations(
    run: SimulatedTrial, scene: ObservationScene, G: Floats, D: Floats, F8: Floats
) -> Floats:
    """Whitened innovations `(3 blocks, columns)` that pushes G and observed changes D cause."""
    T = frames_per_block(run) / run.trial.fps
    white, slow = tracking_variances(run, scene)
    a_water, a_track = math.exp(-T / WATER_CORRELATION_S), math.exp(-T / scene.noise.correlation_s)
    water = (1.2 * scene.noise.water_rms_m_s) ** 2
    start = [*START_STD**2, water, water, SERVO_STD**2, FLAP_STD**2, *slow]
    C, H = np.diag(start), np.zeros((3, FILTER_STATE_SIZE))
    H[[0, 1, 2], [0, 1, 4]] = 1.0
    H[[0, 1, 2], [12, 13, 14]] = 1.0
    Q = np.diag([1e-12] * STATE_SIZE + [water * (1 - a_water**2)] * 2 + [0.0] * 2
                + list(slow * (1 - a_track**2)))  # fmt: skip
    d, out = np.zeros((FILTER_STATE_SIZE, G.shape[2])), []
    for k in range(len(F8)):
        S = H @ C @ H.T + np.diag(white)
        L = np.linalg.cholesky(S)
        e = H @ d + D[k]
        out.append(np.linalg.solve(L, e))
        gain = np.linalg.solve(S, H @ C).T
        d, C = d - gain @ e, C - gain @ H @ C
        F = np.diag([1.0] * STATE_SIZE + [a_water] * 2 + [1.0] * 2 + [a_track] * 3)
        F[:STATE_SIZE, : STATE_SIZE + 4] = F8[k]
        C = F @ C @ F.T + Q
        C, d = 0.5 * (C + C.T), F @ d
        d[:STATE_SIZE] += G[k]
    return np.concatenate(out)


def observed_changes(
    run: SimulatedTrial,
    frames: NDArray[np.int64],
    forms: list[Form],
    scene: ObservationScene,
    reported: list[list[StatedSetup]],
) -> tuple[Floats, Floats]:
    """Change of apparent pose `(n, 3, 6 + effects)` and mean shape misfit `(effects, 8)`, m."""
    D = np.zeros((len(frames), 3, 6 + len(forms)))
    misfit = np.zeros((len(forms), 8))
    for j, form in enumerate(forms):
        if form.strength not in OBSERVATION_SWITCHES:
            continue
        both = []
        for own, stated in zip((run.P, form.without(run.P)), reported[j], strict=True):
            both.append(
                apparent_poses(replace(run, P=own), frames, scene.camera, scene.depth, stated)
            )
        change = both[0][0] - both[1][0]
        change[:, 2] = np.angle(np.exp(1j * change[:, 2]))
        D[:, :, 6 + j] = change
        shape = (both[0][1] - both[1][1]).mean(axis=0)
        misfit[j] = [*shape.real, *shape.imag]
    return D, misfit


def residual_norms(E: Floats, first: int) -> list[float]:
    """Norm of every column from `first` on after projecting out all other columns."""
    scale = np.linalg.norm(E, axis=0) + 1e-30
    out = []
    for j in range(first, E.shape[1]):
        rest = np.delete(E / scale, j, axis=1)
        coefficients = np.linalg.lstsq(rest, E[:, j], rcond=1e-10)[0]
        out.append(float(np.linalg.norm(E[:, j] - rest @ coefficients)))
    return out


def detectability(
    runs: list[SimulatedTrial], P: Floats, forms: list[Form], scene: ObservationScene
) -> list[float]:
    """Detectability (sigma) of each effect in `forms`, all of which `P` holds."""
    rows, shapes = [], []
    exact = np.zeros((4, 2))
    reported = [
        [stated_optics(scene.camera, scene.depth, p, exact) for p in (P, form.without(P))]
        if form.strength in OBSERVATION_SWITCHES
        else []
        for form in forms
    ]
    for run in runs:
        blocks = (len(run.Y) - 1) // frames_per_block(run)
        frames = np.arange(blocks) * frames_per_block(run)
        Y = run.Y[frames]
        D, misfit = observed_changes(run, frames, forms, scene, reported)
        rows.append(
            whitened_innovations(
                run, scene, block_changes(run, Y, forms), D, block_jacobians(run, Y)
            )
        )
        shapes.append(misfit)
    path = residual_norms(np.concatenate(rows), 6)
    shape = np.linalg.norm(np.mean(shapes, axis=0), axis=1) / LABEL_STD
    beat = abs(P[KEYS.CLOCK]) / BEAT_STD * math.sqrt(len(runs))
    return [
        math.sqrt(p**2 + (s**2 + (beat**2 if f.strength == "CLOCK" else 0.0))
                  * (f.kind == "measurement"))
        for p, s, f in zip(path, shape, forms, strict=True)
    ]  # fmt: skip

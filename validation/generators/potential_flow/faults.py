"""Errors of measurement: what is wrong between the robot's motion and the study's files.

Stages: `exposure` returns true times of the frames, `picture` pixels, `stated` the camera and pool
of study.yaml, `label` offsets of the five labels (complex, m, body axes), `depth` metres below the
keypoints' depth.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

# Exposure: s.t nominal times (s), s.order trial, s.power.


def clock_constant(s, k, _):
    """True time t (1 + k)."""
    return s.t * (1 + k)


def clock_some_trials(s, k, p):
    """True time t (1 + k) from trial number `first` on."""
    return s.t * (1 + k * (s.order >= p["first"] * s.trials))


def clock_drift(s, k, _):
    """True time t (1 + k t/8 s): the clock drifts within each recording."""
    return s.t * (1 + k * s.t / 8)


def offset_video_first(s, k, _):
    """The video begins k before the motor and its log."""
    return s.t - k


def offset_log_first(s, k, _):
    """The log and the motor begin k before the video."""
    return s.t + k


def offset_per_trial(s, k, p):
    """Video first by k (1 + 0.9 sin(order c)): by another time in each trial."""
    return s.t - k * (1 + 0.9 * np.sin(s.order * p["c"]))


# Picture: s.px (frames, 5, 2), s.t, s.order, s.centre.


def _displacements_so_far(s, at):
    """1 after the trial's bump, in half of the trials, (frames, 1, 1)."""
    return ((s.t > at) & (s.order % 2 == 0)).astype(float)[:, None, None]


def shift_translation(s, k, p):
    """All by k px in the direction `bearing` after a bump, in half of the trials."""
    step = np.array([np.cos(p["bearing"]), np.sin(p["bearing"])])
    return s.px + k * step * _displacements_so_far(s, p["at"])


def shift_rotation(s, k, p):
    """Roll by k (rad) about the picture's centre after a bump, in half of the trials."""
    out = s.px - s.centre
    turned = np.stack([-out[..., 1], out[..., 0]], -1)
    angle = k * _displacements_so_far(s, p["at"])
    return s.centre + out * np.cos(angle) + turned * np.sin(angle)


def shift_drift(s, k, p):
    """Value k px a second in the direction `bearing`: a sinking tripod."""
    step = np.array([np.cos(p["bearing"]), np.sin(p["bearing"])])
    return s.px + k * step * s.t[:, None, None]


def shift_several(s, k, p):
    """Three bumps in each trial, of k px, each 2 rad further round."""
    total = s.px
    for i in range(3):
        bearing = p["bearing"] + 2.0 * i + s.order
        step = np.array([np.cos(bearing), np.sin(bearing)])
        total = total + k * step * (s.t > 1.0 + 1.1 * i)[:, None, None]
    return total


# Stated: camera and pool (length, width, depth) as the study says.


def scale_uniform(s, k, _):
    """Length and width stated (1 + k) times too large."""
    L, W, d = s.pool
    return s.camera, (L * (1 + k), W * (1 + k), d)


def scale_one_axis(s, k, _):
    """Only the length, 2 k."""
    L, W, d = s.pool
    return s.camera, (L * (1 + 2 * k), W, d)


def scale_corner_marks(s, k, _):
    """Length and width too large by the same k W: outer instead of inner edges of the rim."""
    L, W, d = s.pool
    return s.camera, (L + k * W, W + k * W, d)


def refraction_depth(s, k, _):
    """Depth of the keypoints stated too small by k (m)."""
    return replace(s.camera, depth=s.camera.depth - k), s.pool


def refraction_index(s, k, _):
    """Index stated as 1.333 (1 - k): at most that of air."""
    return replace(s.camera, index=1.333 * (1 - k)), s.pool


def refraction_both(s, k, _):
    """Depth too small by k (m), and index by 2 k / m."""
    return replace(s.camera, depth=s.camera.depth - k, index=1.333 - 2 * k), s.pool


def _lens(s, row, k):
    changed = list(s.camera.distortion)
    changed[row] += k
    return replace(s.camera, distortion=tuple(changed)), s.pool


def lens_first(s, k, _):
    """Wrong k1."""
    return _lens(s, 0, k)


def lens_second(s, k, _):
    """Wrong k2."""
    return _lens(s, 1, k)


def lens_tangential(s, k, _):
    """Wrong p1 of a pinhole, or a fisheye's centre 900 px k beside the true one."""
    if s.camera.fisheye:
        u, v = s.camera.centre
        return replace(s.camera, centre=(u + 900 * k, v + 900 * k)), s.pool
    return _lens(s, 2, k)


def lens_focal(s, k, _):
    """Focal length (1 + k) times the true one."""
    return replace(s.camera, focal=s.camera.focal * (1 + k)), s.pool


# Labels: s.phi (frames,); returns (frames, 5) complex, ahead and to port.


def bias_all_labels(s, k, _):
    """All labels to port by k (m)."""
    return 1j * k * np.ones((len(s.phi), 5))


def bias_core_center(s, k, p):
    """One of hinge, core centre and tail base to port by k."""
    out = np.zeros((len(s.phi), 5), dtype=complex)
    out[:, 1 + int(p["label"])] = 1j * k
    return out


def bias_head_tip(s, k, _):
    """The head's tip to port by k and aft by k/2."""
    return (1j - 0.5) * k * np.array([1.0, 0, 0, 0, 0]) * np.ones((len(s.phi), 1))


def bias_with_head_angle(s, k, _):
    """Hinge and tip to port by k phi: a label that follows the turned head's edge."""
    return 1j * k * s.phi[:, None] * np.array([1.0, 1.0, 0, 0, 0])


# Depth below the keypoints' depth: s.t (s); k in m after 8 s.


def sink_linear(s, k, _):
    """Value k t / 8."""
    return k * s.t / 8


def sink_square(s, k, _):
    """Value k (t/8)^2."""
    return k * (s.t / 8) ** 2


def sink_saturating(s, k, p):
    """Value k (1 - e^(-t/tau))."""
    return k * (1 - np.exp(-s.t / p["tau"]))

"""Hidden errors of measurement, and the positions that a lab reads from its pixels."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from validation.generators.manoeuvring.camera import (
    Camera,
    pixels_to_pool,
    pool_corners,
    project,
    project_in_air,
    with_fitted_pose,
)
from validation.generators.manoeuvring.dynamics import POOL, Array, HiddenEffect


@dataclass(frozen=True)
class StatedLab:
    """What study.yaml states: lens and index, corners (8 numbers, px), lengths and depth (m)."""

    camera: Camera
    corner_px: tuple[float, ...]
    corner_height: float
    length: float
    width: float
    depth: float


def measure_lab(rng: np.random.Generator, camera: Camera, depth: float, height: float) -> StatedLab:
    """The statement of a competent lab: corners clicked to 0.2 px."""
    px = project_in_air(camera, pool_corners(*POOL, height)) + rng.normal(0, 0.2, (4, 2))
    return StatedLab(camera, tuple(np.round(px, 2).ravel()), height, *POOL, depth)


def scale_error(lab: StatedLab, s: float, form: str) -> StatedLab:
    """Pool lengths (both, or the long side) or corner spacing stated too large by 1 + s."""
    if form == "corners":
        px = np.reshape(lab.corner_px, (4, 2))
        px = px.mean(0) + (px - px.mean(0)) * (1 + s)
        return replace(lab, corner_px=tuple(np.round(px, 2).ravel()))
    width = lab.width if form == "long_side" else lab.width * (1 + s)
    return replace(lab, length=lab.length * (1 + s), width=width)


def lens_error(lab: StatedLab, s: float, form: str) -> StatedLab:
    """Stated lens: k1 off by s, all terms times 1 - s, or principal point off by 300 s px."""
    d, K = lab.camera.distortion.copy(), lab.camera.K.copy()
    if form == "radial":
        d[0] += s
    elif form == "weaker":
        d *= 1 - s
    else:
        K[:2, 2] += 300 * s * np.array([0.8, 0.6])
    return replace(lab, camera=replace(lab.camera, K=K, distortion=d))


def uncorrected_refraction(lab: StatedLab, s: float, form: str) -> StatedLab:
    """Stated refractive index 1.333 - 0.333 s, or stated depth times 1 - s."""
    if form == "depth":
        return replace(lab, depth=lab.depth * (1 - s))
    return replace(lab, camera=replace(lab.camera, index=1.333 - 0.333 * s))


STATED_ERRORS = {
    "scale_error": scale_error,
    "lens_error": lens_error,
    "uncorrected_refraction": uncorrected_refraction,
}
FORMS: dict[
    str, tuple[str, bool, dict[str, tuple[float, float, float]]]
] = {  # unit, signed, bounds
    "scale_error": ("1", True, dict.fromkeys(("both", "long_side", "corners"), (0.004, 0.03, 0.2))),
    "clock_error": ("1", True, dict.fromkeys(("constant", "growing"), (0.003, 0.03, 0.15))),
    "camera_shift": (
        "px",
        True,
        {"jump": (1, 10, 60), "drift": (0.5, 5, 60), "tilt": (2, 30, 150)},
    ),
    "uncorrected_refraction": ("1", False, dict.fromkeys(("index", "depth"), (0.05, 0.5, 1.0))),
    "lens_error": (
        "1",
        True,
        {"radial": (0.004, 0.05, 0.3), "weaker": (0.1, 0.5, 1.0), "centre": (0.01, 0.1, 0.5)},
    ),
    "time_offset": ("s", True, dict.fromkeys(("constant", "growing"), (0.02, 0.15, 1.0))),
    "keypoint_bias": (
        "m",
        True,
        dict.fromkeys(("core_along", "core_across", "head_across"), (0.0006, 0.006, 0.04)),
    ),
}


def draw_error(name: str, rng: np.random.Generator) -> tuple[HiddenEffect, tuple[float, float]]:
    """A measurement error at its start strength with a random form, and its bounds."""
    unit, signed, forms = FORMS[name]
    form = str(rng.choice(list(forms)))
    low, start, high = forms[form]
    sign = float(rng.choice([-1, 1])) if signed and form != "weaker" else 1.0
    shape = {
        "direction_rad": float(rng.uniform(-3, 3)),
        "trial_share": float(rng.uniform(0.2, 0.7)),
    }
    shape = {k: round(v, 4) for k, v in shape.items()}
    return HiddenEffect(
        name,
        form,
        "measurement",
        name,
        STATED_ERRORS.get(name, lambda *_: 0),
        sign * start,
        unit,
        shape,
    ), (
        float(low),
        float(high),
    )


def time_stretch(effect: HiddenEffect, trial: Array, trials: int) -> Array:
    """True seconds per stated second: 1 + s, or growing through the session (clock_error)."""
    g = 1.0 if effect.form == "constant" else 2 * trial / max(trials - 1, 1)
    return 1 + effect.strength * g + 0.0 * trial


def log_offset(effect: HiddenEffect, trial: Array, trials: int) -> Array:
    """Seconds by which the log's events come late (time_offset): s, or growing over the session."""
    g = 1.0 if effect.form == "constant" else 2 * trial / max(trials - 1, 1)
    return effect.strength * g + 0.0 * trial


def camera_shift(effect: HiddenEffect, px: Array, trial: Array, trials: int, share: Array) -> Array:
    """Pixels (n, 2) in the moved camera; `trial` and `share` (of the trial's time) are (n,).

    jump: s px in the middle of one trial, lasting; drift: s px within each trial; tilt: from one
    trial on, s px at the centre with the keystone of a camera turned on its mount.
    """
    k0 = int(effect.shape["trial_share"] * trials)
    a = np.array([np.cos(effect.shape["direction_rad"]), np.sin(effect.shape["direction_rad"])])
    if effect.form == "tilt":
        c = px - np.array([960.0, 540.0])
        keystone = 1 + (c @ a) * effect.strength / 1200.0**2
        return px + (trial >= k0)[:, None] * (effect.strength * a + c * (keystone - 1)[:, None])
    late = (trial > k0) | ((trial == k0) & (share > 0.45))
    return px + np.outer(late if effect.form == "jump" else share, effect.strength * a)


def keypoint_bias(effect: HiddenEffect, z: Array, phi: Array, psi: Array) -> Array:
    """Keypoints (frames, 5, 2) with one label misplaced by s m."""
    out, s = z.copy(), effect.strength
    j = 0 if effect.form == "head_across" else 2
    a = (
        psi + np.pi / 2
        if j == 0
        else psi + phi + (np.pi / 2 if effect.form == "core_across" else 0)
    )
    out[:, j] += s * np.column_stack([np.cos(a), np.sin(a)])
    return out


@lru_cache(maxsize=64)
def _fitted_camera(key: tuple) -> Camera:
    model, K, d, index, tilt, centre, px, length, width, height = key
    camera = Camera(
        model,
        (1920, 1080),
        np.reshape(K, (3, 3)),
        np.array(d),
        np.array(tilt),
        np.array(centre),
        index,
    )
    return with_fitted_pose(camera, np.reshape(px, (4, 2)), length, width, height)


def pixels_to_stated_pool(lab: StatedLab, px: Array) -> Array:
    """Pool positions (n, 2) that the lab's own statements give to pixels."""
    c = lab.camera
    key = (
        c.model,
        tuple(c.K.ravel()),
        tuple(c.distortion),
        c.index,
        tuple(c.tilt),
        tuple(c.centre),
    )
    return pixels_to_pool(
        _fitted_camera((*key, lab.corner_px, lab.length, lab.width, lab.corner_height)),
        px,
        lab.depth,
    )


def apparent_displacement(
    effect: HiddenEffect,
    lab: StatedLab,
    xy: Array,
    *,
    trial: Array,
    trials: int,
    share: Array,
    depth: Array,
) -> Array:
    """Change (n, 2), m, of the position read for points xy that an effect on the picture makes."""
    px = project(lab.camera, xy, lab.depth)
    before = pixels_to_stated_pool(lab, px)
    if effect.hook == "depth":
        return pixels_to_stated_pool(lab, project(lab.camera, xy, lab.depth + depth)) - before
    if effect.name == "camera_shift":
        return pixels_to_stated_pool(lab, camera_shift(effect, px, trial, trials, share)) - before
    return (
        pixels_to_stated_pool(STATED_ERRORS[effect.name](lab, effect.strength, effect.form), px)
        - before
    )

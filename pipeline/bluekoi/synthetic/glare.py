"""Lamps mirrored in the water surface: bright, white, wobbling patches over everything below."""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from bluekoi.synthetic.optics import Camera, pool_points_to_pixels


@dataclass(frozen=True)
class GlarePatch:
    """One mirrored lamp: its share of white `(rows, columns)`, top left pixel (even), wobble."""

    share: np.ndarray
    corner: tuple[int, int]
    phase: float
    rate_hz: float


def _lamp_image(rng: np.random.Generator, length_px: float) -> np.ndarray:
    """A lamp's picture: a streak broken up by ripples, 0 to 1, even-sized."""
    size = 2 * int(1.6 * length_px)
    v, u = np.mgrid[-1.6 : 1.6 : size * 1j, -1.6 : 1.6 : size * 1j]
    turn = rng.uniform(0, math.pi)
    along = u * math.cos(turn) + v * math.sin(turn)
    across = v * math.cos(turn) - u * math.sin(turn)
    ripple = 0.07 * np.sin(5 * along + rng.uniform(0, 6)) + 0.03 * np.sin(13 * along)
    broken = 0.55 + 0.45 * np.sin(19 * along + 9 * across + rng.uniform(0, 6))
    core = np.exp(-((across + ripple) ** 2) / 0.010 - along**4 / 0.6) * broken
    halo = 0.25 * np.exp(-(across**2) / 0.20 - along**2 / 0.9)
    return np.clip(core + halo - 0.02, 0, 1).astype(np.float32)


def random_lamp_reflections(
    rng: np.random.Generator, camera: Camera, count: int, *, pool_m: tuple[float, float]
) -> tuple[GlarePatch, ...]:
    """Mirrored lamps at random places of the surface."""
    length_px = 0.10 * camera.focal_px[0] / camera.centre_m[2]
    patches = []
    for _ in range(count):
        x, y = rng.uniform(0.15, 0.85, 2) * np.array(pool_m)
        share = _lamp_image(rng, length_px * rng.uniform(0.6, 1.4))
        middle = pool_points_to_pixels(camera, np.array([[x, y, 0.0]]))[0]
        corner = tuple(int(c - share.shape[0] / 2) // 2 * 2 for c in middle)
        patch = GlarePatch(
            share, (corner[0], corner[1]), rng.uniform(0, 6.28), rng.uniform(0.8, 2.2)
        )
        patches.append(patch)
    return tuple(patches)


def _displaced_patch(patch: GlarePatch, time_s: float) -> np.ndarray:
    angle = 2 * math.pi * patch.rate_hz * time_s + patch.phase
    shift = np.array([[1, 0, 1.6 * math.sin(angle)], [0, 1, 1.3 * math.cos(1.3 * angle)]])
    moved = cv2.warpAffine(patch.share, shift, patch.share.shape[::-1])
    return np.asarray(moved * (0.85 + 0.15 * math.sin(2.1 * angle)), dtype=np.float32)


def add_glare(
    luma: np.ndarray, chroma: np.ndarray, patch: GlarePatch, *, time_s: float, level: float
) -> None:
    """Add a lamp, `level` grey levels bright, to luma `(v, u)`, chroma `(2, v/2, u/2)` in place."""
    height, width = luma.shape
    left, top = patch.corner
    right, bottom = left + patch.share.shape[1], top + patch.share.shape[0]
    x0, y0, x1, y1 = max(left, 0), max(top, 0), min(right, width), min(bottom, height)
    if x1 - x0 < 2 or y1 - y0 < 2:
        return
    share = _displaced_patch(patch, time_s)[y0 - top : y1 - top, x0 - left : x1 - left]
    box = luma[y0:y1, x0:x1]
    box[...] = np.minimum(box + level * share, 255).astype(np.uint8)
    pale = 1 - np.minimum(share[::2, ::2] * level / 160, 1)
    for plane in chroma:
        part = plane[y0 // 2 : y1 // 2, x0 // 2 : x1 // 2]
        part[...] = np.rint(128 + (part - 128.0) * pale[: part.shape[0], : part.shape[1]])

"""The still picture of the pool and the light that moves over it."""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from bluekoi.synthetic.optics import Camera, pixels_to_pool_points

RIM_WIDTH_M = 0.055
CAUSTIC_FRAMES = 120
CAUSTIC_STEP_PX = 8
SURROUNDINGS_WIDTH_M = 1.2
FLOOR_RGB = (140.0, 204.0, 227.0)
WALL_RGB = (104.0, 172.0, 202.0)
RAY_DEFLECTION = 0.16


@dataclass(frozen=True)
class PoolImagery:
    """What does not depend on the robot, for one camera.

    luma `(v, u)` and chroma `(2, v/2, u/2)` uint8 of the resting pool; `water` `(v, u)` uint8,
    255 where water is seen; `light` `(frames, v/8, u/8)` uint8, 128 for no change, looping.
    """

    luma: np.ndarray
    chroma: np.ndarray
    water: np.ndarray
    light: np.ndarray


def to_yuv(rgb: np.ndarray) -> np.ndarray:
    """Full-range YCbCr (BT.709, chroma about 128) of RGB `(..., 3)`, both 0 to 255."""
    r, g, b = rgb[..., 0], rgb[..., 1], rgb[..., 2]
    y = 0.2126 * r + 0.7152 * g + 0.0722 * b
    return np.stack([y, (b - y) / 1.8556 + 128, (r - y) / 1.5748 + 128], axis=-1)


def pool_coordinates_of_pixels(camera: Camera, depth_m: float, step: int = 1) -> np.ndarray:
    """Pool x, y (m) seen at every `step`-th pixel, `(v, u, 2)`, at a depth; exact each 8 pixels."""
    width, height = camera.size_px
    coarse = CAUSTIC_STEP_PX
    u = np.arange(-coarse, width + 2 * coarse, coarse)
    v = np.arange(-coarse, height + 2 * coarse, coarse)
    grid = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    known = (
        pixels_to_pool_points(camera, grid, depth_m).reshape(len(v), len(u), 2).astype(np.float32)
    )
    full = (math.ceil(width / step), math.ceil(height / step))
    scale = step / coarse
    matrix = np.array([[scale, 0, 1], [0, scale, 1]], dtype=float)
    flags = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(known, matrix, full, flags=flags, borderMode=cv2.BORDER_REPLICATE)


def _multiscale_noise(
    rng: np.random.Generator, shape: tuple[int, int], cells: tuple[int, ...]
) -> np.ndarray:
    """Random texture of unit rms with grains of several sizes (in texture pixels)."""
    total = np.zeros(shape, np.float32)
    for cell in cells:
        small = rng.standard_normal((shape[0] // cell + 2, shape[1] // cell + 2)).astype(np.float32)
        total += cv2.resize(small, shape[::-1], interpolation=cv2.INTER_CUBIC)
    return total / math.sqrt(len(cells))


def floor_texture(rng: np.random.Generator, pool_m: tuple[float, float]) -> np.ndarray:
    """Reflectance of the floor, `(y, x)` at 1 mm: pale tiles of 10 cm, darker joints, speckle."""
    shape = (round(pool_m[1] * 1000), round(pool_m[0] * 1000))
    tiles = rng.normal(0, 0.025, (shape[0] // 100 + 1, shape[1] // 100 + 1)).astype(np.float32)
    shade = tiles.repeat(100, axis=0)[: shape[0]].repeat(100, axis=1)[:, : shape[1]]
    in_joint = (np.arange(max(shape)) + 2) % 100 < 4
    joint = in_joint[: shape[0], None] | in_joint[None, : shape[1]]
    speckle = 0.022 * _multiscale_noise(rng, shape, (3, 7, 40))
    return 1.0 + shade + speckle - 0.17 * cv2.GaussianBlur(joint.astype(np.float32), (0, 0), 1.2)


def surroundings_texture(rng: np.random.Generator, pool_m: tuple[float, float]) -> np.ndarray:
    """Reflectance of what surrounds the pool, `(y, x)` at 4 mm, from `-SURROUNDINGS_WIDTH_M` on."""
    shape = (
        round((pool_m[1] + 2 * SURROUNDINGS_WIDTH_M) * 250),
        round((pool_m[0] + 2 * SURROUNDINGS_WIDTH_M) * 250),
    )
    y, x = np.mgrid[: shape[0], : shape[1]]
    slabs = ((x % 125 < 2) | (y % 125 < 2)).astype(np.float32)
    return 1.0 + 0.10 * _multiscale_noise(rng, shape, (1, 4, 30)) - 0.25 * slabs


def _sample_texture(
    texture: np.ndarray, place: np.ndarray, per_m: float, origin_m: float
) -> np.ndarray:
    at = ((place - origin_m) * per_m - 0.5).astype(np.float32)
    return cv2.remap(texture, at, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def _signed_distance_inside(
    place: np.ndarray, pool_m: tuple[float, float], grow_m: float = 0.0
) -> np.ndarray:
    """Signed distance (m) inside the pool's rectangle grown by `grow_m`; negative outside."""
    x, y = place[..., 0], place[..., 1]
    across = np.minimum(x + grow_m, pool_m[0] + grow_m - x)
    return np.minimum(across, np.minimum(y + grow_m, pool_m[1] + grow_m - y))


def _blend(below: np.ndarray, above: np.ndarray, share: np.ndarray) -> np.ndarray:
    return below + (above - below) * share[..., None]


def _apply_tint(reflectance: np.ndarray, colour: tuple[float, float, float]) -> np.ndarray:
    return reflectance[..., None] * np.array(colour, np.float32)


def _vignetting(camera: Camera) -> np.ndarray:
    width, height = camera.size_px
    u = (np.arange(width) - camera.middle_px[0]) / width
    v = (np.arange(height) - camera.middle_px[1]) / width
    r2 = u[None, :] ** 2 + v[:, None] ** 2
    return (1 / (1 + 0.9 * r2) ** 2).astype(np.float32)


def _still_picture(
    camera: Camera, pool_m: tuple[float, float], depth_m: float, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """RGB `(v, u, 3)` of the pool at rest, and the share of water `(v, u)`."""
    rng = np.random.default_rng(seed)
    surface, floor = (
        pool_coordinates_of_pixels(camera, 0.0),
        pool_coordinates_of_pixels(camera, depth_m),
    )
    pixel_m = camera.centre_m[2] / camera.focal_px[0]

    def edge(distance: np.ndarray) -> np.ndarray:
        return np.clip(distance / pixel_m + 0.5, 0, 1).astype(np.float32)

    ground = _apply_tint(
        _sample_texture(surroundings_texture(rng, pool_m), surface, 250, -SURROUNDINGS_WIDTH_M),
        (106, 102, 97),
    )
    tiles = _apply_tint(_sample_texture(floor_texture(rng, pool_m), floor, 1000, 0.0), FLOOR_RGB)
    wall_shade = 0.72 + 0.8 * np.clip(_signed_distance_inside(surface, pool_m), 0, 0.2)
    water = _blend(
        _apply_tint(wall_shade, WALL_RGB), tiles, edge(_signed_distance_inside(floor, pool_m))
    )
    gap = -_signed_distance_inside(surface, pool_m) / RIM_WIDTH_M
    roundness = np.sin(np.pi * np.clip(gap, 0, 1)).astype(np.float32)
    rim = _apply_tint(0.80 + 0.20 * roundness, (205, 212, 220))
    wet = edge(_signed_distance_inside(surface, pool_m))
    picture = _blend(ground, rim, edge(_signed_distance_inside(surface, pool_m, RIM_WIDTH_M)))
    return _blend(picture, water, wet) * _vignetting(camera)[..., None], wet


def _random_ripples(rng: np.random.Generator, count: int = 14) -> np.ndarray:
    """Ripples `(count, 4)`: wavenumbers kx, ky (rad/m), whole turns per loop, phase."""
    angle = rng.uniform(0, 2 * np.pi, count)
    length = rng.uniform(0.12, 0.40, count)
    k = 2 * np.pi / length
    turns = np.maximum(np.round(4.0 * np.sqrt(9.81 * k * np.tanh(0.3 * k)) / (2 * np.pi)), 1)
    return np.column_stack([k * np.cos(angle), k * np.sin(angle), turns, angle * 7])


def caustics(floor: np.ndarray, strength: float, seed: int) -> np.ndarray:
    """Light on the floor, `(frames, v, u)` uint8 about 128: `1/|det(1 - s H)|` of the ripples.

    H is the surface's matrix of second derivatives; where rays cross, the light is brightest.
    """
    waves = _random_ripples(np.random.default_rng(seed))
    x, y = floor[..., 0].astype(np.float32), floor[..., 1].astype(np.float32)
    k2 = np.hypot(waves[:, 0], waves[:, 1]) ** 1.6
    phase = (waves[:, 0, None] * x.ravel() + waves[:, 1, None] * y.ravel()) + waves[:, 3, None]
    still = np.concatenate([np.cos(phase), np.sin(phase)]).astype(np.float32)
    turned = 2 * np.pi * np.arange(CAUSTIC_FRAMES)[:, None] / CAUSTIC_FRAMES * waves[:, 2]
    swing = np.concatenate([np.cos(turned), np.sin(turned)], axis=1)
    bend = (waves[:, 0] ** 2, waves[:, 1] ** 2, waves[:, 0] * waves[:, 1])
    xx, yy, xy = (
        RAY_DEFLECTION * (swing * np.tile(b / k2, 2)).astype(np.float32) @ still for b in bend
    )
    light = np.minimum(1 / np.maximum(np.abs((1 - xx) * (1 - yy) - xy**2), 0.2), 4)
    light = (light - light.mean(axis=1, keepdims=True)) / light.std(axis=1, keepdims=True)
    return np.clip(128 * (1 + strength * light), 40, 255).astype(np.uint8).reshape(-1, *x.shape)


def build_scene(
    camera: Camera, caustic_rms: float, *, pool_m: tuple[float, float], depth_m: float, seed: int
) -> PoolImagery:
    """Still picture and moving light for a camera; the same seed gives the same pool."""
    rgb, wet = _still_picture(camera, pool_m, depth_m, seed)
    yuv = to_yuv(rgb)
    half = (camera.size_px[0] // 2, camera.size_px[1] // 2)
    chroma = [cv2.resize(yuv[..., c], half, interpolation=cv2.INTER_AREA) for c in (1, 2)]
    light = caustics(
        pool_coordinates_of_pixels(camera, depth_m, CAUSTIC_STEP_PX), caustic_rms, seed + 1
    )
    small = cv2.resize(wet, light.shape[:0:-1], interpolation=cv2.INTER_AREA)
    light = np.round(128 + (light.astype(np.float32) - 128) * small).astype(np.uint8)
    return PoolImagery(
        luma=np.clip(np.round(yuv[..., 0]), 0, 255).astype(np.uint8),
        chroma=np.clip(np.round(np.stack(chroma)), 0, 255).astype(np.uint8),
        water=np.round(255 * wet).astype(np.uint8),
        light=light,
    )

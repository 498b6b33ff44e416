"""One frame of footage: the robot and other bodies, drawn into the illuminated pool."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from bluekoi.synthetic.body import DrawnShape, robot_shapes_to_draw
from bluekoi.synthetic.glare import GlarePatch
from bluekoi.synthetic.ground_truth_physics import Robot
from bluekoi.synthetic.optics import Camera, pool_points_to_pixels
from bluekoi.synthetic.picture_conditions import PictureConditions
from bluekoi.synthetic.raster import paint_polygons, pixels_to_canvas
from bluekoi.synthetic.scene import FLOOR_RGB, PoolImagery, to_yuv

SHADOW_SHIFT_M = 0.05 - 0.035j
NOISE_TILE_MARGIN_PX = 256


@dataclass(frozen=True)
class ImagePlanes:
    """Luma `(v, u)` and chroma `(2, v/2, u/2)` uint8 of a frame, and the light on it `(v, u)`."""

    luma: np.ndarray
    chroma: np.ndarray
    light: np.ndarray


@dataclass(frozen=True)
class FilmSetup:
    """What is constant in a recording: pool, camera, picture conditions, noise tiles, lamps."""

    scene: PoolImagery
    camera: Camera
    conditions: PictureConditions
    tiles: tuple[np.ndarray, np.ndarray]
    lamps: tuple[GlarePatch, ...] = ()


def noise_tiles(
    rng: np.random.Generator, size_px: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """Sensor noise of rms 20 about 128 for luma and chroma, uint8, larger than the picture."""
    width, height = size_px
    shape = (height + NOISE_TILE_MARGIN_PX, width + NOISE_TILE_MARGIN_PX)
    grain = cv2.GaussianBlur(rng.standard_normal(shape, np.float32), (3, 3), 0.55)
    grain *= 20 / float(grain.std())
    tile = np.clip(np.round(128 + grain), 0, 255).astype(np.uint8)
    coarse = (shape[0] // 2, shape[1] // 2)
    return tile, np.ascontiguousarray(tile[::-1][: coarse[0], : coarse[1]])


def add_light(stage: FilmSetup, frame: int) -> ImagePlanes:
    """The pool without bodies at a frame, with its moving light."""
    scene = stage.scene
    light = cv2.resize(scene.light[frame % len(scene.light)], stage.camera.size_px)
    luma = cv2.multiply(scene.luma, light, scale=1 / 128, dtype=cv2.CV_8U)
    return ImagePlanes(luma, scene.chroma.copy(), light)


def _part_colours(parts: Sequence[DrawnShape], contrast: float) -> np.ndarray:
    rgb = np.array([part.colour for part in parts])
    mixed = np.array(FLOOR_RGB) + contrast * (rgb - np.array(FLOOR_RGB))
    return np.column_stack([to_yuv(mixed), [part.opacity for part in parts]])


def _even_bounding_box(
    pixels: np.ndarray, size_px: tuple[int, int], margin: int
) -> tuple[int, ...]:
    """Left, top, right, bottom of the even box about pixels, cut to the picture."""
    low = np.floor(pixels.min(axis=0)).astype(int) - margin
    high = np.ceil(pixels.max(axis=0)).astype(int) + margin
    left, top = (max(0, int(value) // 2 * 2) for value in low)
    right, bottom = (
        min(size, (int(value) // 2 + 1) * 2) for size, value in zip(size_px, high, strict=True)
    )
    return left, top, right, bottom


def _composite_over(planes: ImagePlanes, canvas: np.ndarray, box: tuple[int, ...]) -> None:
    """Lay a premultiplied canvas `(rows, columns, 4)` over the box of the planes, in place."""
    left, top, right, bottom = box
    clear = 1 - canvas[..., 3]
    luma = planes.luma[top:bottom, left:right]
    np.rint(luma * clear + canvas[..., 0], out=canvas[..., 0])
    luma[...] = np.clip(canvas[..., 0], 0, 255)
    rows, columns = (bottom - top) // 2, (right - left) // 2
    small = canvas.reshape(rows, 2, columns, 2, 4).mean(axis=(1, 3))
    for c in (0, 1):
        chroma = planes.chroma[c, top // 2 : bottom // 2, left // 2 : right // 2]
        mixed = chroma * (1 - small[..., 3]) + small[..., c + 1]
        chroma[...] = np.clip(np.rint(mixed), 0, 255)


def draw_body(
    planes: ImagePlanes,
    stage: FilmSetup,
    poses: Sequence[Sequence[DrawnShape]],
    *,
    height_m: float,
    contrast: float = 1.0,
) -> None:
    """Draw a body, averaged over its poses in the exposure, in place, at a height (m; < 0: wet)."""
    outlines = [part.outline for parts in poses for part in parts]
    flat = np.concatenate(outlines)
    points = np.column_stack([flat.real, flat.imag, np.full(len(flat), height_m)])
    pixels = pool_points_to_pixels(stage.camera, points)
    box = _even_bounding_box(pixels, stage.camera.size_px, 2)
    if box[2] <= box[0] or box[3] <= box[1]:
        return
    cells = pixels_to_canvas(pixels, (box[0], box[1]))
    total = np.zeros((box[3] - box[1], box[2] - box[0], 4))
    canvas = np.zeros_like(total)
    begin = 0
    for parts in poses:
        ends = np.cumsum([len(part.outline) for part in parts])
        canvas[...] = 0
        paint_polygons(
            canvas, cells[begin : begin + ends[-1]], ends, _part_colours(parts, contrast)
        )
        total += canvas
        begin += int(ends[-1])
    total /= len(poses)
    lit = planes.light[box[1] : box[3], box[0] : box[2]]
    total[..., 0] *= 0.5 + lit / 256.0
    _composite_over(planes, total, box)


def _draw_shadow(
    planes: ImagePlanes, stage: FilmSetup, parts: Sequence[DrawnShape], depth_m: float
) -> None:
    """A soft shadow of a body on the floor, in place."""
    flat = np.concatenate([part.outline + SHADOW_SHIFT_M for part in parts])
    points = np.column_stack([flat.real, flat.imag, np.full(len(flat), -depth_m)])
    pixels = pool_points_to_pixels(stage.camera, points)
    box = _even_bounding_box(pixels, stage.camera.size_px, 16)
    if box[2] <= box[0] or box[3] <= box[1]:
        return
    cells = pixels_to_canvas(pixels, (box[0], box[1])) / 4
    canvas = np.zeros((-(-(box[3] - box[1]) // 4), -(-(box[2] - box[0]) // 4), 4))
    ends = np.cumsum([len(part.outline) for part in parts])
    paint_polygons(canvas, cells, ends, np.tile([0.0, 0.0, 0.0, 1.0], (len(parts), 1)))
    share = cv2.GaussianBlur(canvas[..., 3].astype(np.float32), (0, 0), 2.0)
    size = (box[2] - box[0], box[3] - box[1])
    dark = 1 - 0.28 * cv2.resize(share, (canvas.shape[1] * 4, canvas.shape[0] * 4))
    luma = planes.luma[box[1] : box[3], box[0] : box[2]]
    luma[...] = np.rint(luma * dark[: size[1], : size[0]])


def draw_robot(
    planes: ImagePlanes,
    stage: FilmSetup,
    poses: np.ndarray,
    *,
    robot: Robot,
    head_length_m: float,
    floor_m: float,
) -> None:
    """Draw the robot averaged over its poses `(sub-frames, 5)`, in place, its shadow below it."""
    markers = stage.conditions.markers
    parts = [robot_shapes_to_draw(robot, head_length_m, pose, markers=markers) for pose in poses]
    if stage.conditions.shadow:
        _draw_shadow(planes, stage, parts[len(parts) // 2], floor_m)
    depth, contrast = robot.keypoint_depth_m, stage.conditions.contrast
    draw_body(planes, stage, parts, height_m=-depth, contrast=contrast)


def add_noise(planes: ImagePlanes, stage: FilmSetup, rng: np.random.Generator) -> ImagePlanes:
    """The frame with sensor noise: what the encoder gets."""
    height, width = planes.luma.shape
    at = rng.integers(0, NOISE_TILE_MARGIN_PX, 2)
    tile = stage.tiles[0][at[0] : at[0] + height, at[1] : at[1] + width]
    share = stage.conditions.noise / 20
    luma = cv2.addWeighted(planes.luma, 1.0, tile, share, -128 * share)
    chroma = np.empty_like(planes.chroma)
    share = stage.conditions.chroma_noise / 20
    for c in (0, 1):
        at = rng.integers(0, NOISE_TILE_MARGIN_PX // 2, 2)
        tile = stage.tiles[1][at[0] : at[0] + height // 2, at[1] : at[1] + width // 2]
        chroma[c] = cv2.addWeighted(planes.chroma[c], 1.0, tile, share, -128 * share)
    return ImagePlanes(luma, chroma, planes.light)

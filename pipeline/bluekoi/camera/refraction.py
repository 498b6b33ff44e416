"""Light through the still water surface z = 0, by Snell's law: n_air sin i = n_water sin r."""

from __future__ import annotations

import numpy as np

from ..data import Float


def refract_rays(direction: Float, index: float) -> Float:
    """Unit rays (n, 3) below the surface of downward unit rays (n, 3) in air, z up.

    t = d/n + (c/n - sqrt(1 - (1 - c^2)/n^2)) z, c = -d_z: Snell's law in vector form, whose
    z part is -sqrt(1 - (1 - c^2)/n^2).
    """
    cosine = -direction[:, 2]
    under = np.sqrt(1 - (1 - cosine**2) / index**2)
    bent = direction / index
    bent[:, 2] = -under
    return bent


def intersect_rays_with_depth(
    origin: Float, direction: Float, depth_m: Float, index: float
) -> Float:
    """Points (n, 2) where rays from `origin` (3,) reach `depth_m` (n,) below the surface, m.

    Rays are unit vectors (n, 3), z up, in air; a negative depth lies above the water. NaN for
    rays that do not go down.
    """
    down = np.where(direction[:, 2] < 0, direction[:, 2], np.nan)
    height = np.maximum(-depth_m, 0.0)
    above = origin[:2] + direction[:, :2] * ((height - origin[2]) / down)[:, None]
    bent = refract_rays(direction, index)
    return above + bent[:, :2] * (np.maximum(depth_m, 0.0) / -bent[:, 2])[:, None]


def horizontal_air_path_share(
    across_m: Float, height_m: float, depth_m: Float, index: float
) -> Float:
    """Share (n,) of the horizontal way from camera to point that light goes in air.

    Root of s/sqrt(s^2 + H^2) - n (r - s)/sqrt((r - s)^2 + D^2), which grows with s in [0, r]:
    Newton's method, kept inside the bracket. across_m r, depth_m D: (n,), m; height_m H of the
    camera above the surface.
    """
    low, high = np.zeros_like(across_m), across_m.copy()
    s = across_m * height_m / (height_m + depth_m / index)
    for _ in range(60):
        rest = across_m - s
        air, water = np.hypot(s, height_m), np.hypot(rest, depth_m)
        with np.errstate(divide="ignore", invalid="ignore"):
            error = s / air - index * np.where(water > 0, rest / water, 0.0)
            slope = height_m**2 / air**3 + index * np.where(water > 0, depth_m**2 / water**3, 0.0)
        low, high = np.where(error < 0, s, low), np.where(error > 0, s, high)
        following = s - error / slope
        inside = (following >= low) & (following <= high)
        following = np.where(inside, following, (low + high) / 2)
        if np.all(np.abs(following - s) <= 1e-15 + 1e-14 * across_m):
            s = following
            break
        s = following
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(across_m > 0, s / across_m, 0.0)


def surface_points_of_light_paths(origin: Float, points: Float, index: float) -> Float:
    """Points (n, 3) as a camera at `origin` (3,) sees them: where their light leaves the water.

    Points above the surface come back unchanged; points below come back as the place on the
    surface through which their light goes, so that a straight line from there is the ray in air.
    """
    if not np.any(points[:, 2] < 0):
        return points
    way = points[:, :2] - origin[:2]
    depth = np.maximum(-points[:, 2], 0.0)
    share = horizontal_air_path_share(
        np.hypot(way[:, 0], way[:, 1]), float(origin[2]), depth, index
    )
    on_surface = np.column_stack([origin[:2] + way * share[:, None], np.zeros(len(points))])
    return np.where((points[:, 2] < 0)[:, None], on_surface, points)

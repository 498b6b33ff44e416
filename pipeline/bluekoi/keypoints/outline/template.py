"""The robot's outline: two rigid parts about a hinge, their half-widths learned from the footage.

Head: radii about a point on its axis, symmetric, in axes with the hinge at 0 and the nose at
(head length, 0). Core: half-widths along its axis, hinge at 0, caudal base at (-core length, 0).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from ...data import Float
from ...study import Robot, Trial
from .plane import metres_to_body_lengths
from .pose_fit import OutlineArrays

HEAD_PART, CORE_PART = 0, 1
HEAD_POLAR_ORIGIN_SHARE = 0.55
CORE_STATION_COUNT = 36
HEAD_STATION_COUNT = 25
UNSAMPLED_CORE_END_SHARE = 0.03


@dataclass(frozen=True)
class OutlineTemplate:
    """Outline in body lengths (nose to caudal base with the standard head).

    angles, radii: (HEAD_STATION_COUNT,) polar outline of the head about (HEAD_POLAR_ORIGIN_SHARE
    head_bl, 0), angle 0 at the nose. along, half: (CORE_STATION_COUNT,) x <= 0 and half-width of
    the core. head_skin, core_skin: grey levels at the stations of both sides (2, stations).
    joint_bl: radius about the hinge in which no edge is searched. biased: stations (both parts and
    sides) whose edge is not the outline, for example beside an eye.
    """

    head_bl: float
    core_bl: float
    com_bl: float
    tail_bl: float
    angles: Float
    radii: Float
    along: Float
    half: Float
    head_skin: Float
    core_skin: Float
    joint_bl: float
    biased: npt.NDArray[np.bool_]

    @cached_property
    def core_grey_level(self) -> float:
        """The core's usual grey level."""
        return float(np.median(self.core_skin))

    @property
    def area_bl2(self) -> float:
        """Area of head and core, roughly."""
        return 1.4 * float(self.half.max()) * (self.head_bl + self.core_bl)

    def outline_arrays(self) -> OutlineArrays:
        """Points (n, 2), outward normals (n, 2), part (n,), skin (n,): both sides of both parts."""
        head, core = self._head_half_outline(), self._core_half_outline()
        mirror = np.array([1.0, -1.0])
        points = np.concatenate([head, head * mirror, core, core * mirror])
        sides = (_unit_normals(head), _unit_normals(core))
        normals = np.concatenate([side for n in sides for side in (n, n * mirror)])
        part = np.repeat([HEAD_PART, CORE_PART], [2 * len(head), 2 * len(core)])
        skin = np.concatenate([self.head_skin.ravel(), self.core_skin.ravel()])
        visible = self.visible_stations()
        return points[visible], normals[visible], part[visible], skin[visible]

    def visible_stations(self) -> npt.NDArray[np.bool_]:
        """Which of the stations (head, head mirrored, core, core mirrored) are searched for."""
        head = np.hypot(*self._head_half_outline().T) > self.joint_bl
        core = np.hypot(*self._core_half_outline().T) > self.joint_bl
        core[-1] = False
        nose_once = head.copy()
        nose_once[0] = False
        return np.concatenate([head, nose_once, core, core]) & ~self.biased

    def turned_points_and_normals(self, head_angle_rad: float) -> tuple[Float, Float]:
        """Points and normals (n, 2) of `shape`, head turned: hinge at 0, core along x."""
        points, normals, part, _ = self.outline_arrays()
        c, s = np.cos(-head_angle_rad), np.sin(-head_angle_rad)
        turn, head = np.array([[c, -s], [s, c]]).T, (part == HEAD_PART)[:, None]
        return np.where(head, points @ turn, points), np.where(head, normals @ turn, normals)

    def closed_outline(self, head_angle_rad: float) -> Float:
        """Closed outline (n, 2) of head and core, hinge at 0, core along x: for comparing blobs."""
        c, s = np.cos(-head_angle_rad), np.sin(-head_angle_rad)
        turn = np.array([[c, -s], [s, c]])
        mirror = np.array([1.0, -1.0])
        head, core = self._head_half_outline(), self._core_half_outline()
        front = np.concatenate([(head * mirror)[::-1], head]) @ turn.T
        rear = np.concatenate([core, (core * mirror)[::-1]])
        return np.concatenate([front, rear])

    def _head_half_outline(self) -> Float:
        middle = HEAD_POLAR_ORIGIN_SHARE * self.head_bl
        return np.column_stack(
            [middle + self.radii * np.cos(self.angles), self.radii * np.sin(self.angles)]
        )

    def _core_half_outline(self) -> Float:
        return np.column_stack([self.along, self.half])


def _unit_normals(line: Float) -> Float:
    """Unit normals (n, 2) of a line that runs from the nose back along the left side."""
    step = np.gradient(line, axis=0)
    normal = np.column_stack([step[:, 1], -step[:, 0]])
    if line[0, 1] == 0.0:
        normal[0] = (1.0, 0.0)
    size = np.maximum(np.hypot(*normal.T), 1e-12)
    return normal / size[:, None]


def robot_length_bl(robot: Robot, trial: Trial) -> float:
    """Nose to caudal base with the trial's head, in body lengths."""
    return metres_to_body_lengths(
        robot, robot.body_length_m + trial.head_length_m - robot.head_length_m
    )


def initial_template(
    robot: Robot, trial: Trial, half_width_bl: float, skin: float
) -> OutlineTemplate:
    """Template of the robot's lengths and one half-width: an egg and a taper, to begin with."""
    head_bl = metres_to_body_lengths(robot, trial.head_length_m)
    core_bl = robot_length_bl(robot, trial) - head_bl
    angles = np.linspace(0.0, 0.80 * np.pi, HEAD_STATION_COUNT)
    share = np.linspace(0.0, 1.0 - UNSAMPLED_CORE_END_SHARE, CORE_STATION_COUNT)
    end = 0.25 * half_width_bl
    return OutlineTemplate(
        head_bl=head_bl,
        core_bl=core_bl,
        com_bl=metres_to_body_lengths(robot, robot.hinge_to_com_m),
        tail_bl=metres_to_body_lengths(robot, robot.tail_length_m),
        angles=angles,
        radii=_blunt_head_radii(angles, head_bl, half_width_bl),
        along=-share * core_bl,
        half=end + (half_width_bl - end) * (1 - share**1.7),
        head_skin=np.full((2, HEAD_STATION_COUNT), skin),
        core_skin=np.full((2, CORE_STATION_COUNT), skin),
        joint_bl=1.22 * half_width_bl,
        biased=np.zeros(2 * (HEAD_STATION_COUNT + CORE_STATION_COUNT), bool),
    )


def _blunt_head_radii(angles: Float, head_bl: float, half_bl: float) -> Float:
    """Radii of a blunt head: |y / w|^2.1 + |x / front|^2.1 = 1 in front, straight sides behind."""
    front = (1 - HEAD_POLAR_ORIGIN_SHARE) * head_bl
    c, s = np.cos(angles), np.sin(angles)
    ahead = (np.abs(s / half_bl) ** 2.1 + np.abs(np.maximum(c, 0) / front) ** 2.1) ** (-1 / 2.1)
    return np.where(c > 0, ahead, half_bl / np.maximum(s, 0.3))


def with_learned_outline(
    template: OutlineTemplate, offsets_bl: Float, skins: Float, blur_bl: float = 0.0
) -> OutlineTemplate:
    """Template whose stations moved by the median offset seen over frames and both sides.

    offsets_bl: (frames, stations of both parts and sides), NaN where not seen. skins: grey levels,
    the same shape. blur_bl: of the pictures, rms. The nose stays at the head's length, less what
    blur takes of it: what the whole head moved along its axis is taken back.
    """
    h, c = HEAD_STATION_COUNT, CORE_STATION_COUNT
    parts = (offsets_bl[:, :h], offsets_bl[:, h : 2 * h], offsets_bl[:, 2 * h : 2 * h + c])
    core_right = offsets_bl[:, 2 * h + c :]
    head = _binomial_smoothed(_median_over_sides(parts[0], parts[1]))
    core = _binomial_smoothed(_median_over_sides(parts[2], core_right))
    radial = np.sum(
        _unit_normals(template._head_half_outline()) * _radial_directions(template), axis=1
    )
    radii = template.radii + head / np.clip(radial, 0.5, 1.0)
    lateral = np.abs(_unit_normals(template._core_half_outline())[:, 1])
    half = np.maximum(template.half + core / np.clip(lateral, 0.5, 1.0), 0.0015)
    sides = np.split(nan_median(skins), [h, 2 * h, 2 * h + c])
    return replace(
        template,
        radii=_move_nose_to_head_length(template, radii, blur_bl),
        half=half,
        head_skin=_finite_or_previous(np.stack(sides[:2]), template.head_skin),
        core_skin=_finite_or_previous(np.stack(sides[2:]), template.core_skin),
    )


def station_contrast(greys: Float, floor: float) -> Float:
    """How much each station's grey level, usual over frames and both sides, differs from a floor's.

    greys: (frames, stations of both parts and sides). Neighbours are taken together, so that
    noise in a few frames is no difference.
    """
    h, c = HEAD_STATION_COUNT, CORE_STATION_COUNT
    head_left, head_right, core_left, core_right = np.split(greys, [h, 2 * h, 2 * h + c], axis=1)
    head = np.abs(_binomial_smoothed(_median_over_sides(head_left - floor, head_right - floor)))
    core = np.abs(_binomial_smoothed(_median_over_sides(core_left - floor, core_right - floor)))
    return np.concatenate([head, head, core, core])


def nan_median(values: Float) -> Float:
    """Median along the first axis of what is no NaN; NaN where nothing else is.

    What numpy's nanmedian gives, without its masked arrays, which take several times as long.
    """
    count = np.sum(~np.isnan(values), axis=0)
    places = np.maximum(np.stack([(count - 1) // 2, count // 2]), 0)
    return np.take_along_axis(np.sort(values, axis=0), places, axis=0).mean(axis=0)


def _finite_or_previous(found: Float, before: Float) -> Float:
    return np.where(np.isfinite(found), found, before)


def _radial_directions(template: OutlineTemplate) -> Float:
    return np.column_stack([np.cos(template.angles), np.sin(template.angles)])


def _median_over_sides(left: Float, right: Float) -> Float:
    """Median over frames and both sides, 0 where nothing was seen, ends carried on."""
    pair = np.concatenate([left, right])
    seen = np.isfinite(pair).sum(axis=0) >= 2
    if not seen.any():
        return np.zeros(pair.shape[1])
    where = np.arange(pair.shape[1])
    return np.interp(where, where[seen], nan_median(pair[:, seen]))


def _binomial_smoothed(values: Float) -> Float:
    padded = np.concatenate([[2 * values[0] - values[1]], values, [2 * values[-1] - values[-2]]])
    return 0.25 * padded[:-2] + 0.5 * padded[1:-1] + 0.25 * padded[2:]


def _move_nose_to_head_length(template: OutlineTemplate, radii: Float, blur_bl: float) -> Float:
    """Radii of the same outline moved along the axis so that the nose is seen where it should be.

    That is at the head's length, less what blur takes of the nose.
    """
    nose = template.head_bl - nose_edge_shift_by_blur(template.angles, radii, blur_bl)
    shift = nose - template.head_bl * HEAD_POLAR_ORIGIN_SHARE - radii[0]
    x = radii * np.cos(template.angles) + shift
    y = radii * np.sin(template.angles)
    angles = np.unwrap(np.arctan2(y, x))
    return np.interp(template.angles, angles, np.hypot(x, y))


def nose_edge_shift_by_blur(angles: Float, radii: Float, blur_bl: float) -> float:
    """Distance by which blur (rms) displaces the edge of the nose backwards.

    Lateral blur averages the outline x(y) over y. Near the nose the outline is a power law through
    the next two stations, between a corner (p = 1) and a parabola (p = 2): x = -a |y|^p. Its mean
    over normally distributed y is -a blur^p E|z|^p, with z standard normal.
    """
    lateral = radii[1:3] * np.sin(angles[1:3])
    axial = np.maximum(radii[0] - radii[1:3] * np.cos(angles[1:3]), 1e-9)
    p = float(np.clip(np.log(axial[1] / axial[0]) / np.log(lateral[1] / lateral[0]), 1.0, 2.0))
    moment = 2 ** (p / 2) * math.gamma((p + 1) / 2) / math.sqrt(math.pi)
    return float(axial[0] * moment * (blur_bl / lateral[0]) ** p)

"""The robot's shape: keypoints and outlines in the pool frame, from its pose.

Shapes are closed polygons of complex numbers (x + i y, metres) in the pool plane.
Proportions: paper, Fig. 2B (39.7 cm long with the tail); widths seen from above are ours.
"""

from dataclasses import dataclass

import numpy as np

from bluekoi.synthetic.ground_truth_physics import Robot

KEYPOINTS = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")

HALF_WIDTH_M = 0.034
PEDUNCLE_SHARE_OF_TAIL = 0.4
PEDUNCLE_SWING_RAD = 0.38
FIN_SWING_RAD = 0.60
FIN_LAG_RAD = 0.7

Colour = tuple[float, float, float]

SKIN_RGB: Colour = (47.0, 62.0, 84.0)
BACK_RGB: Colour = (66.0, 86.0, 112.0)
HIGHLIGHT_RGB: Colour = (92.0, 114.0, 140.0)
JOINT_RGB: Colour = (30.0, 38.0, 50.0)
EYE_RGB: Colour = (205.0, 208.0, 200.0)
FIN_RGB: Colour = (38.0, 46.0, 58.0)
MARKER_RGB: dict[str, Colour] = {
    "head_tip": (225.0, 40.0, 35.0),
    "hinge": (240.0, 205.0, 30.0),
    "core_center": (40.0, 190.0, 60.0),
    "tail_base": (215.0, 50.0, 200.0),
    "tail_tip": (250.0, 130.0, 20.0),
}
MARKER_RADIUS_M = 0.008


@dataclass(frozen=True)
class DrawnShape:
    """One flat shape: outline `(n,)` complex metres, its colour (R, G, B 0 to 255), its opacity."""

    outline: np.ndarray
    colour: Colour
    opacity: float = 1.0


def tail_base_arm(robot: Robot) -> float:
    """Distance (m) from the centre of mass back to the caudal base: `B - h1 - d`."""
    return robot.body_length_m - robot.head_length_m - robot.hinge_to_com_m


def tail_angles(beat: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angles (rad) of peduncle and fin against the core at a phase of the beat (rad)."""
    return PEDUNCLE_SWING_RAD * np.sin(beat), FIN_SWING_RAD * np.sin(beat - FIN_LAG_RAD)


def body_point_positions(robot: Robot, head_length_m: float, pose: np.ndarray) -> np.ndarray:
    """Keypoints `(times, 5)` as x + i y (m), in the order of `KEYPOINTS`, of poses `(times, 5)`."""
    com = pose[:, 0] + 1j * pose[:, 1]
    core = np.exp(1j * pose[:, 2])
    head = np.exp(1j * (pose[:, 2] - pose[:, 3]))
    hinge = com + robot.hinge_to_com_m * core
    tip = hinge + head_length_m * head
    base = com - tail_base_arm(robot) * core
    first, second = tail_angles(pose[:, 4])
    root = PEDUNCLE_SHARE_OF_TAIL * robot.tail_length_m * np.exp(1j * first)
    blade = (1 - PEDUNCLE_SHARE_OF_TAIL) * robot.tail_length_m * np.exp(1j * second)
    return np.stack([tip, hinge, com, base, base - core * (root + blade)], axis=1)


def _mirrored_outline(along: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Closed outline of a shape that is symmetric about the real axis."""
    return np.concatenate([along + 1j * half, (along - 1j * half)[::-1]])


def head_outline(head_length_m: float, inset_m: float = 0.0) -> np.ndarray:
    """Head in its own axes, hinge at 0, tip at +length: bulged, with a rounded nose."""
    s = np.sin(np.linspace(0, np.pi / 2, 26))
    front = np.clip((s - 0.3) / 0.7, 0, 1)
    rear = np.clip((0.3 - s) / 0.3, 0, 1)
    half = HALF_WIDTH_M * (1 - front**2) ** 0.62 * (1 - 0.07 * rear**2)
    scale = (head_length_m - 1.6 * inset_m) / head_length_m
    return _mirrored_outline(s * head_length_m * scale, np.maximum(half - inset_m, 0.0))


def core_outline(robot: Robot, inset_m: float = 0.0) -> np.ndarray:
    """Core in its own axes, hinge at 0, caudal base at the negative end: long taper."""
    s = np.linspace(0, 1, 24)
    half = 0.0075 + (HALF_WIDTH_M - 0.0075) * (1 - s**1.9) ** 1.15 * (1 - 0.05 * (1 - s) ** 6)
    length = tail_base_arm(robot) + robot.hinge_to_com_m
    return _mirrored_outline(-s * length, np.maximum(half - inset_m, 0.0))


def circle_outline(radius_m: float, count: int = 20) -> np.ndarray:
    """Circle of a radius (m) about 0."""
    return radius_m * np.exp(2j * np.pi * np.arange(count) / count)


def _tail_shapes_to_draw(
    robot: Robot, base: complex, core: complex, beat: float
) -> list[DrawnShape]:
    first, second = (complex(np.exp(1j * a)) for a in tail_angles(np.array(beat)))
    root_m = PEDUNCLE_SHARE_OF_TAIL * robot.tail_length_m
    blade_m = (1 - PEDUNCLE_SHARE_OF_TAIL) * robot.tail_length_m
    s = np.linspace(0, 1, 9)
    root = _mirrored_outline(-s * root_m, 0.0075 - 0.0025 * s)
    blade = _mirrored_outline(-s * blade_m, 0.0012 + 0.0048 * (1 - s) ** 0.8 * (0.55 + s))
    end = base - core * first * root_m
    return [
        DrawnShape(end + core * second * blade, FIN_RGB),
        DrawnShape(end + circle_outline(0.0052, 12), FIN_RGB),
        DrawnShape(base + circle_outline(0.0076, 12), FIN_RGB),
        DrawnShape(base + core * first * root, FIN_RGB),
    ]


def _eyes(hinge: complex, head: complex, head_length_m: float) -> list[DrawnShape]:
    places = [hinge + head * (0.72 * head_length_m + side * 0.0165j) for side in (1, -1)]
    return [DrawnShape(p + circle_outline(0.0042, 12), EYE_RGB) for p in places] + [
        DrawnShape(p + circle_outline(0.0022, 12), JOINT_RGB) for p in places
    ]


def _shaded_parts(outlines: list[np.ndarray], place: complex, axis: complex) -> list[DrawnShape]:
    colours = (SKIN_RGB, BACK_RGB, HIGHLIGHT_RGB)
    opacities = (1.0, 0.8, 0.45)
    return [
        DrawnShape(place + axis * outline, colour, opacity)
        for outline, colour, opacity in zip(outlines, colours, opacities, strict=True)
    ]


def robot_shapes_to_draw(
    robot: Robot, head_length_m: float, pose: np.ndarray, *, markers: bool = False
) -> list[DrawnShape]:
    """Everything to draw of the robot in one pose `(5,)`, bottom first."""
    points = body_point_positions(robot, head_length_m, pose[None])[0]
    core = complex(np.exp(1j * pose[2]))
    head = complex(np.exp(1j * (pose[2] - pose[3])))
    hinge, base = complex(points[1]), complex(points[3])
    insets = (0.0, 0.010, 0.022)
    parts = _tail_shapes_to_draw(robot, base, core, float(pose[4]))
    parts += _shaded_parts([core_outline(robot, inset) for inset in insets], hinge, core)
    parts += [
        DrawnShape(hinge + circle_outline(0.0315), SKIN_RGB),
        DrawnShape(hinge + circle_outline(0.020), JOINT_RGB, 0.55),
    ]
    parts += _shaded_parts([head_outline(head_length_m, inset) for inset in insets], hinge, head)
    parts += [DrawnShape(hinge + circle_outline(0.006), JOINT_RGB)]
    parts += _eyes(hinge, head, head_length_m)
    if markers:
        dot = circle_outline(MARKER_RADIUS_M)
        parts += [
            DrawnShape(point + dot, MARKER_RGB[name])
            for name, point in zip(KEYPOINTS, points, strict=True)
        ]
    return parts

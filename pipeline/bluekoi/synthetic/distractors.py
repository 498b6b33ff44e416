"""Distractors in the picture: a bar across the pool, a reaching hand, another body."""

import math

import numpy as np

from bluekoi.synthetic.body import DrawnShape, circle_outline

BAR_HEIGHT_ABOVE_WATER_M = 0.30
HAND_HEIGHT_ABOVE_WATER_M = 0.06
SECOND_BODY_HEIGHT_ABOVE_WATER_M = -0.02
"""ASSUME a bar on the rim of the pool, a hand just above the water, a body 2 cm below its surface.
"""
HAND_RGB = (214.0, 168.0, 142.0)
SLEEVE_RGB = (62.0, 70.0, 92.0)
SECOND_HAND_ENTRY_S = (1.4, 2.6)


def _rectangle_outline(x0: float, x1: float, y0: float, y1: float) -> np.ndarray:
    return np.array([x0 + 1j * y0, x1 + 1j * y0, x1 + 1j * y1, x0 + 1j * y1])


def crossbar(pool_m: tuple[float, float]) -> list[DrawnShape]:
    """A lamp rail across the pool's middle, above the water."""
    x, width = 0.5 * pool_m[0], pool_m[1]
    return [
        DrawnShape(
            _rectangle_outline(x - 0.02, x + 0.02, -0.6, width + 0.6), (150.0, 152.0, 155.0)
        ),
        DrawnShape(
            _rectangle_outline(x - 0.006, x + 0.002, -0.6, width + 0.6), (205.0, 207.0, 210.0)
        ),
    ]


def _rounded_rod(begin: complex, end: complex, half_m: float) -> np.ndarray:
    """A rod with round ends from one point to another."""
    axis = (end - begin) / max(abs(end - begin), 1e-9)
    arc = np.exp(1j * np.linspace(-math.pi / 2, math.pi / 2, 9)) * half_m * axis
    return np.concatenate([end + arc, begin - arc])


def _hand_outlines(wrist: complex, toward: complex) -> list[DrawnShape]:
    """Forearm, palm, four fingers and thumb of a hand that points along `toward`."""
    palm = wrist + 0.06 * toward
    parts = [
        DrawnShape(_rounded_rod(wrist - 0.9 * toward, wrist - 0.16 * toward, 0.048), SLEEVE_RGB),
        DrawnShape(_rounded_rod(wrist - 0.20 * toward, wrist, 0.030), HAND_RGB),
        DrawnShape(
            palm + toward * (circle_outline(0.048).real + 0.9j * circle_outline(0.048).imag),
            HAND_RGB,
        ),
    ]
    for k, length in enumerate((0.065, 0.078, 0.074, 0.055)):
        root = palm + toward * (0.035 + 1j * (0.030 - 0.020 * k))
        spread = toward * np.exp(1j * (0.14 - 0.09 * k))
        parts.append(DrawnShape(_rounded_rod(root, root + length * spread, 0.0085), HAND_RGB))
    root = palm + toward * (-0.01 + 0.040j)
    return [
        *parts,
        DrawnShape(_rounded_rod(root, root + 0.05 * toward * np.exp(0.8j), 0.0095), HAND_RGB),
    ]


def _smoothstep(x: float) -> float:
    x = min(max(x, 0.0), 1.0)
    return x * x * (3 - 2 * x)


def hand_parts_at_time(
    time_s: float, released_at: complex, pool_m: tuple[float, float]
) -> list[DrawnShape]:
    """The hand that lets the robot go at its start, draws back, and later reaches in elsewhere."""
    first = 1 - _smoothstep((time_s - 0.12) / 0.8)
    middle = 0.5 * sum(SECOND_HAND_ENTRY_S)
    half = 0.5 * (SECOND_HAND_ENTRY_S[1] - SECOND_HAND_ENTRY_S[0])
    second = _smoothstep(1.6 * (1 - abs(time_s - middle) / half))
    near_top = released_at.imag > 0.5 * pool_m[1]
    wall = pool_m[1] + 0.25 if near_top else -0.25
    toward = -1j if near_top else 1j
    parts: list[DrawnShape] = []
    if first > 0:
        target = released_at.imag - toward.imag * 0.13
        parts += _hand_outlines(complex(released_at.real, wall + first * (target - wall)), toward)
    if second > 0:
        place = complex((released_at.real + 0.5 * pool_m[0]) % pool_m[0], wall)
        parts += _hand_outlines(place + toward * second * 0.75, toward)
    return parts


def toy_fish_shapes(time_s: float, pool_m: tuple[float, float]) -> list[DrawnShape]:
    """A dark toy fish, half the robot's size, that wanders about the pool at about 0.15 m/s."""
    length, width = pool_m
    angle = 0.28 * time_s + 0.6
    place = complex(
        length * (0.5 + 0.34 * math.cos(angle)), width * (0.5 + 0.30 * math.sin(2 * angle))
    )
    ahead = complex(-0.34 * length * math.sin(angle), 0.60 * width * math.cos(2 * angle))
    axis = ahead / abs(ahead)
    s = np.linspace(0, 1, 18)
    half = 0.026 * np.sqrt(np.clip(4 * s * (1 - s), 0, 1)) * (1.15 - 0.6 * s)
    along = 0.09 - 0.17 * s
    body = np.concatenate([along + 1j * half, (along - 1j * half)[::-1]])
    wag = np.exp(0.5j * math.sin(9.0 * time_s))
    tail = np.array([0.005, -0.05 + 0.02j, -0.05 - 0.02j]) * wag - 0.075
    return [
        DrawnShape(place + axis * tail, (70.0, 52.0, 44.0)),
        DrawnShape(place + axis * body, (88.0, 64.0, 52.0)),
    ]

"""Forces that no listed cause describes."""

from __future__ import annotations

from typing import Any

import numpy as np

from .registry import unlisted


@unlisted(
    "elastic_leash",
    ["surge", "sway"],
    "position",
    "force",
    start=0.1,
    cap=2.0,
    ax=(0.0, 1.0),
    ay=[0.0, 1.0],
    slack=(0.2, 0.4),
)
def _(w: Any, p: dict[str, float]) -> None:
    """A leash to a point of the rim pulls in proportion to its stretch beyond a slack length."""
    pool = w.world.pool
    gap = (p["ax"] * pool.length + 1j * p["ay"] * pool.width) - (w.x + 1j * w.y)
    far = np.abs(gap) + 1e-9
    stretch = np.maximum(far / pool.length - p["slack"], 0)
    w.force = w.force + p["amp"] * w.sc.drag * stretch * gap / far


@unlisted("compass_torque", ["yaw"], "heading", "force", start=0.05, cap=1.0, pole=(0.0, 6.28))
def _(w: Any, p: dict[str, float]) -> None:
    """Motor magnets align with iron in the floor: a torque as the sine of the heading."""
    w.moment = w.moment - p["amp"] * w.sc.moment * np.sin(w.theta - p["pole"])


@unlisted(
    "rising_bubbles",
    ["surge", "sway"],
    "position",
    "force",
    start=0.2,
    cap=4.0,
    bx=(0.35, 0.65),
    by=(0.35, 0.65),
    width=(0.5, 1.0),
)
def _(w: Any, p: dict[str, float]) -> None:
    """A bubble plume parts the surface and pushes a body away from its axis, fast or slow."""
    pool = w.world.pool
    z = (w.x - p["bx"] * pool.length) + 1j * (w.y - p["by"] * pool.width)
    z = z / (p["width"] * w.sc.length)
    w.force = w.force + p["amp"] * w.sc.drag * z * np.exp(-0.5 * np.abs(z) ** 2)


@unlisted(
    "shedding_lock_in",
    ["sway", "yaw"],
    "time and speed",
    "force",
    start=0.3,
    cap=6.0,
    period=(1.5, 3.0),
    phase=(0.0, 6.28),
    arm=(-0.3, 0.3),
)
def _(w: Any, p: dict[str, float]) -> None:
    """Slow alternating side force of large shed eddies, in step with the start of the trial."""
    beat = np.sin(2 * np.pi * w.t / (p["period"] * w.sc.time) + p["phase"])
    w.side_at(p["amp"] * w.sc.drag * (w.speed / w.sc.speed) ** 2 * beat, p["arm"] * w.sc.length)


@unlisted(
    "heel_in_turns",
    ["sway", "yaw"],
    "centripetal acceleration",
    "force",
    start=0.2,
    cap=3.0,
    knee=(0.3, 0.8),
    arm=(-0.3, 0.3),
    sign=[-1, 1],
)
def _(w: Any, p: dict[str, float]) -> None:
    """The body heels in turns; beyond a threshold of speed times yaw rate a side force sets in."""
    load = w.speed * w.r / (w.sc.speed * w.sc.rate)
    over = np.sign(load) * np.maximum(np.abs(load) - p["knee"], 0)
    w.side_at(p["sign"] * p["amp"] * w.sc.drag * over, p["arm"] * w.sc.length)


@unlisted(
    "tilted_floor_light",
    ["surge"],
    "heading and power",
    "force",
    start=0.1,
    cap=1.0,
    slope=(0.0, 6.28),
    power=(1.0, 2.0),
)
def _(w: Any, p: dict[str, float]) -> None:
    """Nose-up pitch against surface ripples of one direction: resistance by heading and power."""
    face = np.cos(w.theta - p["slope"])
    push = p["amp"] * w.sc.drag * face * np.abs(face) * (w.k.power / 70.0) ** p["power"]
    gate = np.tanh(w.speed / (0.1 * w.sc.speed))
    w.force = w.force - push * gate * w.core

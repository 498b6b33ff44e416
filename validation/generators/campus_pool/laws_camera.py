"""Laws of the camera: scale, lens, refraction, and a camera that moves.

`o.stated` is the optical description given to the reader of the study; `o.true` is the truth.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .registry import form


@form("scale_error", "both_lengths", "optics", 0.01, 0.12, sign=[-1, 1])
def _(o: Any, p: dict[str, float]) -> None:
    """Both pool lengths are wrong by one factor."""
    g = 1 + p["sign"] * p["amp"]
    o.stated.length, o.stated.width = o.stated.length * g, o.stated.width * g


@form("scale_error", "one_length", "optics", 0.01, 0.12, sign=[-1, 1], side=[0, 1])
def _(o: Any, p: dict[str, float]) -> None:
    """One side of the pool is measured wrong, the other by a third of that."""
    g, h = 1 + p["sign"] * p["amp"], 1 + p["sign"] * p["amp"] / 3
    o.stated.length *= g if p["side"] else h
    o.stated.width *= h if p["side"] else g


@form("scale_error", "inner_rim", "optics", 0.01, 0.08, sign=[-1, 1])
def _(o: Any, p: dict[str, float]) -> None:
    """The corners were clicked on another rim than the one that was measured."""
    o.stated.inset += p["sign"] * p["amp"] * 0.5 * o.stated.length


@form("scale_error", "skewed_tape", "optics", 0.01, 0.12, sign=[-1, 1])
def _(o: Any, p: dict[str, float]) -> None:
    """Lengths with a factor, and corner marks higher by the like share of the camera height."""
    g = 1 + p["sign"] * p["amp"]
    o.stated.length, o.stated.width = o.stated.length * g, o.stated.width * g
    o.stated.mark_height += 0.2 * p["amp"] * o.true.camera.position[2]


@form("lens_error", "radial_omitted", "optics", 0.2, 1.5, sign=[-1, 1])
def _(o: Any, p: dict[str, float]) -> None:
    """First radial term wrong by a share of itself, or of a usual lens."""
    c = o.stated.camera
    c.distortion[0] += p["sign"] * p["amp"] * max(abs(c.distortion[0]), 0.03)


@form("lens_error", "other_zoom", "optics", 0.02, 0.2, sign=[-1, 1])
def _(o: Any, p: dict[str, float]) -> None:
    """Calibrated at another focus: focal lengths wrong by a factor."""
    o.stated.camera.focal = o.stated.camera.focal * (1 + p["sign"] * p["amp"])


@form("lens_error", "decentred", "optics", 0.02, 0.2, towards=(0.0, 6.28))
def _(o: Any, p: dict[str, float]) -> None:
    """Principal point wrong, by a share of the image width."""
    c = o.stated.camera
    c.centre = c.centre + p["amp"] * c.size[0] * np.array(
        [np.cos(p["towards"]), np.sin(p["towards"])]
    )


@form("lens_error", "higher_order", "optics", 0.2, 1.0, sign=[-1, 1])
def _(o: Any, p: dict[str, float]) -> None:
    """A second radial term is missing from the statement, partly offset by the first."""
    c = o.stated.camera
    scale = c.corner_radius**2
    c.distortion[1] += p["sign"] * p["amp"] * 0.08 / scale**2
    c.distortion[0] -= p["sign"] * p["amp"] * 0.05 / scale


@form("uncorrected_refraction", "index_of_air", "optics", 0.5, 1.0)
def _(o: Any, p: dict[str, float]) -> None:
    """The stated index lies between that of the water and that of air."""
    o.stated.index = o.stated.index - p["amp"] * (o.stated.index - 1.0)


@form("uncorrected_refraction", "shallow_statement", "optics", 0.5, 3.0)
def _(o: Any, p: dict[str, float]) -> None:
    """The keypoints lie deeper than stated by a share of the body height."""
    o.depth = o.depth + p["amp"] * o.span


@form("uncorrected_refraction", "deeper_at_power", "optics", 0.5, 3.0)
def _(o: Any, p: dict[str, float]) -> None:
    """The robot runs deeper than stated, the more the higher the power."""
    o.depth = o.depth + p["amp"] * o.span * (o.k.power / 70.0) ** 2


@form("uncorrected_refraction", "rising_level", "optics", 0.5, 3.0)
def _(o: Any, p: dict[str, float]) -> None:
    """A pool that fills over the session: more water above the keypoints than stated."""
    o.depth = o.depth + p["amp"] * o.span * (0.4 + o.k.order)


@form(
    "camera_shift",
    "knocked",
    "optics",
    0.004,
    0.06,
    when=(0.3, 0.6),
    axis=(0.0, 6.28),
    roll=(-0.5, 0.5),
)
def _(o: Any, p: dict[str, float]) -> None:
    """The camera turns a little at one moment of the session."""
    _turn(o, p, p["amp"] * (o.k.order > p["when"]))


@form("camera_shift", "sagging_arm", "optics", 0.006, 0.08, axis=(0.0, 6.28), roll=(-0.4, 0.4))
def _(o: Any, p: dict[str, float]) -> None:
    """The arm sags steadily over the session."""
    _turn(o, p, p["amp"] * o.k.order)


@form(
    "camera_shift",
    "slipping_in_trial",
    "optics",
    0.005,
    0.06,
    axis=(0.0, 6.28),
    roll=(-0.4, 0.4),
    tau=(0.2, 0.6),
)
def _(o: Any, p: dict[str, float]) -> None:
    """The mount creeps during each recording and is put back before the next."""
    _turn(o, p, p["amp"] * (1 - np.exp(-o.t / (p["tau"] * o.duration))))


@form("camera_shift", "lifted", "optics", 0.01, 0.12, when=(0.2, 0.5), across=(-0.5, 0.5))
def _(o: Any, p: dict[str, float]) -> None:
    """The camera is mounted higher and displaced sideways after one moment of the session."""
    size = p["amp"] * o.true.camera.position[2] * (o.k.order > p["when"]) * (1 + 0 * o.t)
    o.move = np.stack([p["across"] * size, 0 * size, size], axis=-1)


def _turn(o: Any, p: dict[str, float], size: Any) -> None:
    """Small rotation about an axis of the image plane with some roll."""
    size = size * (1 + 0 * o.t)
    o.turn = np.stack(
        [size * np.cos(p["axis"]), size * np.sin(p["axis"]), size * p["roll"]], axis=-1
    )

"""Laws of water and place: currents, gyres, walls, own wake, sinking."""

from __future__ import annotations

from typing import Any

import numpy as np

from .registry import form

TAU = 2 * np.pi


@form("uniform_current", "steady", "water", 0.03, 0.3, towards=(0.0, TAU))
def _(w: Any, p: dict[str, float]) -> None:
    """The same drift everywhere and always."""
    w.water = w.water + p["amp"] * w.sc.speed * np.exp(1j * p["towards"])


@form("uniform_current", "dying_out", "water", 0.05, 0.4, towards=(0.0, TAU), decay=(0.3, 1.0))
def _(w: Any, p: dict[str, float]) -> None:
    """Drift left by filling, dying out over the session."""
    w.water = w.water + (
        p["amp"] * w.sc.speed * np.exp(1j * p["towards"]) * np.exp(-w.k.order / p["decay"])
    )


@form("uniform_current", "pump_switched", "water", 0.05, 0.4, towards=(0.0, TAU), when=(0.3, 0.6))
def _(w: Any, p: dict[str, float]) -> None:
    """A pump is switched on during the session."""
    on = 1.0 * (w.k.order > p["when"])
    w.water = w.water + p["amp"] * w.sc.speed * np.exp(1j * p["towards"]) * on


@form(
    "uniform_current",
    "seiche",
    "water",
    0.05,
    0.4,
    towards=(0.0, TAU),
    period=(2.0, 6.0),
    bias=(0.3, 0.8),
)
def _(w: Any, p: dict[str, float]) -> None:
    """A drift with a slow surge that starts alike in each trial."""
    swing = p["bias"] + (1 - p["bias"]) * np.cos(TAU * w.t / (p["period"] * 4 * w.sc.time))
    w.water = w.water + p["amp"] * w.sc.speed * np.exp(1j * p["towards"]) * swing


def _place(w: Any) -> tuple[Any, Any]:
    """Position relative to the middle of the pool, in half lengths."""
    pool = w.world.pool
    return 2 * w.x / pool.length - 1, 2 * w.y / pool.width - 1


@form("pool_gyre", "solid_body", "water", 0.05, 0.4, sign=[-1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """Rigid rotation about the middle of the pool."""
    a, b = _place(w)
    ratio = w.world.pool.width / w.world.pool.length
    w.water = w.water + p["sign"] * p["amp"] * w.sc.speed * (-b * ratio + 1j * a)


@form(
    "pool_gyre",
    "viscous_vortex",
    "water",
    0.08,
    0.5,
    sign=[-1, 1],
    core=(0.2, 0.5),
    x0=(-0.3, 0.3),
    y0=(-0.3, 0.3),
)
def _(w: Any, p: dict[str, float]) -> None:
    """Lamb-Oseen vortex with a core, off the middle."""
    a, b = _place(w)
    z = (a - p["x0"]) + 1j * (b - p["y0"]) * w.world.pool.width / w.world.pool.length
    s2 = (np.abs(z) / p["core"]) ** 2 + 1e-9
    w.water = w.water + (
        p["sign"] * p["amp"] * w.sc.speed * 1.5 * 1j * z / p["core"] * (1 - np.exp(-s2)) / s2
    )


@form("pool_gyre", "closed_cell", "water", 0.06, 0.4, sign=[-1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """One cell that closes at the walls (product of cosines as stream function)."""
    a, b = _place(w)
    u = -np.cos(np.pi * a / 2) * np.sin(np.pi * b / 2)
    v = np.sin(np.pi * a / 2) * np.cos(np.pi * b / 2) * w.world.pool.width / w.world.pool.length
    w.water = w.water + p["sign"] * p["amp"] * w.sc.speed * (u + 1j * v)


@form("pool_gyre", "double_cell", "water", 0.06, 0.4, sign=[-1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """Two cells side by side that turn against each other."""
    a, b = _place(w)
    u = -np.sin(np.pi * a) * np.sin(np.pi * b / 2)
    v = -2 * np.cos(np.pi * a) * np.cos(np.pi * b / 2) * w.world.pool.width / w.world.pool.length
    w.water = w.water + p["sign"] * p["amp"] * w.sc.speed * (u + 1j * v)


def _walls(w: Any) -> list[tuple[Any, complex]]:
    """Distances to the four walls in body lengths, with the directions towards them."""
    pool, size = w.world.pool, w.sc.length
    return [
        (np.maximum(w.x, 0.05 * size) / size, -1.0 + 0j),
        (np.maximum(pool.length - w.x, 0.05 * size) / size, 1.0 + 0j),
        (np.maximum(w.y, 0.05 * size) / size, -1j),
        (np.maximum(pool.width - w.y, 0.05 * size) / size, 1j),
    ]


@form("wall_effect", "suction", "force", 0.2, 3.0, reach=(0.4, 1.0))
def _(w: Any, p: dict[str, float]) -> None:
    """Attraction to a near wall, dynamic pressure times an exponential of the distance."""
    q = w.sc.drag * (w.speed / w.sc.speed) ** 2
    for d, n in _walls(w):
        along = np.abs((np.conj(n) * w.vhat).imag)
        w.force = w.force + p["amp"] * q * along * np.exp(-d / p["reach"]) * n


@form("wall_effect", "mirror_image", "force", 0.1, 2.0)
def _(w: Any, p: dict[str, float]) -> None:
    """Potential-flow image: force with the inverse square of the distance."""
    q = w.sc.drag * (w.speed / w.sc.speed) ** 2
    for d, n in _walls(w):
        w.force = w.force + p["amp"] * q * 0.3 / (d + 0.2) ** 2 * n


@form("wall_effect", "blockage", "force", 0.3, 4.0, reach=(0.4, 1.0))
def _(w: Any, p: dict[str, float]) -> None:
    """Drag raised near a wall."""
    for d, _n in _walls(w):
        w.drag_along(p["amp"] * w.sc.drag * (w.speed / w.sc.speed) ** 2 * np.exp(-d / p["reach"]))


@form("wall_effect", "bank_cushion", "force", 0.2, 3.0, reach=(0.4, 1.0))
def _(w: Any, p: dict[str, float]) -> None:
    """Bow pushed away from a bank: yaw moment that falls with the distance."""
    s2 = (w.speed / w.sc.speed) ** 2
    for d, n in _walls(w):
        side = (np.conj(w.heading) * n).imag
        w.moment = w.moment - p["amp"] * w.sc.moment * s2 * side * np.exp(-((d / p["reach"]) ** 2))


def _wake(w: Any, width: float, decay: Any) -> tuple[Any, Any]:
    """Jet (complex) and intensity met from the robot's own former path."""
    if w.world.wake is None:
        return 0j * w.x, 0.0 * w.x
    times, places, ways = w.world.wake
    here = (w.x + 1j * w.y)[..., None]
    age = np.asarray(w.t + 0 * w.x)[..., None] - times
    gate = 0.5 * (1 + np.tanh((age - 2.0 * w.sc.time) / (0.3 * w.sc.time)))
    size = width * w.sc.length
    gap2 = np.abs(here - places[:, None, :]) ** 2 / size**2
    near = np.where(
        age > 0, gate * np.exp(-0.5 * gap2) * decay(np.maximum(age, 0.05) / w.sc.time), 0.0
    )
    step = (times[1] - times[0]) * np.abs(ways[:, None, :]) / size
    way = np.exp(1j * np.angle(ways[:, None, :]))
    return np.sum(near * step * way, -1), np.sum(near * step, -1)


@form("wake_reentry", "decaying_jet", "water", 0.15, 1.0, width=(0.2, 0.4), life=(5.0, 12.0))
def _(w: Any, p: dict[str, float]) -> None:
    """The tail jet of the former passage still flows backwards, fading exponentially."""
    jet, _s = _wake(w, p["width"], lambda a: np.exp(-a / p["life"]))
    w.water = w.water - p["amp"] * w.sc.speed * jet


@form("wake_reentry", "momentum_puff", "water", 0.3, 2.0, width=(0.25, 0.45))
def _(w: Any, p: dict[str, float]) -> None:
    """Vortex rings slow down as age to the power -3/4."""
    jet, _s = _wake(w, p["width"], lambda a: (a + 0.3) ** -0.75)
    w.water = w.water - p["amp"] * w.sc.speed * jet


@form("wake_reentry", "turbulent_drag", "force", 0.2, 2.0, width=(0.2, 0.4), life=(5.0, 12.0))
def _(w: Any, p: dict[str, float]) -> None:
    """Turbulence of the former passage raises the drag."""
    _jet, s = _wake(w, p["width"], lambda a: np.exp(-a / p["life"]))
    w.drag_along(p["amp"] * w.sc.drag * (w.speed / w.sc.speed) ** 2 * s)


@form("wake_reentry", "swirl_in_tail", "force", 0.2, 1.5, width=(0.2, 0.4), life=(5.0, 12.0))
def _(w: Any, p: dict[str, float]) -> None:
    """The tail works in swirling water and gives less thrust."""
    _jet, s = _wake(w, p["width"], lambda a: 1 / (1 + a / p["life"]) ** 2)
    w.thrust = w.thrust / (1 + p["amp"] * s)


@form("sinking", "steady_rate", "depth", 0.1, 1.5)
def _(o: Any, p: dict[str, float]) -> None:
    """Depth grows linearly during a trial."""
    o.depth = o.depth + p["amp"] * o.span * o.t / o.duration


@form("sinking", "settling", "depth", 0.1, 1.2, tau=(0.15, 0.4))
def _(o: Any, p: dict[str, float]) -> None:
    """Depth approaches a new level of buoyancy."""
    o.depth = o.depth + p["amp"] * o.span * (1 - np.exp(-o.t / (p["tau"] * o.duration)))


@form("sinking", "speed_dive", "depth", 0.1, 1.2)
def _(o: Any, p: dict[str, float]) -> None:
    """Pitched body: depth grows with the distance swum."""
    o.depth = o.depth + p["amp"] * o.span * o.travel / o.reach


@form("sinking", "heavy_when_slow", "depth", 0.1, 0.6, power=(1.0, 1.6))
def _(o: Any, p: dict[str, float]) -> None:
    """A heavy robot sinks the faster the weaker it swims, and from trial to trial more."""
    weak = (60.0 / o.k.power) ** p["power"]
    o.depth = o.depth + p["amp"] * o.span * (o.t / o.duration) ** 1.5 * weak * (0.5 + o.k.order)

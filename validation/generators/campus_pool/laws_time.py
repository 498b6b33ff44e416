"""Laws of clocks and labels: frame clock, time offset of the log, displaced keypoints."""

from __future__ import annotations

from typing import Any

import numpy as np

from .registry import form


@form("clock_error", "constant_factor", "clock", 0.01, 0.15, sign=[-1, 1])
def _(o: Any, p: dict[str, float]) -> None:
    """The frame rate is not the stated one."""
    o.delay = o.delay + p["sign"] * p["amp"] * o.t


@form("clock_error", "warming_up", "clock", 0.02, 0.2, sign=[-1, 1], tau=(0.2, 0.5))
def _(o: Any, p: dict[str, float]) -> None:
    """The rate is wrong at the start of each recording and settles."""
    tau = p["tau"] * o.duration
    o.delay = o.delay + p["sign"] * p["amp"] * tau * (1 - np.exp(-o.t / tau))


@form("clock_error", "dropped_frames", "clock", 0.02, 0.15, phase=(0.0, 1.0))
def _(o: Any, p: dict[str, float]) -> None:
    """Frames are lost in bursts every half second or so, and the count goes on."""
    beat = 0.5 + 0.3 * p["phase"]
    whole = np.floor((o.t + p["phase"] * beat) / beat)
    o.delay = o.delay + np.round(whole * p["amp"] * beat * o.fps) / o.fps


@form("clock_error", "second_session", "clock", 0.02, 0.2, sign=[-1, 1], when=(0.3, 0.6))
def _(o: Any, p: dict[str, float]) -> None:
    """The camera ran at another rate in the later part of the session."""
    o.delay = o.delay + p["sign"] * p["amp"] * o.t * (o.k.order > p["when"])


def _log_shift(w: Any, delay: Any) -> None:
    """The motor really does what the log says `delay` seconds later."""
    w.motor_time = w.motor_time - delay * w.sc.time


@form("time_offset", "constant", "command", 0.1, 1.0, sign=[-1, 1, 1])
def _(w: Any, p: dict[str, float]) -> None:
    """The log starts before or after the first frame by a fixed time."""
    _log_shift(w, p["sign"] * p["amp"])


@form("time_offset", "growing", "command", 0.15, 1.5, sign=[-1, 1], base=(0.1, 0.4))
def _(w: Any, p: dict[str, float]) -> None:
    """The offset grows over the session."""
    _log_shift(w, p["sign"] * p["amp"] * (p["base"] + (1 - p["base"]) * w.k.order))


@form("time_offset", "restarted", "command", 0.15, 1.5, sign=[-1, 1], when=(0.35, 0.65))
def _(w: Any, p: dict[str, float]) -> None:
    """The offset changes sign and size when the logger is restarted."""
    _log_shift(w, p["sign"] * p["amp"] * np.where(w.k.order > p["when"], 1.0, -0.35))


@form("time_offset", "bus_latency", "command", 0.1, 1.0, spread=(0.3, 0.7))
def _(w: Any, p: dict[str, float]) -> None:
    """Latency of one sign that varies from trial to trial."""
    _log_shift(w, p["amp"] * (1 - p["spread"] + p["spread"] * np.abs(w.k.z)))


@form("keypoint_bias", "core_along_axis", "label", 0.02, 0.15, sign=[-1, 1])
def _(o: Any, p: dict[str, float]) -> None:
    """The centre label sits ahead of or behind its place."""
    o.points[2] = o.points[2] + p["sign"] * p["amp"] * o.size * o.core


@form("keypoint_bias", "core_aside", "label", 0.01, 0.08, sign=[-1, 1])
def _(o: Any, p: dict[str, float]) -> None:
    """The centre label sits to one side."""
    o.points[2] = o.points[2] + 1j * p["sign"] * p["amp"] * o.size * o.core


@form("keypoint_bias", "hinge_hidden", "label", 0.02, 0.2)
def _(o: Any, p: dict[str, float]) -> None:
    """The bent skin hides the hinge, whose label slips inwards with the head angle."""
    o.points[1] = o.points[1] - 1j * o.core * p["amp"] * o.size * np.sin(o.phi)


@form("keypoint_bias", "shadow_side", "label", 0.01, 0.08, lamp=(0.0, 6.28))
def _(o: Any, p: dict[str, float]) -> None:
    """All labels but the tips slip towards the lit side of the body, in pool directions."""
    lit = np.exp(1j * p["lamp"])
    across = (np.conj(1j * o.core) * lit).real * 1j * o.core
    for i in (1, 2, 3):
        o.points[i] = o.points[i] + p["amp"] * o.size * across * (0.6 + 0.2 * i)

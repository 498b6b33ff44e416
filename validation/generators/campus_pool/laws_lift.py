"""Lift laws: the tail fin, stall of the head plate, and the lag of its lift."""

from __future__ import annotations

from typing import Any

import numpy as np

from .registry import form


def _fin(w: Any, p: dict[str, float]) -> tuple[float, Any, Any, float]:
    """Arm, speeds at the fin, and force scale 1/2 rho S with S in units of span times tail."""
    arm = w.rb.hinge_to_com - w.rb.core - p["aft"] * w.rb.tail
    side = w.v + w.r * arm
    scale = 0.5 * w.rb.density * w.rb.span * w.rb.tail * p["amp"]
    return arm, np.abs(w.u) + 1e-9, side, scale


@form("tail_fin_lift", "linear_incidence", "force", 1.0, 40.0, aft=(0.2, 0.8))
def _(w: Any, p: dict[str, float]) -> None:
    """Forward speed times sideways speed at the fin."""
    arm, u, side, scale = _fin(w, p)
    w.side_at(-scale * u * side, arm)


@form("tail_fin_lift", "finite_incidence", "force", 1.0, 40.0, aft=(0.2, 0.8))
def _(w: Any, p: dict[str, float]) -> None:
    """Local speed squared times half the sine of twice the local incidence, fore speed only."""
    arm, u, side, scale = _fin(w, p)
    local = np.arctan2(side, u)
    w.side_at(-scale * 0.5 * (u**2 + 0.5 * side**2) * np.sin(2 * local), arm)


@form("tail_fin_lift", "limited_incidence", "force", 1.0, 40.0, aft=(0.2, 0.8), knee=(0.3, 0.6))
def _(w: Any, p: dict[str, float]) -> None:
    """Lift that levels off at a limit of local incidence."""
    arm, u, side, scale = _fin(w, p)
    w.side_at(
        -scale
        * u
        * (u + 0.02 * w.sc.speed)
        * p["knee"]
        * np.tanh(side / ((u + 0.02 * w.sc.speed) * p["knee"])),
        arm,
    )


@form("tail_fin_lift", "jet_assisted", "force", 1.0, 40.0, aft=(0.2, 0.8), jet=(0.1, 0.5))
def _(w: Any, p: dict[str, float]) -> None:
    """Forward speed at the fin is raised by the jet of the flapping tail."""
    arm, u, side, scale = _fin(w, p)
    jet = p["jet"] * w.sc.speed * w.f / w.sc.frequency * u / (u + 0.2 * w.sc.speed)
    w.side_at(-scale * (u + jet) * side, arm)


@form("stall", "smooth_loss", "force", 0.2, 1.0, angle=(0.12, 0.35), width=(0.03, 0.08))
def _(w: Any, p: dict[str, float]) -> None:
    """A share of the lift is lost beyond an angle, with a smooth step."""
    a = np.minimum(np.abs(w.alpha), np.pi - np.abs(w.alpha))
    w.cl = w.cl * (1 - p["amp"] * 0.5 * (1 + np.tanh((a - p["angle"]) / p["width"])))


@form("stall", "kinked_decay", "force", 0.3, 3.0, angle=(0.10, 0.3))
def _(w: Any, p: dict[str, float]) -> None:
    """Lift follows the plate up to an angle and decays exponentially beyond it."""
    a = np.minimum(np.abs(w.alpha), np.pi - np.abs(w.alpha))
    w.cl = w.cl * np.exp(-p["amp"] * np.maximum(a - p["angle"], 0) / 0.2)


@form("stall", "trailing_separation", "force", 0.4, 1.0, angle=(0.15, 0.35), width=(0.05, 0.12))
def _(w: Any, p: dict[str, float]) -> None:
    """Kirchhoff flow with a separation point that moves forward: ((1 + sqrt s)/2)^2."""
    a = np.minimum(np.abs(w.alpha), np.pi - np.abs(w.alpha))
    s = 1 - p["amp"] / (1 + np.exp(-(a - p["angle"]) / p["width"]))
    w.cl = w.cl * 0.25 * (1 + np.sqrt(np.maximum(s, 0))) ** 2


@form("stall", "capped_lift", "force", 0.4, 1.0, angle=(0.12, 0.35))
def _(w: Any, p: dict[str, float]) -> None:
    """Lift coefficient capped at its value at an angle; part of the excess is lost."""
    top = w.world.coef["C_La"] * np.sin(2 * p["angle"])
    excess = np.sign(w.cl) * np.maximum(np.abs(w.cl) - top, 0)
    w.cl = w.cl - p["amp"] * excess


@form("lift_lag", "fixed_time", "force", 0.15, 1.5)
def _(w: Any, p: dict[str, float]) -> None:
    """Lift approaches its steady value with one time constant."""
    tau = p["amp"] * w.sc.time + 1e-3
    w.memory_rate[0] = (w.cl - w.memory[0]) / tau
    w.cl = w.memory[0]


@form("lift_lag", "chords_travelled", "force", 0.15, 2.0)
def _(w: Any, p: dict[str, float]) -> None:
    """Lift grows with the distance travelled, so it is slower at low speed."""
    tau = p["amp"] * w.sc.length / (w.speed + 0.05 * w.sc.speed) + 1e-3
    w.memory_rate[0] = (w.cl - w.memory[0]) / tau
    w.cl = w.memory[0]


@form("lift_lag", "two_term_indicial", "force", 0.3, 3.0, first=(0.3, 0.5))
def _(w: Any, p: dict[str, float]) -> None:
    """Part of the lift is immediate; two parts follow with a short and a long length."""
    tau = p["amp"] * w.sc.length / (w.speed + 0.05 * w.sc.speed) + 1e-3
    now = w.cl
    w.memory_rate[0] = (now - w.memory[0]) / tau
    w.memory_rate[1] = (now - w.memory[1]) / (0.25 * tau)
    w.cl = (1 - p["first"] - 0.2) * now + p["first"] * w.memory[0] + 0.2 * w.memory[1]


@form("lift_lag", "second_order", "force", 0.12, 1.0, damping=(0.4, 0.9))
def _(w: Any, p: dict[str, float]) -> None:
    """Shed vortices let the lift overshoot: a damped oscillator follows the steady value."""
    tau = p["amp"] * w.sc.time + 1e-3
    w.memory_rate[0] = w.memory[1] / tau
    w.memory_rate[1] = (w.cl - w.memory[0] - 2 * p["damping"] * w.memory[1]) / tau
    w.cl = w.memory[0]

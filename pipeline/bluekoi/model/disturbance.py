"""Random forces of water that is never quite still.

Three forces of their own that forget themselves within tau: g' = -g / tau + white noise, added to
surge, sway and yaw. Present in every filter (their intensity is fitted), absent from simulations.
Source: Kristensen, Madsen and Jorgensen, Automatica 40 (2004), 225 (grey-box diffusion terms).
"""

from __future__ import annotations

from ..integrate.system import Parameter

EFFECT_KIND = "disturbance"
AFFECTED_CHANNELS = ("surge", "sway", "yaw")
EFFECT_DESCRIPTION = "The water is never quite still and pushes the robot about at random."
EFFECT_PARAMETERS = (
    Parameter("present", "1", 1.0, 0.0, 1.0, "1 where the forces act"),
    Parameter("tau_surge", "s", 0.5, 0.05, 5.0, "time within which the surge force is forgotten"),
    Parameter("tau_sway", "s", 0.5, 0.05, 5.0, "time within which the sway force is forgotten"),
    Parameter("tau_yaw", "s", 0.5, 0.05, 5.0, "time within which the yaw moment is forgotten"),
)
EFFECT_STATE_NAMES = ("g_surge", "g_sway", "g_yaw")


def force(g_surge: float, g_sway: float, g_yaw: float) -> tuple[float, float, float]:
    """Surge and sway (N) and yaw (N m) in the frame of the core."""
    return g_surge, g_sway, g_yaw


def effect_state_derivatives(
    g_surge: float, g_sway: float, g_yaw: float, tau_surge: float, tau_sway: float, tau_yaw: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Derivatives of the three forces (N/s, N m/s)."""
    return -g_surge / tau_surge, -g_sway / tau_sway, -g_yaw / tau_yaw

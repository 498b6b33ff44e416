"""Drags, moments and pulls that the published model has not. Compiled; axes of the core."""

import math

from numba import njit

from validation.generators.concealed.swimmer.inputs import BodyParameters, HiddenLaws, TrialCommand

__all__ = ["drag_over_speed", "further_yaw_moment", "tether_force"]


@njit(cache=True)
def skin_friction(g: HiddenLaws, V: float) -> float:
    """Skin friction over speed, `k V^(p-1)`: p = 1 creeping, 1.5 laminar, 1.8 turbulent plate."""
    return g.friction * max(V, 1e-6) ** (g.friction_power - 1)


@njit(cache=True)
def wave_drag(g: HiddenLaws, V: float) -> float:
    """Wave drag over speed: `k V^4`, `k V^6`, or `k V^2 exp(-(0.5/V)^2)` (Havelock's shape)."""
    if g.wave == 0.0:
        return 0.0
    if g.wave_law == 0:
        return g.wave * V**3
    if g.wave_law == 1:
        return g.wave * V**5
    return g.wave * V * math.exp(-((0.5 / max(V, 0.02)) ** 2))


@njit(cache=True)
def coulomb_friction(g: HiddenLaws, V: float) -> float:
    """Coulomb friction over speed: `F/sqrt(V^2 + 0.02^2)`, `F tanh(V/0.03)/V`, `F V/(V+0.01)/V`."""
    if g.coulomb_law == 0:
        return g.coulomb_n / math.sqrt(V * V + 0.0004)
    if g.coulomb_law == 1:
        return g.coulomb_n * math.tanh(V / 0.03) / max(V, 1e-9)
    return g.coulomb_n / (V + 0.01)


@njit(cache=True)
def wall_nearness(b: BodyParameters, g: HiddenLaws, x: float, y: float) -> float:
    """Nearness of the nearest wall: `exp(-gap/reach)`, or `1/(1 + gap/reach)^3`."""
    gap = max(min(x, b.pool_length_m - x, y, b.pool_width_m - y), 0.0)
    if g.wall_law == 0:
        return math.exp(-gap / g.wall_reach_m)
    return (1 + gap / g.wall_reach_m) ** -3.0


@njit(cache=True)
def wake_reentry_share(g: HiddenLaws, turned: float) -> float:
    """0 to 1 as the robot comes round into its own wake: logistic or linear in the turns."""
    turns = abs(turned) / (2 * math.pi)
    if g.wake_law == 0:
        return 1 / (1 + math.exp(-25 * (turns - 1)))
    return min(max((turns - 0.85) / 0.3, 0.0), 1.0)


@njit(cache=True)
def sinking_drag_growth(g: HiddenLaws, t: float) -> float:
    """Growth of the drag while sinking: `k t`, or `k t^2 / 4 s`."""
    return g.sink_per_s * (t if g.sink_law == 0 else 0.25 * t * t)


@njit(cache=True)
def drag_over_speed(
    b: BodyParameters,
    g: HiddenLaws,
    c: TrialCommand,
    t: float,
    x: float,
    y: float,
    turned: float,
    V: float,
) -> float:
    """Sum of all further drags over speed (N s/m)."""
    k = 0.5 * b.density_kg_m3 * c.head_length_m * b.head_span_m * V
    s = skin_friction(g, V) + wave_drag(g, V) if V > 0.0 else 0.0
    if g.coulomb_n != 0.0:
        s += coulomb_friction(g, V)
    if g.wall != 0.0:
        s += k * g.wall * wall_nearness(b, g, x, y)
    if g.wake != 0.0:
        s -= k * g.wake * wake_reentry_share(g, turned)
    if g.hump != 0.0:
        s += k * g.hump * math.exp(-(((V - g.hump_m_s) / g.hump_width_m_s) ** 2))
    return s + k * sinking_drag_growth(g, t)


@njit(cache=True)
def further_yaw_moment(
    g: HiddenLaws, T: float, phi: float, u: float, V: float, r: float, heads: float
) -> float:
    """Yaw moments (N m): friction of turning, trim, thrust off its line.

    Trim: `k V^2` times the head's length in 1x heads, or `k u |u|`.
    """
    N = -g.yaw_friction * r
    N += g.trim_kg * (V * V * heads if g.trim_law == 0 else u * abs(u))
    turn = math.sin(phi) if g.thrust_arm_law == 0 else phi
    return N + g.thrust_arm_m * turn * T


@njit(cache=True)
def tether_force(g: HiddenLaws, x: float, y: float) -> tuple[float, float]:
    """Pull (N, pool frame) of a cable towards its peg, in proportion to the distance."""
    return g.tether_n_m * (g.tether_x_m - x), g.tether_n_m * (g.tether_y_m - y)

"""Core and tail as a fin.

Core and tail act as a fin of low aspect ratio at the distance a behind the centre of mass. With the
sway velocity v and the yaw rate r, the fin moves sideways at the speed v - a r. Its side force is
that of a thin wing at a small angle of attack.

On a long fin, the sideways speed varies along the fin. Two stations therefore represent the fin, at
the distances a - b and a + b behind the centre of mass. The sideways speed has the same mean and
variance over the two stations as along the whole fin. Y and N are the side force and the yaw moment
of the fin:

    dY = -1/2 rho S/2 (sqrt(u^2 + p w^2) + q |w|) w,  w = v - l r,  l = a - b, a + b
    Y = sum dY,  N = -sum l dY
    dX = g dY w u / (u^2 + w^2)

- l: distance of a station behind the centre of mass (m); w: its sideways speed (m/s); u: surge
  velocity (m/s);
- dY, dX: side force of a station, and its force along the body (N);
- rho: density of the water; S: lift slope times area of the fin (m2);
- p: factor of the sideways flow in the dynamic pressure. With p = 0, the formula is that for a wing
  at small angles. With p > 0, the fin has cross-flow drag, or the sideways flow contributes to the
  dynamic pressure. With p < 0, the fin stalls gradually;
- q: coefficient of the vortex lift over that of the lift at small angles. The vortices separate at
  the side edges of a wing of low aspect ratio. For a slender wing, q is 2 over the aspect ratio
  (Polhamus). With p = q = 0, all forces vanish without forward speed (u = 0);
- g: ratio that determines dX. With g = 0, the force is normal to the fin. With g > 0, the fin has
  an additional drag along the body. With g < 0, it has a forward force (leading-edge suction). With
  g = -1 and w small compared with u, the force is normal to the flow.

The force of the fin vanishes in straight swimming, which it stabilises.

The circulation builds up while the fin travels s head lengths h. This delay acts on the sideways
speed at the middle of the fin: the lift depends on the delayed speed w_e instead of the true speed
w_a. The speed w at the station l is then w_e - (l - a) r. With the time constant T and the state z,

    z' = (w_a - z) / T,   w_e = z + (t_0 / T) (w_a - z),   T = s h / V_a + t_0
    w_a = v - a r,  V_a^2 = u^2 + w_a^2,  t_0 = 1/60 second

- V_a: speed of the middle of the fin (m/s);
- t_0: shortest time constant that the integrator can follow;
- s: head lengths travelled. With s = 0, the lift follows at once (w_e = w_a).

A wing of high aspect ratio builds up half of its lift at once and the rest over a few chords. A
wing of low aspect ratio, such as this fin, builds up its lift faster.

Source: Newman, Marine Hydrodynamics (1977), sec. 5.15 (lifting bodies of small aspect ratio);
Hoerner and Borst, Fluid-Dynamic Lift (1975), ch. 17 (the nonlinear part at low aspect ratio); R. T.
Jones, NACA report 681 (1940) (growth of lift on wings of finite aspect ratio); Polhamus, NASA TN
D-3767 (1966) (vortex lift).
"""

from __future__ import annotations

import math

from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("sway", "yaw")
DEPENDS_ON_VARIABLES = (
    "drift",
    "turn",
)
EFFECT_DESCRIPTION = (
    "Core and tail act as a fin: with sideways motion or rotation they produce a side force that "
    "grows with forward speed and turns the nose into the flow."
)
MOST_VISIBLE_WHERE = "turns and sideways motion with forward speed; not in straight swimming"
CONFUSED_WITH = ("crossflow_drag", "linear_yaw_damping", "added_mass")
EFFECT_PARAMETERS = (
    Parameter("lift_area", "m2", 0.03, 0.0, 0.1, "lift slope times area of the fin", symbol="S"),
    Parameter("arm", "m", 0.15, 0.0, 0.4, "distance of the fin behind the centre of mass",
              symbol="a"),
    Parameter("half_length", "m", 0.03, 0.0, 0.09,
              "half the distance between the two stations of the fin", spread=0.025, symbol="b"),
    Parameter("sideways_flow_share", "1", 0.2, -0.8, 4.0,
              "factor of the sideways flow in the dynamic pressure", spread=0.4, symbol="p"),
    Parameter("vortex_share", "1", 0.0, 0.0, 4.0, "vortex lift over the lift at small angles",
              spread=1.0, symbol="q"),
    Parameter("axial_share", "1", 0.0, -1.0, 2.0,
              "0: force normal to the fin, -1: normal to the flow, above 0: drag",
              spread=0.5, symbol="g"),
    Parameter("build_up_lengths", "1", 0.2, 0.0, 4.0, "head lengths travelled as lift builds up",
              spread=0.5, symbol="s"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "|u| w": {"sideways_flow_share": 0.0},
    "V w": {"sideways_flow_share": 1.0},
    "stalling": {"sideways_flow_share": -0.5},
    "vortex lift (Polhamus)": {"vortex_share": 1.0},
    "distributed": {"half_length": 0.07},
    "induced drag": {"axial_share": 1.0},
    "late lift": {"build_up_lengths": 1.0},
    "far behind": {"arm": 0.25},
}
EFFECT_STATE_NAMES = ("z_fin",)


def force(
    rho: float, uc: float, vc: float, rc: float, h: float, time_unit: float, z_fin: float,
    S: float, a: float, b: float, p: float, q: float, g: float, s: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Surge, sway (N) and yaw (N m) of the fin."""
    front, rear = a - b, a + b
    w_a = vc - a * rc
    least = math.sqrt(uc * uc + w_a * w_a + 1e-12) * time_unit / 60.0
    w_e = z_fin + least / (s * h + least) * (w_a - z_fin)
    wf, wr = w_e + b * rc, w_e - b * rc
    k = -0.25 * rho * S
    Yf = k * (math.sqrt(max(uc * uc + p * wf * wf, 0.0) + 1e-12) + q * abs(wf)) * wf
    Yr = k * (math.sqrt(max(uc * uc + p * wr * wr, 0.0) + 1e-12) + q * abs(wr)) * wr
    Xf = Yf * wf / (uc * uc + wf * wf + 1e-12)
    Xr = Yr * wr / (uc * uc + wr * wr + 1e-12)
    return g * uc * (Xf + Xr), Yf + Yr, -front * Yf - rear * Yr


def effect_state_derivatives(
    uc: float, vc: float, rc: float, h: float, time_unit: float, z_fin: float, a: float, s: float
) -> tuple[float]:
    """Derivative of z (m/s2), not faster than the integrator follows.

    Smooth in s at 0, where a fit ends if the lift follows at once.
    """
    w = vc - a * rc
    V = math.sqrt(uc * uc + w * w + 1e-12)
    return ((w - z_fin) * V / (s * h + V * time_unit / 60.0),)

"""A force without a name: a sum of simple terms in what the robot does and where it is.

    surge: a1 u + a2 u^3 + a3 f u + a4 r^2 + a5 v^2 + a6 t u^2 + a7 f^2 sin^2 phi
           + a8 f + a9 f^3 + (a10 x + a11 y) u^2 + (a12 R(2.5) + a13 R(3.5) + a14 R(4.5)) f^2
    sway:  b1 v + b2 v |v| + b3 u v + b4 u r + b5 r + b6 r |r| + b7 f^2 sin phi + b8 u^2 sin phi
           + b9 + b10 f^2 + b11 e
    yaw:   c1 r + c2 v + c3 u v + c4 u r + c5 v |v| + c6 u^2 sin phi + c7 f^2 sin phi
           + c8 V^2 sin 4 alpha + c9 + c10 f + c11 sin 2 psi + c12 cos 2 psi
           + c13 e + c14 sin psi + c15 cos psi
    pool:  d1 (-x, -y) + d2 (1, 0) + d3 (0, 1) + d4 (x, -y) + d5 (-y, x)

with x and y from the middle of the pool, alpha the angle of attack of the head, psi the core's
heading, what fades with the time since the start, e = exp(-t / 2 s), and the humps
R(c) = 1 / (1 + ((f - c) / 0.6 Hz)^2)^2 over the frequency (`hump` has one over the speed). Fitted
where a mismatch fits none of the named causes; models it and says where it sits.
"""

from __future__ import annotations

from ..integrate.branchless import exponential
from ..integrate.system import Parameter

KIND = "residual"
CHANNELS = ("surge", "sway", "yaw")
STATEMENT = "A force that none of the named causes explains."
_TERMS = {
    "a": (
        "N s/m, N s3/m3, N s2/m, N s2, N s2/m2, N s/m2, N s2, N s, N s3, "
        "N s2/m3, N s2/m3, N s2, N s2, N s2"
    ),
    "b": "N s/m, N s2/m2, N s2/m2, N s2/m, N s, N s2, N s2, N s2/m2, N, N s2, N",
    "c": (
        "N m s, N s, N s2/m, N s2, N s2/m, N s2/m, N m s2, N s2/m, N m, N m s, N m, "
        "N m, N m, N m, N m"
    ),
    "d": "N/m, N, N, N/m, N/m",
}
"""Units of the terms of each letter."""
_WHERE = {"a": ("surge",), "b": ("sway",), "c": ("yaw",), "d": ("surge", "sway")}
PARAMETERS = tuple(
    Parameter(f"{letter}{i}", unit, 0.01, -50.0, 50.0, f"term {i} in {' and '.join(where)}")
    for (letter, units), where in zip(_TERMS.items(), _WHERE.values(), strict=True)
    for i, unit in enumerate(units.split(", "), start=1)
)
STRENGTHS = len(PARAMETERS)


def channels(term: str) -> tuple[str, ...]:
    """Channels in which a term acts, by its letter."""
    return _WHERE[term[0]]


def force(
    t: float, f: float, x: float, y: float, uc: float, vc: float, r: float,
    uh: float, vh: float, V: float, sphi: float, cpsi: float, spsi: float,
    L_pool: float, W_pool: float,
    a1: float, a2: float, a3: float, a4: float, a5: float, a6: float, a7: float,
    a8: float, a9: float, a10: float, a11: float, a12: float, a13: float, a14: float,
    b1: float, b2: float, b3: float, b4: float, b5: float, b6: float, b7: float,
    b8: float, b9: float, b10: float, b11: float,
    c1: float, c2: float, c3: float, c4: float, c5: float, c6: float, c7: float, c8: float,
    c9: float, c10: float, c11: float, c12: float, c13: float, c14: float,
    c15: float,
    d1: float, d2: float, d3: float, d4: float, d5: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Surge and sway (N) and yaw (N m)."""
    jet, wave = f * f * sphi, -4.0 * uh * vh * (uh * uh - vh * vh) / (V * V)
    q12, q13, q14 = (f - 2.5) / 0.6, (f - 3.5) / 0.6, (f - 4.5) / 0.6
    e12, e13, e14 = 1.0 + q12 * q12, 1.0 + q13 * q13, 1.0 + q14 * q14
    resonance = a12 / (e12 * e12) + a13 / (e13 * e13) + a14 / (e14 * e14)
    fading = exponential(-0.5 * t)
    mx, my = x - 0.5 * L_pool, y - 0.5 * W_pool
    px = (d4 - d1) * mx - d5 * my + d2
    py = -(d1 + d4) * my + d5 * mx + d3
    X = (a1 * uc + a2 * uc * uc * uc + a3 * f * uc + a4 * r * r + a5 * vc * vc + a6 * t * uc * uc
         + a7 * jet * sphi + a8 * f + a9 * f * f * f
         + (a10 * mx + a11 * my) * uc * uc + resonance * f * f)  # fmt: skip
    Y = (b1 * vc + b2 * vc * abs(vc) + b3 * uc * vc + b4 * uc * r + b5 * r + b6 * r * abs(r)
         + b7 * jet + b8 * uc * uc * sphi + b9 + b10 * f * f + b11 * fading)  # fmt: skip
    N = (c1 * r + c2 * vc + c3 * uc * vc + c4 * uc * r + c5 * vc * abs(vc) + c6 * uc * uc * sphi
         + c7 * jet + c8 * wave + c9 + c10 * f + 2.0 * c11 * spsi * cpsi
         + c12 * (cpsi * cpsi - spsi * spsi) + c13 * fading
         + c14 * spsi + c15 * cpsi)  # fmt: skip
    return X + px * cpsi + py * spsi, Y - px * spsi + py * cpsi, N

"""A force without a name: a sum of simple terms in what the robot does.

    surge: a1 u + a2 u^3 + a3 f u + a4 r^2 + a5 v^2 + a6 t u^2
    sway:  b1 v + b2 v |v| + b3 u v + b4 u r + b5 r + b6 r |r|
    yaw:   c1 r + c2 v + c3 u v + c4 u r + c5 v |v| + c6 u^2 sin phi

Fitted where a mismatch fits none of the named causes; models it and says where it sits.
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "residual"
CHANNELS = ("surge", "sway", "yaw")
STATEMENT = "A force that none of the named causes explains."
_TERMS = {
    "a": ("N s/m", "N s3/m3", "N s2/m", "N s2", "N s2/m2", "N s/m2"),
    "b": ("N s/m", "N s2/m2", "N s2/m2", "N s2/m", "N s", "N s2"),
    "c": ("N m s", "N s", "N s2/m", "N s2", "N s2/m", "N s2/m"),
}
PARAMETERS = tuple(
    Parameter(f"{letter}{i}", unit, 0.01, -50.0, 50.0, f"term {i} of {channel}")
    for (letter, units), channel in zip(_TERMS.items(), CHANNELS, strict=True)
    for i, unit in enumerate(units, start=1)
)
STRENGTHS = len(PARAMETERS)


def channel(term: str) -> str:
    """Channel in which a term acts, by its letter."""
    return CHANNELS["abc".index(term[0])]


def force(
    t: float, f: float, uc: float, vc: float, r: float, sphi: float,
    a1: float, a2: float, a3: float, a4: float, a5: float, a6: float,
    b1: float, b2: float, b3: float, b4: float, b5: float, b6: float,
    c1: float, c2: float, c3: float, c4: float, c5: float, c6: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Surge and sway (N) and yaw (N m)."""
    X = a1 * uc + a2 * uc * uc * uc + a3 * f * uc + a4 * r * r + a5 * vc * vc + a6 * t * uc * uc
    Y = b1 * vc + b2 * vc * abs(vc) + b3 * uc * vc + b4 * uc * r + b5 * r + b6 * r * abs(r)
    N = (c1 * r + c2 * vc + c3 * uc * vc + c4 * uc * r + c5 * vc * abs(vc)
         + c6 * uc * uc * sphi)  # fmt: skip
    return X, Y, N

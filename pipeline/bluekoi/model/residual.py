"""A force without a physical statement: a sum of simple terms in the motion and the place.

    surge: t + u + u^3 + f u + r^2 + v^2 + t u^2 + f^2 sin^2 phi + f + f^3 + (x + y) u^2
           + (R(2.5) + R(3.5) + R(4.5)) f^2
    sway:  v + v |v| + u v + u r + r + r |r| + f^2 sin phi + u^2 sin phi + 1 + f^2 + e + t
           + x + y
    yaw:   r + v + u v + u r + v |v| + u^2 sin phi + f^2 sin phi + V^2 sin 4 alpha + 1 + f
           + e + t + x + y
    pool:  spring (-x, -y) + x (1, 0) + y (0, 1) + strain (x, -y) + swirl (-y, x)

each term with a strength of its own, x and y from the middle of the pool, alpha the angle of attack
of the head, e = exp(-t / 2 s), and R(c) = 1 / (1 + ((f - c) / 0.6 Hz)^2)^2 a peak at the flapping
frequency c (`speed_peak_forces` has a peak at a speed). The times and frequencies are those of a
robot of the published length; those of others follow from `similarity`. Fitted where a mismatch
fits none of the named causes: it models the force and says where it acts.
"""

from __future__ import annotations

from ..integrate.branchless import exponential
from ..integrate.system import Parameter

EFFECT_KIND = "residual"
AFFECTED_CHANNELS = ("surge", "sway", "yaw")
EFFECT_DESCRIPTION = "A force that none of the named causes explains."
RESIDUAL_TERMS_BY_NAME = {
    "surge_u": ("N s/m", "speed"),
    "surge_u3": ("N s3/m3", "speed"),
    "surge_fu": ("N s2/m", "speed"),
    "surge_r2": ("N s2", "turn"),
    "surge_v2": ("N s2/m2", "turn"),
    "surge_t_u2": ("N s/m2", "time"),
    "surge_f2_sin2phi": ("N s2", "head angle"),
    "surge_f": ("N s", "beat"),
    "surge_f3": ("N s3", "beat"),
    "surge_x_u2": ("N s2/m3", "place"),
    "surge_y_u2": ("N s2/m3", "place"),
    "surge_f2_near_2p5Hz": ("N s2", "beat"),
    "surge_f2_near_3p5Hz": ("N s2", "beat"),
    "surge_f2_near_4p5Hz": ("N s2", "beat"),
    "sway_v": ("N s/m", "drift"),
    "sway_v_absv": ("N s2/m2", "drift"),
    "sway_uv": ("N s2/m2", "drift"),
    "sway_ur": ("N s2/m", "turn"),
    "sway_r": ("N s", "turn"),
    "sway_r_absr": ("N s2", "turn"),
    "sway_f2_sinphi": ("N s2", "head angle"),
    "sway_u2_sinphi": ("N s2/m2", "head angle"),
    "sway_constant": ("N", "side"),
    "sway_f2": ("N s2", "side"),
    "sway_early": ("N", "early"),
    "yaw_r": ("N m s", "turn"),
    "yaw_v": ("N s", "drift"),
    "yaw_uv": ("N s2/m", "drift"),
    "yaw_ur": ("N s2", "turn"),
    "yaw_v_absv": ("N s2/m", "drift"),
    "yaw_u2_sinphi": ("N s2/m", "head angle"),
    "yaw_f2_sinphi": ("N m s2", "head angle"),
    "yaw_sin4alpha": ("N s2/m", "angle of attack"),
    "yaw_constant": ("N m", "side"),
    "yaw_f": ("N m s", "side"),
    "yaw_early": ("N m", "early"),
    "pool_spring": ("N/m", "place"),
    "pool_x": ("N", "current"),
    "pool_y": ("N", "current"),
    "pool_strain": ("N/m", "place"),
    "pool_swirl": ("N/m", "place"),
    "surge_t": ("N/s", "time"),
    "sway_t": ("N/s", "time"),
    "sway_x": ("N/m", "place"),
    "sway_y": ("N/m", "place"),
    "yaw_t": ("N m/s", "time"),
    "yaw_x": ("N", "place"),
    "yaw_y": ("N", "place"),
}
"""Term -> unit of its strength, and the variable that its force depends on."""
MOTION_VARIABLES = frozenset({"speed", "beat", "drift", "turn", "angle of attack", "head angle"})
"""Variables that follow from the robot's motion and drive; the others are of time and place."""
EFFECT_PARAMETERS = tuple(
    Parameter(name, unit, 0.01, -50.0, 50.0, f"residual force that depends on the {variable}")
    for name, (unit, variable) in RESIDUAL_TERMS_BY_NAME.items()
)
STRENGTH_PARAMETER_COUNT = len(EFFECT_PARAMETERS)


def channel_variable_pairs_by_term() -> dict[str, frozenset[tuple[str, str]]]:
    """Term, as `residual.term` -> pairs of channel and variable of its force."""
    return {f"residual.{name}": frozenset((c, variable) for c in channels_of_residual_term(name))
            for name, (_, variable) in RESIDUAL_TERMS_BY_NAME.items()}  # fmt: skip


def channels_of_residual_term(term: str) -> tuple[str, ...]:
    """Channels in which a term acts."""
    channel = term.split("_", maxsplit=1)[0]
    return ("surge", "sway") if channel == "pool" else (channel,)


def force(
    t: float, f: float, x: float, y: float, uc: float, vc: float, r: float, uh: float, vh:
    float, V: float, sphi: float, cpsi: float, spsi: float, L_pool: float, W_pool: float,
    time_unit: float, surge_u: float, surge_u3: float, surge_fu: float, surge_r2: float,
    surge_v2: float, surge_t_u2: float, surge_f2_sin2phi: float, surge_f: float, surge_f3: float,
    surge_x_u2: float, surge_y_u2: float, surge_f2_near_2p5Hz: float, surge_f2_near_3p5Hz: float,
    surge_f2_near_4p5Hz: float, sway_v: float, sway_v_absv: float, sway_uv: float, sway_ur:
    float, sway_r: float, sway_r_absr: float, sway_f2_sinphi: float, sway_u2_sinphi: float,
    sway_constant: float, sway_f2: float, sway_early: float, yaw_r: float, yaw_v: float, yaw_uv:
    float, yaw_ur: float, yaw_v_absv: float, yaw_u2_sinphi: float, yaw_f2_sinphi: float,
    yaw_sin4alpha: float, yaw_constant: float, yaw_f: float, yaw_early: float, pool_spring:
    float, pool_x: float, pool_y: float, pool_strain: float, pool_swirl: float, surge_t: float,
    sway_t: float, sway_x: float, sway_y: float, yaw_t: float, yaw_x: float, yaw_y: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Surge and sway (N) and yaw (N m).

    Motion: t, f, x, y, uc and vc (surge and sway velocity of the centre of mass, m/s), r, uh and vh
    (velocity of the head), V, sphi, cpsi, spsi. surge_*, sway_*, yaw_*, pool_*: the strengths of
    the terms that they name, units in `RESIDUAL_TERMS_BY_NAME`; sway_v is the sway force per sway
    velocity.
    """
    jet, wave = f * f * sphi, -4.0 * uh * vh * (uh * uh - vh * vh) / (V * V)
    beat = f * time_unit
    q12, q13, q14 = (beat - 2.5) / 0.6, (beat - 3.5) / 0.6, (beat - 4.5) / 0.6
    e12, e13, e14 = 1.0 + q12 * q12, 1.0 + q13 * q13, 1.0 + q14 * q14
    resonance = (
        surge_f2_near_2p5Hz / (e12 * e12)
        + surge_f2_near_3p5Hz / (e13 * e13)
        + surge_f2_near_4p5Hz / (e14 * e14)
    )
    fading = exponential(-0.5 * t / time_unit)
    mx, my = x - 0.5 * L_pool, y - 0.5 * W_pool
    px = (pool_strain - pool_spring) * mx - pool_swirl * my + pool_x
    py = -(pool_spring + pool_strain) * my + pool_swirl * mx + pool_y
    X = (
        surge_u * uc
        + surge_u3 * uc * uc * uc
        + surge_fu * f * uc
        + surge_r2 * r * r
        + surge_v2 * vc * vc
        + surge_t_u2 * t * uc * uc
        + surge_f2_sin2phi * jet * sphi
        + surge_f * f
        + surge_f3 * f * f * f
        + (surge_x_u2 * mx + surge_y_u2 * my) * uc * uc
        + resonance * f * f
        + surge_t * t
    )
    Y = (
        sway_v * vc
        + sway_v_absv * vc * abs(vc)
        + sway_uv * uc * vc
        + sway_ur * uc * r
        + sway_r * r
        + sway_r_absr * r * abs(r)
        + sway_f2_sinphi * jet
        + sway_u2_sinphi * uc * uc * sphi
        + sway_constant
        + sway_f2 * f * f
        + sway_early * fading
        + sway_t * t
        + sway_x * mx
        + sway_y * my
    )
    N = (
        yaw_r * r
        + yaw_v * vc
        + yaw_uv * uc * vc
        + yaw_ur * uc * r
        + yaw_v_absv * vc * abs(vc)
        + yaw_u2_sinphi * uc * uc * sphi
        + yaw_f2_sinphi * jet
        + yaw_sin4alpha * wave
        + yaw_constant
        + yaw_f * f
        + yaw_early * fading
        + yaw_t * t
        + yaw_x * mx
        + yaw_y * my
    )
    return X + px * cpsi + py * spsi, Y - px * spsi + py * cpsi, N

"""Force laws and water motions, compiled. A row of the table is (cause, variant, k, a, b).

`k` is the strength that the study solves for, `a` and `b` are fixed shape constants; the registry
in effects.py gives their names and units. Every law returns X, Y (N, head-plate axes) and N (N m,
about the centre of mass). A point on the core at s behind the centre of mass moves sideways at
w = v_core - s r; a side force there makes the moment -s Y_core.
"""

# ruff: noqa: ARG001, PLR0917 - compiled laws share one signature and take no keywords

import numpy as np
from numba import njit

FIN, VISCOUS, YAW_LINEAR, THRUST_LOSS, WALL, STALL, TRIM, CROSSFLOW = range(8)
THRUST_LINE, THRUST_AREA, LIFT_LAG, WAVE, COULOMB, SINKING, ASYMMETRY, UNLISTED = range(8, 16)
CURRENT, GYRE, WAKE, NO_FORCE = range(16, 20)
GAUSS = np.array([0.069432, 0.330009, 0.669991, 0.930568])  # Gauss-Legendre nodes on (0, 1)
GAUSS_WEIGHT = np.array([0.173927, 0.326073, 0.326073, 0.173927])


@njit(cache=True)
def core_axes(flow):
    """Relative velocity along and across the core, m/s."""
    c, n = np.cos(flow.phi), np.sin(flow.phi)
    return flow.u * c + flow.v * n, flow.v * c - flow.u * n


@njit(cache=True)
def core_force_in_head_axes(X, Y, s, flow):
    """Force at s behind the centre of mass, from core axes to head axes, and its moment."""
    c, n = np.cos(flow.phi), np.sin(flow.phi)
    return X * c - Y * n, X * n + Y * c, -s * Y


@njit(cache=True)
def fin_force(variant, k, a, b, flow, robot):
    """Side force of core and tail, area k (m2), centre at a times the caudal base's distance.

    0 Polhamus 1966 (NASA TN D-3767): potential lift plus leading-edge suction turned sideways;
    1 Jones 1946 (NACA 835): C_Y = (pi/2) b alpha, b the aspect ratio;
    2 Helmbold 1942 slope with a smooth stall at 0.35 rad and induced drag, normal to the flow;
    3 flat plate, b sin(alpha) cos(alpha) normal to the plate (Hoerner 1985, 4-1).
    """
    s = a * robot.base - robot.shift_aft
    u, v = core_axes(flow)
    w = v - s * flow.r
    q = 0.5 * robot.rho * k
    if variant == 0:
        return core_force_in_head_axes(0.0, -q * (b * abs(u) + np.pi * abs(w)) * w, s, flow)
    if variant == 1:
        return core_force_in_head_axes(0.0, -q * 0.5 * np.pi * b * abs(u) * w, s, flow)
    if variant == 2:
        speed = np.sqrt(u * u + w * w) + 1e-9
        slope = 2 * np.pi * b / (2 + np.sqrt(4 + b * b))
        lift = slope * 0.35 * np.tanh(np.arctan2(w, abs(u) + 1e-9) / 0.35)
        drag = lift * lift / (np.pi * b)
        return core_force_in_head_axes(
            q * speed * (lift * w - drag * u), -q * speed * (lift * abs(u) + drag * w), s, flow
        )
    return core_force_in_head_axes(
        0.0, -q * b * u * w * u / (np.sqrt(u * u + w * w) + 1e-9), s, flow
    )


@njit(cache=True)
def viscous_drag(variant, k, a, b, flow, robot):
    """Drag with an exponent below two.

    0 Stokes, k V; 1 laminar boundary layer, k V^1.5 (Blasius 1908); 2 linear along the core and b
    times as much across (Fossen 2011, 7.1); 3 friction line of ITTC 1957, k the wetted area (m2).
    """
    if variant == 2:
        u, v = core_axes(flow)
        return core_force_in_head_axes(-k * u, -b * k * v, 0.0, flow)
    per_speed = k
    if variant == 1:
        per_speed = k * np.sqrt(flow.speed + 1e-9)
    if variant == 3:
        reynolds = max(flow.speed * 0.33 / 1e-6, 3e3)
        per_speed = 0.5 * robot.rho * k * flow.speed * 0.075 / (np.log10(reynolds) - 2) ** 2
    return -per_speed * flow.u, -per_speed * flow.v, 0.0


@njit(cache=True)
def yaw_damping(variant, k, a, b, flow, robot):
    """Moment 0 -k r (Fossen 2011, 6.3); 1 -k r / (1 + |r| / a), linear and then levelling off."""
    if variant == 0:
        return 0.0, 0.0, -k * flow.r
    return 0.0, 0.0, -k * flow.r / (1 + abs(flow.r) / a)


@njit(cache=True)
def thrust_loss(variant, k, a, b, flow, robot):
    """Thrust lost with forward speed along the core; J = u / (f b) the advance ratio.

    0 linear in J, as open-water curves of propellers (Carlton 2012, 6); 1 k J^2 (Lighthill 1971,
    reactive thrust); 2 linear in speed, k in s/m (Blanke 1981); 3 exponential in speed.
    """
    u = max(core_axes(flow)[0], 0.0)
    J = u / (max(flow.flap, 0.2) * b)
    lost = min(k * J, 1.5)
    if variant == 1:
        lost = min(k * J * J, 1.5)
    if variant == 2:
        lost = k * u
    if variant == 3:
        lost = 1 - np.exp(-k * u)
    return core_force_in_head_axes(-lost * flow.thrust, 0.0, 0.0, flow)


@njit(cache=True)
def wall_effect(variant, k, a, b, flow, robot):
    """Forces near the four walls.

    0 suction to the wall, k rho V^2 span^2 (span/gap)^2 (image vortex, Newman 1969) with a bow-out
    moment of b metres; 1 drag raised by k exp(-gap/a) (blockage, Hoerner 1965, 10).
    """
    gx = np.array([flow.x, robot.length - flow.x, 1e3, 1e3])
    gy = np.array([1e3, 1e3, flow.y, robot.width - flow.y])
    nx, ny = np.array([-1.0, 1.0, 0.0, 0.0]), np.array([0.0, 0.0, -1.0, 1.0])
    X, Y, N = 0.0, 0.0, 0.0
    c, n = np.cos(flow.theta), np.sin(flow.theta)
    q = 0.5 * robot.rho * flow.speed
    for i in range(4):
        gap = max(min(gx[i], gy[i]), 0.04)
        if variant == 0:
            F = k * 2 * q * flow.speed * robot.span**2 * (robot.span / gap) ** 2
            side = F * (c * ny[i] - n * nx[i])
            X, Y, N = X + F * (c * nx[i] + n * ny[i]), Y + side, N - b * side
        else:
            F = k * q * robot.area * np.exp(-gap / a)
            X, Y = X - F * flow.u, Y - F * flow.v
    return X, Y, N


@njit(cache=True)
def plate_lift(share, flow, robot):
    """Force and moment of `share` times the head plate's lift product -2 u v (m2/s2)."""
    lift = 0.5 * robot.rho * robot.area * robot.C_La * share / (flow.speed + 1e-9)
    return -lift * flow.v, lift * flow.u, robot.arm * lift * flow.u


@njit(cache=True)
def stall(variant, k, a, b, flow, robot):
    """Share k of the head plate's lift lost beyond the angle a (rad), over the width b (rad).

    0 logistic (Beard and McLain 2012, 4.2); 1 Kirchhoff separation point (Leishman and Beddoes
    1989); 2 lift held at its value at a (Viterna and Corrigan 1982); 3 linear fall over 3 b.
    """
    alpha = abs(np.arctan2(flow.v, abs(flow.u) + 1e-9))
    over = (alpha - a) / b
    lost = 1 / (1 + np.exp(-over))
    if variant == 1:
        attached = 1 / (1 + np.exp(min(max(over, -30.0), 30.0)))
        lost = 1 - 0.25 * (1 + np.sqrt(attached)) ** 2
        lost = lost / 0.75
    if variant == 2:
        lost = 1 - min(1.0, np.sin(2 * a) / max(np.sin(2 * alpha), 1e-9)) if over > 0 else 0.0
    if variant == 3:
        lost = min(max(over / 3, 0.0), 1.0)
    return plate_lift(2 * k * lost * flow.u * flow.v, flow, robot)


@njit(cache=True)
def trim_moment(variant, k, a, b, flow, robot):
    """Moment 0 k V^2 rho A (bent plate); 1 k T (thrust line canted); k a length in m."""
    if variant == 0:
        return 0.0, 0.0, 0.5 * k * robot.rho * robot.area * flow.speed**2
    return 0.0, 0.0, k * flow.thrust


@njit(cache=True)
def crossflow_drag(variant, k, a, b, flow, robot):
    """Drag of the sideways flow along core and tail, coefficient k, height of the section b (m).

    0 strips, |w| w (Faltinsen 1990, 6); 1 strips of a section tapering to the tail; 2 lumped at
    the core's middle and the tail's (Healey and Lienard 1993); 3 strips with the sideways speed
    coupled to the forward one, w sqrt(u^2 + w^2) (Jorgensen 1977, NASA TR R-474).
    """
    front, length = -robot.hinge, robot.hinge + robot.base + robot.tail
    u, v = core_axes(flow)
    X, Y, N = 0.0, 0.0, 0.0
    for i in range(4):
        at, share = GAUSS[i], GAUSS_WEIGHT[i]
        if variant == 2:
            at, share = (0.35 if i < 2 else 0.9), (0.4 if i < 2 else 0.1)
        s = front + length * at - robot.shift_aft
        w = v - s * flow.r
        size = b * (1.5 - at) if variant == 1 else b
        speed = np.sqrt(u * u + w * w) if variant == 3 else abs(w)
        F = -0.5 * robot.rho * k * size * share * length * speed * w
        dX, dY, dN = core_force_in_head_axes(0.0, F, s, flow)
        X, Y, N = X + dX, Y + dY, N + dN
    return X, Y, N


@njit(cache=True)
def thrust_line(variant, k, a, b, flow, robot):
    """Thrust missing the centre of mass by 0 k sin(phi), 1 k (1 - cos(phi)) sign(phi) metres."""
    arm = np.sin(flow.phi)
    if variant == 1:
        arm = (1 - np.cos(flow.phi)) * np.sign(flow.phi)
    return 0.0, 0.0, k * arm * flow.thrust


@njit(cache=True)
def thrust_area(variant, k, a, b, flow, robot):
    """Thrust with the reference head: 0 area A^(1-k) A_ref^k; 1 (1 - k) A + k A_ref."""
    ratio = robot.area_ref / robot.area
    change = ratio**k - 1 if variant == 0 else k * (ratio - 1)
    return core_force_in_head_axes(change * flow.thrust, 0.0, 0.0, flow)


@njit(cache=True)
def lift_lag(variant, k, a, b, flow, robot):
    """Lagged minus instantaneous lift; the share a is lagged (Wagner 1925; Jones 1940: half)."""
    return plate_lift(a * (flow.z + 2 * flow.u * flow.v), flow, robot)


@njit(cache=True)
def wave_drag(variant, k, a, b, flow, robot):
    """Resistance growing faster than V^2.

    0 k V^4 (Havelock 1909, low Froude number); 1 k rho A V^2 past a hump at Froude number a,
    smooth over b (Lamb 1932, 249; Faltinsen 2005, 4).
    """
    per_speed = k * flow.speed**3
    if variant == 1:
        froude = flow.speed / np.sqrt(9.81 * 0.33)
        rise = 1 / (1 + np.exp(-(froude - a) / b))
        per_speed = 0.5 * k * robot.rho * robot.area * flow.speed * rise
    return -per_speed * flow.u, -per_speed * flow.v, 0.0


@njit(cache=True)
def coulomb_friction(variant, k, a, b, flow, robot):
    """Friction of constant size k (N): 0 Coulomb, 1 Stribeck with half more below the speed a."""
    size = k * np.tanh(flow.speed / 0.02) / (flow.speed + 1e-9)
    if variant == 1:
        size *= 1 + 0.5 * np.exp(-((flow.speed / a) ** 2))
    return -size * flow.u, -size * flow.v, 0.0


@njit(cache=True)
def sink_depth(variant, k, t):
    """Metres sunk after t: 0 steady rate k (m/s); 1 accelerating, k t^2/6; 2 k (1 - e^(-t/2))."""
    if variant == 0:
        return k * t
    if variant == 1:
        return k * t * t / 6
    return 2 * k * (1 - np.exp(-t / 2))


@njit(cache=True)
def sinking(variant, k, a, b, flow, robot):
    """Drag of the parts that go under: 0.6 of a head plate's per 0.1 m sunk."""
    size = 3.0 * robot.rho * robot.area * sink_depth(variant, k, flow.t) * 0.6 * flow.speed
    return -size * flow.u, -size * flow.v, 0.0


@njit(cache=True)
def port_starboard_asymmetry(variant, k, a, b, flow, robot):
    """0 lift stronger by k on one side and weaker on the other; 1 yaw damping alike."""
    if variant == 0:
        beta = np.tanh(10 * np.arctan2(flow.v, abs(flow.u) + 1e-6))
        return plate_lift(-2 * k * beta * flow.u * flow.v, flow, robot)
    return 0.0, 0.0, -k * robot.C_Md * flow.r * flow.r


@njit(cache=True)
def unlisted_force(variant, k, a, b, flow, robot):
    """Forces without a name in STUDY.md; phase a (rad), scale b.

    Moment of 0 sin(3 theta + a), 1 sin(theta + a) (a compass needle), 2 sin(2 pi x/b + a),
    3 sin(2 pi t/b + a); surge 4 sin(2 pi t/b + a), 5 a drag band at the speed b;
    6 tether to the pool's middle; 7 sway sin(2 theta + a); 8 moment in a speed band at b.
    """
    scale = b if b > 0 else 1.0
    band = np.exp(-(((flow.speed - b) / 0.06) ** 2))
    dx, dy = 0.5 * robot.length - flow.x, 0.5 * robot.width - flow.y
    c, n = np.cos(flow.theta), np.sin(flow.theta)
    moment = np.array([
        np.sin(3 * flow.theta + a), np.sin(flow.theta + a), np.sin(2 * np.pi * flow.x / scale + a),
        np.sin(2 * np.pi * flow.t / scale + a), 0.0, 0.0, 0.0, 0.0, band,
    ])  # fmt: skip
    surge = np.array([
        0.0, 0.0, 0.0, 0.0, np.sin(2 * np.pi * flow.t / scale + a), -band, c * dx + n * dy,
        0.0, 0.0,
    ])  # fmt: skip
    sway = np.zeros(9)
    sway[6], sway[7] = c * dy - n * dx, np.sin(2 * flow.theta + a)
    return k * surge[variant], k * sway[variant], k * moment[variant]


@njit(cache=True)
def force_of_row(cause, variant, k, a, b, flow, robot):  # noqa: C901, PLR0911, PLR0912 - a switch
    """Force and moment of one row of the table."""
    if cause == FIN:
        return fin_force(variant, k, a, b, flow, robot)
    if cause == VISCOUS:
        return viscous_drag(variant, k, a, b, flow, robot)
    if cause == YAW_LINEAR:
        return yaw_damping(variant, k, a, b, flow, robot)
    if cause == THRUST_LOSS:
        return thrust_loss(variant, k, a, b, flow, robot)
    if cause == WALL:
        return wall_effect(variant, k, a, b, flow, robot)
    if cause == STALL:
        return stall(variant, k, a, b, flow, robot)
    if cause == TRIM:
        return trim_moment(variant, k, a, b, flow, robot)
    if cause == CROSSFLOW:
        return crossflow_drag(variant, k, a, b, flow, robot)
    if cause == THRUST_LINE:
        return thrust_line(variant, k, a, b, flow, robot)
    if cause == THRUST_AREA:
        return thrust_area(variant, k, a, b, flow, robot)
    if cause == LIFT_LAG:
        return lift_lag(variant, k, a, b, flow, robot)
    if cause == WAVE:
        return wave_drag(variant, k, a, b, flow, robot)
    if cause == COULOMB:
        return coulomb_friction(variant, k, a, b, flow, robot)
    if cause == SINKING:
        return sinking(variant, k, a, b, flow, robot)
    if cause == ASYMMETRY:
        return port_starboard_asymmetry(variant, k, a, b, flow, robot)
    if cause == UNLISTED:
        return unlisted_force(variant, k, a, b, flow, robot)
    return 0.0, 0.0, 0.0


@njit(cache=True)
def total_force(flow, table, robot):
    """Sum of the table's force laws: X, Y (N), N (N m)."""
    X, Y, N = 0.0, 0.0, 0.0
    for i in range(table.shape[0]):
        row = table[i]
        dX, dY, dN = force_of_row(int(row[0]), int(row[1]), row[2], row[3], row[4], flow, robot)
        X, Y, N = X + dX, Y + dY, N + dN
    return X, Y, N


@njit(cache=True)
def lag_rate(flow, table, robot):
    """Rate of the lagged lift product: time constant k chords / V (variant 0) or k s (1)."""
    rate = 1.0
    for i in range(table.shape[0]):
        if table[i, 0] == LIFT_LAG and table[i, 2] > 0:
            rate = 1 / table[i, 2]
            if table[i, 1] == 0:
                rate = max(flow.speed, 0.02) / (table[i, 2] * robot.head)
    return min(rate, 200.0) * (-2 * flow.u * flow.v - flow.z)


@njit(cache=True)
def gyre_velocity(variant, k, a, x, y, robot):
    """Velocity (m/s) and half the vorticity (1/s) of a gyre with peak speed k.

    0 one cell, stream function sin sin (Stommel's basin); 1 Lamb-Oseen vortex of core radius a (m).
    """
    L, W = robot.length, robot.width
    if variant == 0:
        px, py = np.pi * x / L, np.pi * y / W
        wx, wy = -k * np.sin(px) * np.cos(py), k * W / L * np.cos(px) * np.sin(py)
        return wx, wy, -0.5 * np.pi * k * np.sin(px) * np.sin(py) * (1 / W + W / L**2)
    dx, dy = x - 0.5 * L, y - 0.5 * W
    d2 = (dx * dx + dy * dy) / a**2 + 1e-9
    swirl = k * 1.57 / a * (1 - np.exp(-d2)) / d2
    return -swirl * dy, swirl * dx, k * 1.57 / a * np.exp(-d2)


@njit(cache=True)
def wake_velocity(variant, k, a, t, x, y, path):
    """Velocity (m/s) of the wake left along the path, half width a (m) growing with age.

    0 thrust jet backwards, decaying as age^-1/2 (Tennekes and Lumley 1972, 4); 1 drag wake
    forwards, age^-2/3; 2 jet of uniform width, exponential decay in 4 s; 3 outward flow of a
    vortex street (Triantafyllou et al. 1993), odd across the wake. The first 1.5 s do not count.
    """
    wx, wy, total = 0.0, 0.0, 1e-9
    for j in range(path.shape[0]):
        age = t - path[j, 0]
        if age < 1.5:
            break
        dx, dy, c, n = x - path[j, 1], y - path[j, 2], path[j, 3], path[j, 4]
        width = a if variant == 2 else a * np.sqrt(1 + age / 3)
        power = -2 / 3 if variant == 1 else -0.5
        decay = np.exp(-age / 4) if variant == 2 else (1 + age) ** power
        weight = np.exp(-(dx * dx + dy * dy) / (2 * width * width)) * decay
        total += weight
        if variant == 3:
            across = (c * dy - n * dx) / width
            wx, wy = wx - weight * weight * across * n, wy + weight * weight * across * c
        else:
            along = 1.0 if variant == 1 else -1.0
            wx, wy = wx + weight * weight * along * c, wy + weight * weight * along * n
    return k * wx / total, k * wy / total


@njit(cache=True)
def water_velocity(t, x, y, table, path, robot):
    """Hidden steady water motion: velocity in the pool frame (m/s), half the vorticity (1/s)."""
    wx, wy, spin = 0.0, 0.0, 0.0
    for i in range(table.shape[0]):
        cause, variant, k, a = int(table[i, 0]), int(table[i, 1]), table[i, 2], table[i, 3]
        if cause == CURRENT:
            speed = k if variant == 0 else k * np.exp(-t / table[i, 4])
            wx, wy = wx + speed * np.cos(a), wy + speed * np.sin(a)
        elif cause == GYRE:
            dx, dy, half = gyre_velocity(variant, k, a, x, y, robot)
            wx, wy, spin = wx + dx, wy + dy, spin + half
        elif cause == WAKE and k != 0:
            dx, dy = wake_velocity(variant, k, a, t, x, y, path)
            wx, wy = wx + dx, wy + dy
    return wx, wy, spin

"""Motion of all trials at once, in impulses of body and water.

Unknowns are the position z, the impulse P in pool axes and the angular impulse H about the centre
of mass, both of body and water together (W. Thomson and G. Kirchhoff; H. Lamb, Hydrodynamics,
sections 119 to 124):

    P' = F,    H' = N - Im(conj(v) (P - m z')),    v: velocity relative to the water

so that a hidden added mass brings its Coriolis forces and the Munk moment by itself; without one
these are Newton's equations. The direction that carries the inertia is chi = theta + b phi, with
the core's share b of the yaw inertia: a servo turns the head back as it turns the core.

Integrator: W. Kutta's 3/8 rule (Z. Math. Phys. 46 (1901) 435), order 4, fixed step.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .form import Flow, Law
from .loads import (
    Bench,
    body_loads,
    head_angle,
    head_loads,
    propulsion,
    water_velocity,
)
from .robots import CORE_SHARE_OF_INERTIA, Array

Z, P, CHI, H, TURNS, LAG, SLOSH = 0, 1, 2, 3, 4, slice(5, 7), slice(7, 9)
ROWS = 9


def core_direction(chi: Array | float, phi: Array) -> Array:
    """Psi = chi + (1 - b) phi."""
    return chi + (1 - CORE_SHARE_OF_INERTIA) * phi


def impulses(bench: Bench, v: Array, r: Array, psi: Array, current: Array) -> tuple[Array, Array]:
    """Impulse (pool axes) and angular impulse of a velocity and a yaw rate."""
    a11, a22, a26, a66 = bench.masses
    own, rel = v * np.exp(-1j * psi), (v - current) * np.exp(-1j * psi)
    along = bench.robot.mass * own.real + a11 * rel.real
    across = bench.robot.mass * own.imag + a22 * rel.imag + a26 * r
    angular = (bench.robot.inertia + a66) * r + a26 * rel.imag
    return (along + 1j * across) * np.exp(1j * psi), angular


def velocities(bench: Bench, p: Array, h: Array, psi: Array, current: Array) -> tuple[Array, Array]:
    """Velocity over ground (pool axes) and yaw rate; the inverse of `impulses`."""
    a11, a22, a26, a66 = bench.masses
    m, inertia = bench.robot.mass, bench.robot.inertia + a66
    own, c = p * np.exp(-1j * psi), current * np.exp(-1j * psi)
    u = (own.real + a11 * c.real) / (m + a11)
    across, angular = own.imag + a22 * c.imag, h + a26 * c.imag
    determinant = (m + a22) * inertia - a26**2
    w = (across * inertia - a26 * angular) / determinant
    r = ((m + a22) * angular - a26 * across) / determinant
    return (u + 1j * w) * np.exp(1j * psi), r


def rates(bench: Bench, t: float, y: Array, chi0: Array) -> Array:
    """Time derivative of the unknowns, (rows, columns); chi0: chi at the start."""
    phi = head_angle(bench, t)
    psi = core_direction(y[CHI].real, phi)
    current = water_velocity(bench, t, y[Z])
    over_ground, r = velocities(bench, y[P], y[H].real, psi, current)
    v = (over_ground - current) * np.exp(-1j * psi)
    flap, thrust = propulsion(bench, t, y[TURNS].real)
    flow = Flow(t, y[Z], v, np.abs(v), psi, phi=phi, r=r, flap=flap, thrust=thrust,
                turned=y[CHI].real - chi0, head=bench.head, pool=bench.pool)  # fmt: skip
    force, moment, lift_sine = _loads(bench, flow, y[LAG].real)
    out = np.zeros_like(y)
    for law in bench.hooked("slosh"):
        out[SLOSH], inner = _slosh_rates(bench, law, y[SLOSH].real, v=over_ground, psi=psi)
        force = force + inner
    for law in bench.hooked("lag"):
        out[LAG] = law(y[LAG].real, lift_sine, flow.speed / bench.head)
    munk = (np.conj(over_ground - current) * (y[P] - bench.robot.mass * over_ground)).imag
    out[Z], out[P] = over_ground, force * np.exp(1j * psi)
    out[CHI], out[H], out[TURNS] = r, moment - munk, flap
    return out


def _loads(bench: Bench, flow: Flow, behind: Array) -> tuple[Array, Array, Array]:
    """All force (core axes), all moment about the true centre of mass, and sin 2 alpha.

    shift: true centre of mass less the stated one, in axes of the core.
    """
    thrust = flow.thrust
    for law in bench.hooked("thrust"):
        thrust = thrust * law(flow, bench.robot)
    plate, across, moment, lift_sine = head_loads(bench, flow, behind)
    body, turn = body_loads(bench, flow)
    shift = sum((law(flow.phi, bench.robot) for law in bench.hooked("centre")), 0j * flow.phi)
    moment = moment + turn + (bench.robot.arm(bench.head) - shift.real) * across
    moment = moment - bench.coefficients[5] * flow.r * np.abs(flow.r)
    moment = moment - shift.real * body.imag + shift.imag * (body.real + thrust)
    if bench.unrest:
        moment = moment + bench.unrest.moment(flow.t)
    return plate + body + thrust, moment, lift_sine


def _slosh_rates(
    bench: Bench, law: Law, state: Array, *, v: Array, psi: Array
) -> tuple[Array, Array]:
    """Rates of displacement and speed of the inner mass, and its force on the hull (N)."""
    relative = state[1] - (v * np.exp(-1j * psi)).real
    force = law(state[0], relative, bench.robot)
    return np.array([relative, -force / (law.size * bench.robot.mass)]), force


def kutta_step(rate: Callable[[float, Array], Array], t: float, y: Array, dt: float) -> Array:
    """One step of the 3/8 rule."""
    k1 = rate(t, y)
    k2 = rate(t + dt / 3, y + dt / 3 * k1)
    k3 = rate(t + 2 * dt / 3, y + dt * (k2 - k1 / 3))
    k4 = rate(t + dt, y + dt * (k1 - k2 + k3))
    return y + dt / 8 * (k1 + 3 * k2 + 3 * k3 + k4)


@dataclass(frozen=True)
class Path:
    """A motion.

    times: (samples,); y: (samples, rows, columns); v, r, psi, phi: (samples, columns).
    """

    times: Array
    y: Array
    v: Array
    r: Array
    psi: Array
    phi: Array


def at_rest(bench: Bench, z: Array, psi: Array, turns: Array | float = 0.0) -> Array:
    """Unknowns of robots at rest over ground whose cores point along psi."""
    y = np.zeros((ROWS, len(bench.flap)), complex)
    y[Z], y[TURNS] = z, turns
    phi = head_angle(bench, 0.0)
    y[CHI] = psi - (1 - CORE_SHARE_OF_INERTIA) * phi
    y[P], y[H] = impulses(bench, 0 * y[Z], 0 * psi, psi, water_velocity(bench, 0.0, y[Z]))
    return y


def integrate(bench: Bench, y: Array, duration: float, dt: float) -> Path:
    """Path from the unknowns y at time 0."""
    steps = int(np.ceil(duration / dt))
    chi0 = y[CHI].real
    kept = np.empty((steps + 1, *y.shape), complex)
    kept[0] = y
    for k in range(steps):
        kept[k + 1] = kutta_step(lambda t, s: rates(bench, t, s, chi0), k * dt, kept[k], dt)
    return _path(bench, dt * np.arange(steps + 1), kept)


def _path(bench: Bench, times: Array, y: Array) -> Path:
    phi = np.array([head_angle(bench, t) for t in times]) + 0 * y[:, CHI].real
    psi = core_direction(y[:, CHI].real, phi)
    current = np.array([water_velocity(bench, t, z) for t, z in zip(times, y[:, Z], strict=True)])
    v, r = velocities(bench, y[:, P], y[:, H].real, psi, current)
    return Path(times, y, v, r, psi, phi)

"""Trials that move together, and the loads on head, core and tail in axes of the core.

The head plate carries the published model's lift, drag and moment; fin and hidden laws act beside
it or change it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from .form import Flow, Law
from .head_laws import LAG_PARTS
from .robots import DENSITY, Array, Robot, fin_force
from .water import Unrest


@dataclass(frozen=True)
class Bench:
    """Columns that move together. coefficients: (6, columns); flap, phi, head: (columns,).

    quality: factor on each column's thrust. unrest: None in still water.
    """

    robot: Robot
    pool: tuple[float, float]
    coefficients: Array
    flap: Array
    phi: Array
    head: Array
    laws: Sequence[Law] = ()
    unrest: Unrest | None = None
    quality: Array | float = 1.0
    ripple: float = 0.0
    masses: Array = field(init=False)

    def __post_init__(self) -> None:
        total = np.zeros(4)
        for law in self.hooked("mass"):
            total = total + np.array(law(self.robot))
        object.__setattr__(self, "masses", total)

    def hooked(self, hook: str) -> list[Law]:
        """Laws that change one thing."""
        return [law for law in self.laws if law.hook == hook]


def head_angle(bench: Bench, t: float) -> Array:
    """Actual head angle (rad)."""
    phi = bench.phi
    for law in bench.hooked("servo"):
        phi = law(t, phi)
    return phi


def flapping(bench: Bench, t: float) -> Array:
    """Actual flapping frequency (Hz)."""
    factor = np.ones_like(bench.flap)
    for law in bench.hooked("flap"):
        factor = factor * law(t, (bench.flap / bench.robot.flap) ** 2)
    return bench.flap * factor


def water_velocity(bench: Bench, t: float, z: Array) -> Array:
    """Velocity of the water at z (m/s, complex)."""
    flow = 0j * z
    if bench.unrest:
        flow = flow + bench.unrest.velocity(t, z, bench.pool)
    for law in bench.hooked("water"):
        flow = flow + law(t, z, bench.pool, bench.robot)
    return flow


def propulsion(bench: Bench, t: float, turns: Array) -> tuple[Array, Array]:
    """Flapping frequency (Hz), and thrust before its losses (N), pulsing twice a beat."""
    flap = flapping(bench, t)
    pulse = 1 + bench.ripple * np.cos(4 * np.pi * turns)
    area = bench.head * bench.robot.head_span
    return flap, bench.coefficients[0] * 0.5 * DENSITY * area * flap**2 * pulse * bench.quality


def head_loads(bench: Bench, flow: Flow, behind: Array) -> tuple[Array, Array, Array, Array]:
    """Force of the head plate in core axes, its part across the plate, moment M, lift sine.

    L, D, M of the published model, with the hidden factors and the lift behind its angle.
    """
    c_la, c_da, c_d0, c_ma = bench.coefficients[1:5]
    alpha = -flow.phi - np.angle(flow.v)
    sine = np.sin(2 * alpha)
    lift_sine = sine
    for law in bench.hooked("lag"):
        now, first, second = LAG_PARTS[law.form]
        lift_sine = now * sine + first * behind[0] + second * behind[1]
    lift, drag, moment = c_la * lift_sine, c_d0 + c_da * (1 - np.cos(2 * alpha)), c_ma * sine
    for law in bench.hooked("head"):
        on_lift, on_drag, on_moment = law(alpha)
        lift, drag, moment = lift * on_lift, drag * on_drag, moment * on_moment
    q = 0.5 * DENSITY * flow.head * bench.robot.head_span * flow.speed**2
    force = q * (drag - 1j * lift) * flow.backward
    across = (force * np.conj(1j * np.exp(-1j * flow.phi))).real
    return force, across, q * moment, sine


def body_loads(bench: Bench, flow: Flow) -> tuple[Array, Array]:
    """Force (core axes) and moment of fin and hidden forces."""
    force, moment = 0j * flow.v, 0.0 * flow.r
    if bench.robot.fin:
        force, moment = fin_force(bench.robot.fin, flow.v.real, flow.v.imag, flow.r)
    for law in bench.hooked("force"):
        more, turn = law(flow, bench.robot)
        force, moment = force + more, moment + turn
    return force, moment

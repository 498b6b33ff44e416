"""Equations of motion: two flat plates with six coefficients, and the hooks for hidden laws.

Plane vectors are complex numbers.  Arrays have the shape (K trials, N instants); the same code
serves the integrator (N = 1) and the evaluation along whole paths.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .registry import Law
from .world import World

SWITCH_S = 0.025


class Flow:
    """Working state of one evaluation; laws read and change its attributes."""

    def __init__(self, world: World, t: Any, state: np.ndarray) -> None:
        """Unpack a state (x, y, theta, vx, vy, r, two memories)."""
        k = world.trials
        self.world, self.k, self.rb, self.sc = world, k, world.robot, world.scales
        self.t = t
        self.x, self.y, self.theta = state[0], state[1], state[2]
        self.velocity = state[3] + 1j * state[4]
        self.r = state[5]
        self.memory = state[6:8]
        self.memory_rate = np.zeros_like(state[6:8])
        wave = np.cos(k.mode_omega * np.asarray(t)[..., None] + k.mode_phase)
        self.water = np.sum(k.mode_amp * wave, axis=-1)
        self.motor_time = t
        self.f_gain: Any = 1.0
        self.phi = k.phi_cmd + k.phi_err + 0.0 * self.theta
        self.force: Any = 0.0
        self.moment: Any = 0.0
        self.added: list[Any] = [0.0, 0.0, 0.0, 0.0]
        self.com: Any = 0.0
        self.thrust_arm: Any = 0.0

    def relative(self) -> None:
        """Quantities that depend on the velocity through the water."""
        self.heading = np.exp(1j * self.theta)
        self.vr = self.velocity - self.water
        self.speed = np.abs(self.vr) + 1e-9
        self.vhat = self.vr / self.speed
        self.alpha = np.angle(self.heading * np.conj(self.vr + 1e-12 * self.heading))

    def plates(self, shift: dict[str, Any]) -> None:
        """Coefficients, thrust and core axes before the laws of the `force` stage."""
        c, rb = self.world.coef, self.rb
        self.core = np.exp(1j * (self.theta + self.phi))
        self.f = self.k.f_nom * switch(self.motor_time, self.k.t_on, self.k.rest) * self.f_gain
        self.area = self.k.head * rb.span
        self.half_rho_a = 0.5 * rb.density * self.area
        self.q = self.half_rho_a * self.speed**2
        self.thrust = c["C_T"] * self.half_rho_a * self.f**2 * self.k.thrust
        self.thrust = self.thrust * shift.get("thrust", 1.0)
        sin2, cos2 = np.sin(2 * self.alpha), np.cos(2 * self.alpha)
        self.cl = c["C_La"] * sin2
        self.cd = c["C_D0"] + c["C_Da"] * (1 - cos2)
        self.cm = c["C_Ma"] * sin2
        self.cmd = c["C_Md"]
        body = self.vr * np.conj(self.core)
        self.u, self.v = body.real, body.imag

    def drag_along(self, magnitude: Any) -> None:
        """Add a force against the velocity through the water."""
        self.force = self.force - magnitude * self.vhat

    def side_at(self, force: Any, arm: Any) -> None:
        """Add a force along the left normal of the core, acting `arm` ahead of the mass."""
        self.force = self.force + 1j * self.core * force
        self.moment = self.moment + arm * force


def switch(t: Any, t_on: np.ndarray, rest: np.ndarray) -> Any:
    """Motor on or off: steady in running trials, a step at `t_on` in starts from rest."""
    return np.where(rest > 0, 0.5 * (1 + np.tanh((t - t_on) / SWITCH_S)), 1.0)


def evaluate(world: World, t: Any, state: np.ndarray, laws: list[Law], **shift: Any) -> np.ndarray:
    """Time derivative of the state.  `shift` perturbs water, head angle or thrust."""
    w = Flow(world, t, state)
    for law in laws:
        if law.stage == "water":
            law.apply(w)
    w.water = w.water + shift.get("water", 0.0)
    w.relative()
    for law in laws:
        if law.stage == "command":
            law.apply(w)
    w.phi = w.phi + shift.get("phi", 0.0)
    w.plates(shift)
    for law in laws:
        if law.stage == "force":
            law.apply(w)
    plate = w.q * (w.cl * 1j - w.cd) * w.vhat
    offset = w.com * w.core
    point = w.rb.arm(w.k.head) * w.heading - offset
    pull = w.thrust * w.core
    force = pull + plate + w.force
    moment = (
        w.q * w.cm
        - w.cmd * w.r * np.abs(w.r)
        + (np.conj(point) * plate).imag
        - (np.conj(offset) * pull).imag
        + w.thrust * w.thrust_arm
        + w.moment
    )
    out = np.empty_like(state)
    out[0], out[1], out[2] = state[3], state[4], state[5]
    m, inertia = w.rb.mass, w.rb.inertia
    m11, m22, m23, m33 = w.added
    if all(np.isscalar(a) and a == 0.0 for a in w.added):
        accel, spin = force / m, moment / inertia
    else:
        body = force * np.conj(w.core)
        p1, p2 = m11 * w.u, m22 * w.v + m23 * w.r
        du = (body.real + m * w.v * w.r + p2 * w.r) / (m + m11)
        b2 = body.imag - m * w.u * w.r - p1 * w.r
        b3 = moment - (p2 * w.u - p1 * w.v)
        det = (m + m22) * (inertia + m33) - m23 * m23
        dv = ((inertia + m33) * b2 - m23 * b3) / det
        spin = ((m + m22) * b3 - m23 * b2) / det
        accel = (du + 1j * dv + 1j * w.r * (w.u + 1j * w.v)) * w.core
    out[3], out[4], out[5] = accel.real, accel.imag, spin
    out[6:8] = w.memory_rate
    return out


def commands(
    world: World, t: np.ndarray, state: np.ndarray, laws: list[Law]
) -> tuple[np.ndarray, np.ndarray]:
    """Actual head angle and flapping frequency along a path."""
    w = Flow(world, t, state)
    for law in laws:
        if law.stage == "water":
            law.apply(w)
    w.relative()
    for law in laws:
        if law.stage == "command":
            law.apply(w)
    w.plates({})
    return w.phi + 0 * w.theta, w.f + 0 * w.theta

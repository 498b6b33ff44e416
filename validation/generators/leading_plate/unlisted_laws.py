"""Forces that are not in the list of causes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .here import Family, Here, Law


@dataclass(frozen=True)
class Where:
    """Channel in which an unlisted force acts and the variable on which it depends."""

    channel: str
    variable: str


def _tether(law: Law, here: Here) -> None:
    """A floating cable pulls towards its post; slack near the post, or taut everywhere."""
    length, width = here.pool
    away = here.place - complex(length * (0.2 + 0.6 * law.shape[0]), width / 2)
    pull = law.size * here.robot.drag * away / (0.5 * width)
    if law.form == "slack":
        pull = pull * np.maximum(1 - 0.3 * width / (np.abs(away) + 1e-6), 0)
    here.force = here.force - pull * np.exp(-1j * here.theta)


def _compass(law: Law, here: Here) -> None:
    """A magnetised frame in a field: a moment that depends on the direction in the pool."""
    angle = here.theta + here.phi - 2 * np.pi * law.shape[0]
    turn = np.sin(2 * angle) if law.form == "axis" else np.sin(angle)
    size = law.size * here.robot.drag * here.robot.body_length
    here.moment = here.moment - size * turn


def _pump(law: Law, here: Here) -> None:
    """Thrust that pulses slowly: a controller that hunts."""
    rate = 2 * np.pi * (0.25 + 0.35 * law.shape[0])
    wave = np.sin(rate * here.time)
    if law.form == "square":
        wave = np.tanh(4 * wave)
    here.thrust = here.thrust * (1 + law.size * wave)


def _sail(law: Law, here: Here) -> None:
    """Wind on a mast above the water: a force fixed in the pool with its moment about the mass."""
    force = law.size * here.robot.drag * np.exp(2j * np.pi * law.shape[0] - 1j * here.theta)
    here.force = here.force + force
    lever = (0.35 if law.form == "aft" else -0.35) * here.robot.body_length
    here.moment = here.moment - lever * (force * np.exp(-1j * here.phi)).imag


UNLISTED_FAMILIES = (
    Family("tether", "load", _tether, ("taut", "slack"), 0.01, 0.6, "1",
           "pull over drag at half the width of the pool", 0.05),
    Family("magnetic_moment", "load", _compass, ("pole", "axis"), 0.001, 0.2, "1",
           "moment over drag times length", 0.01),
    Family("hunting_controller", "load", _pump, ("sine", "square"), 0.02, 0.5, "1",
           "share of thrust", 0.05),
    Family("wind_on_mast", "load", _sail, ("aft", "fore"), 0.003, 0.3, "1",
           "force over drag", 0.01),
)  # fmt: skip
WHERE = {
    "tether": Where("surge", "position"),
    "magnetic_moment": Where("yaw", "heading_rad"),
    "hunting_controller": Where("surge", "time_s"),
    "wind_on_mast": Where("yaw", "heading_rad"),
}

"""Similar robots: how quantities of the published robot carry over to one of another size.

The starting values, bounds and plausible magnitudes of the model's parameters are those of a robot
of 0.68 kg and 0.331 m. For a robot of mass m and body length l they are taken in its own units of
mass M, length L and time T (Fossen, Handbook of Marine Craft Hydrodynamics, 2011, sec. 7.2.5, the
bis system):

    M = m / 0.68 kg,   L = l / 0.331 m,   T = L^(1/2)

so that a parameter of dimension kg^a m^b s^c has M^a L^b T^c times the published magnitude. With
this T the Froude number is that of the published robot.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Protocol

from ..integrate import Effect, Parameter

PUBLISHED_MASS_KG, PUBLISHED_BODY_LENGTH_M = 0.68, 0.331
BASE_DIMENSIONS = {
    "kg": (1, 0, 0),
    "m": (0, 1, 0),
    "s": (0, 0, 1),
    "N": (1, 1, -2),
    "rad": (0, 0, 0),
    "1": (0, 0, 0),
}
"""Unit -> its powers of mass, length and time."""
UNIT_FACTOR_PATTERN = re.compile(r"(/?)\s*(\([^)]*\)|[A-Za-z]+|1)\^?([\d.]*)")
"""A factor of a unit: whether it divides, its name or bracket, its power."""


class RobotSize(Protocol):
    """Mass and length of a robot."""

    mass_kg: float
    body_length_m: float


@dataclass(frozen=True)
class RobotScaleRatios:
    """Mass, length and time of a robot over those of the published one."""

    mass: float = 1.0
    length: float = 1.0
    time: float = 1.0

    @property
    def speed_ratio(self) -> float:
        """Length over time."""
        return self.length / self.time

    def scale_ratio_for_unit(self, unit: str) -> float:
        """Magnitude of a quantity over that of the published robot, by its unit (`N s/m`)."""
        mass, length, time = unit_dimensions(unit)
        return float(self.mass**mass * self.length**length * self.time**time)


PUBLISHED_ROBOT_SCALE_RATIOS = RobotScaleRatios()


def robot_scale_ratios(robot: RobotSize) -> RobotScaleRatios:
    """`RobotScaleRatios` of a robot."""
    length = robot.body_length_m / PUBLISHED_BODY_LENGTH_M
    return RobotScaleRatios(robot.mass_kg / PUBLISHED_MASS_KG, length, length**0.5)


@lru_cache(maxsize=256)
def unit_dimensions(unit: str) -> tuple[float, float, float]:
    """Powers of mass, length and time in a unit, such as `kg m2`, `N (s/m)^1.5` or `1/m2`.

    A slash divides by the factor after it alone. Raises: KeyError for an unknown factor.
    """
    out = [0.0, 0.0, 0.0]
    for slash, factor, power in UNIT_FACTOR_PATTERN.findall(unit):
        inside = factor.startswith("(")
        own = unit_dimensions(factor[1:-1]) if inside else BASE_DIMENSIONS[factor]
        exponent = float(power or 1) * (-1.0 if slash else 1.0)
        out = [total + exponent * k for total, k in zip(out, own, strict=True)]
    return out[0], out[1], out[2]


def parameter_scaled_to_robot(parameter: Parameter, units: RobotScaleRatios) -> Parameter:
    """A parameter of the published robot for a similar one."""
    ratio = units.scale_ratio_for_unit(parameter.unit)
    return replace(
        parameter,
        start=ratio * parameter.start,
        lower=ratio * parameter.lower,
        upper=ratio * parameter.upper,
        spread=ratio * parameter.spread,
        tries=tuple(ratio * value for value in parameter.tries),
        plausible=ratio * parameter.plausible,
    )


def effect_scaled_to_robot(effect: Effect, units: RobotScaleRatios) -> Effect:
    """An effect with its parameters, starts and forms for a similar robot."""
    ratios = {p.name: units.scale_ratio_for_unit(p.unit) for p in effect.parameters}
    first = ratios[effect.parameters[0].name]
    return replace(
        effect,
        parameters=tuple(parameter_scaled_to_robot(p, units) for p in effect.parameters),
        starts=tuple(first * value for value in effect.starts),
        forms={form: {name: ratios[name] * value for name, value in own.items()}
               for form, own in effect.forms.items()},
    )  # fmt: skip

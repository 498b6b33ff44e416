"""Units of columns, brought to those of the model."""

from __future__ import annotations

import math

from ..errors import input_error

SI_FACTORS: dict[str, tuple[str, float]] = {
    "mm": ("m", 1e-3), "cm": ("m", 1e-2), "km": ("m", 1e3), "um": ("m", 1e-6),
    "in": ("m", 0.0254), "ft": ("m", 0.3048),
    "ms": ("s", 1e-3), "us": ("s", 1e-6), "min": ("s", 60.0), "h": ("s", 3600.0),
    "deg": ("rad", math.pi / 180.0), "turn": ("rad", 2.0 * math.pi),
    "deg/s": ("rad/s", math.pi / 180.0), "rpm": ("rad/s", math.pi / 30.0),
    "deg/s2": ("rad/s2", math.pi / 180.0),
    "mm/s": ("m/s", 1e-3), "cm/s": ("m/s", 1e-2), "km/h": ("m/s", 1.0 / 3.6),
    "kn": ("m/s", 1852.0 / 3600.0), "g": ("kg", 1e-3), "t": ("kg", 1e3),
    "mN": ("N", 1e-3), "kN": ("N", 1e3), "mV": ("V", 1e-3), "mA": ("A", 1e-3),
    "%": ("1", 0.01), "kHz": ("Hz", 1e3), "cm2": ("m2", 1e-4),
}  # fmt: skip
"""Unit -> SI unit and how many of it one is."""


def conversion_factor(given: str, wanted: str, file: str, where: str) -> float:
    """What numbers in `given` are multiplied by to be in `wanted`.

    Raises: InputError naming both, where one cannot become the other.
    """
    base, own = SI_FACTORS.get(given, (given, 1.0))
    target, theirs = SI_FACTORS.get(wanted, (wanted, 1.0))
    if base != target:
        fitting = [wanted, *(u for u, (b, _) in SI_FACTORS.items() if b == target)]
        raise input_error(file, where, f"unit '{given}'", f"a unit of '{wanted}'",
                          f"Known: {', '.join(dict.fromkeys(fitting))}. '{wanted}' is the unit "
                          "in MODEL.")  # fmt: skip
    return own / theirs

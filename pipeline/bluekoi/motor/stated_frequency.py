"""How exactly the flapping frequencies of a study are stated."""

from __future__ import annotations

from collections.abc import Iterable

MAX_ROUNDING_SHARE = 0.01
"""Rounding of a stated frequency that needs no warning: as exact as stated frequencies are taken to
be (`flapping_from_stated_frequency`)."""
MAX_DECIMALS = 6
"""Digits of a number in trials.csv that are looked at."""


def rounded_frequency_warnings(stated_hz: Iterable[float]) -> list[str]:
    """A sentence where all frequencies stated in a study are rounded so coarsely that the thrust,
    which is proportional to their square, is wrong by more than the fits assume.
    """
    known = [hz for hz in stated_hz if hz > 0]
    if len(known) < 2:
        return []
    unit = 10.0 ** -max(_decimals(hz) for hz in known)
    share = 0.5 * unit / min(known)
    if share <= MAX_ROUNDING_SHARE:
        return []
    return [
        f"flap_hz is stated to {unit:g} Hz, up to {100 * share:.1f} % off at {min(known):g} Hz. "
        "Thrust is proportional to its square: the difference between the powers may be taken for "
        f"missing physics. State it to {unit / 10:g} Hz, or give motor logs."
    ]


def _decimals(value: float) -> int:
    """Decimals that a number needs."""
    return next((d for d in range(MAX_DECIMALS) if round(value, d) == value), MAX_DECIMALS)

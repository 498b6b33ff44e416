"""How exactly the flapping frequencies of a study are stated."""

from __future__ import annotations

from collections.abc import Iterable

from .clock_comparison import STATED_FREQUENCY_STD_SHARE

MAX_DECIMALS = 6
"""Digits of a number in trials.csv that are looked at."""


def rounded_frequency_warnings(stated_hz: Iterable[float]) -> list[str]:
    """A sentence where the frequencies of a study are all rounded by up to more than the error that
    a stated frequency is taken to have, or no sentence.
    """
    known = [hz for hz in stated_hz if hz > 0]
    if len(known) < 2:
        return []
    unit = 10.0 ** -max(_decimals(hz) for hz in known)
    share = 0.5 * unit / min(known)
    if share <= STATED_FREQUENCY_STD_SHARE:
        return []
    return [
        f"flap_hz is stated to {unit:g} Hz, up to {100 * share:.1f} % off at {min(known):g} Hz. "
        "Thrust is proportional to its square: the difference between the powers may be taken for "
        f"missing physics. State it to {unit / 10:g} Hz, or give motor logs."
    ]


def _decimals(value: float) -> int:
    """Decimals that a number needs."""
    return next((d for d in range(MAX_DECIMALS) if round(value, d) == value), MAX_DECIMALS)

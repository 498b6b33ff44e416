"""Whether trials of one motor power flap alike, logged or not, and faster at a higher power."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

MAX_RELATIVE_FREQUENCY_DIFFERENCE = 0.2
"""Frequencies at one power differ by less, and a higher power is not slower by more: an emptying
battery loses some 15 % of its voltage."""
MAX_DEVIATION_FROM_LOGGED_FREQUENCY_SHARE = 0.1
"""Largest relative deviation of the flapping frequency of a trial without motor log from the median
of the logged trials at the same power."""
CHECK_POWER_REMEDY = (
    "Check power_pct and fps, and whether the motor logs are those of these trials."
)


def power_warnings(
    statuses: Mapping[str, Mapping[str, Any]], powers: Mapping[str, float]
) -> list[str]:
    """A sentence for powers that seem to be fractions, and for each power whose trials flap at
    different frequencies or, where they agree, more slowly than at a lower power.

    statuses: content of status/ID.json by trial id; powers: trial id -> power_pct.
    """
    groups: dict[float, dict[str, float]] = {}
    for name, status in statuses.items():
        hz = (status.get("flapping") or {}).get("flap_hz")
        if status.get("ok") and hz:
            groups.setdefault(powers[name], {})[name] = hz
    logged = {name for name, status in statuses.items()
              if (status.get("flapping") or {}).get("source") == "motor_log"}  # fmt: skip
    unlogged = _unlogged_beat_warnings(groups, logged)
    same = {power: {n: v for n, v in hz.items() if n not in unlogged}
            for power, hz in groups.items()}  # fmt: skip
    return [
        *_power_as_fraction_warnings(powers),
        *_different_frequency_warnings(same),
        *unlogged.values(),
        *_falling_frequency_warnings(groups),
    ]


def _power_as_fraction_warnings(powers: Mapping[str, float]) -> list[str]:
    """A sentence where no trial has more than one percent of the power."""
    if not powers or not 0 < max(powers.values()) <= 1:
        return []
    return [
        f"power_pct is at most {max(powers.values()):g} in all trials: is it a fraction? It is in "
        "percent, 50 for half of the power."
    ]


def _unlogged_beat_warnings(
    groups: Mapping[float, Mapping[str, float]], logged: set[str]
) -> dict[str, str]:
    """Trial without a log whose tail beats at another frequency than the logs of its power have ->
    a sentence: nothing else checks its frame rate.
    """
    out = {}
    for power, hz in sorted(groups.items()):
        logs = [value for name, value in hz.items() if name in logged]
        for name in sorted(hz.keys() - logged if logs else ()):
            ratio = hz[name] / float(np.median(logs))
            if abs(ratio - 1) > MAX_DEVIATION_FROM_LOGGED_FREQUENCY_SHARE:
                out[name] = (
                    f"Trial {name}, without a motor log, flaps {ratio:.2f} times as fast as the "
                    f"logs of other trials at {power:g} % power. Check fps and power_pct of this "
                    "trial: its speed may be wrong by that factor."
                )
    return out


def _different_frequency_warnings(groups: Mapping[float, Mapping[str, float]]) -> Iterator[str]:
    for power, hz in sorted((p, hz) for p, hz in groups.items() if hz):
        slow, fast = min(hz, key=hz.__getitem__), max(hz, key=hz.__getitem__)
        if hz[fast] > (1 + MAX_RELATIVE_FREQUENCY_DIFFERENCE) * hz[slow]:
            yield (
                f"Trials at {power:g} % power flap at {hz[slow]:.2f} Hz ({slow}) to {hz[fast]:.2f} "
                f"Hz ({fast}). {CHECK_POWER_REMEDY}"
            )


def _falling_frequency_warnings(groups: Mapping[float, Mapping[str, float]]) -> Iterator[str]:
    medians = {p: float(np.median(list(hz.values()))) for p, hz in sorted(groups.items())}
    for (low, slow), (high, fast) in pairwise(medians.items()):
        if fast * (1 + MAX_RELATIVE_FREQUENCY_DIFFERENCE) < slow:
            yield (
                f"Trials at {high:g} % power flap at {fast:.2f} Hz, more slowly than those at "
                f"{low:g} % ({slow:.2f} Hz). {CHECK_POWER_REMEDY}"
            )

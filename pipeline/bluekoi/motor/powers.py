"""Whether trials of one motor power flap alike, and faster at a higher power."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

SAME_POWER_SHARE = 0.2
"""Frequencies at one power differ by less: an emptying battery loses some 15 % of its voltage."""
REMEDY = "Check power_pct, and whether the motor logs are those of these trials."


def power_warnings(
    statuses: Mapping[str, Mapping[str, Any]], powers: Mapping[str, float]
) -> list[str]:
    """A sentence for each power whose trials flap at different frequencies or, where they agree,
    more slowly than at a lower power. statuses: content of status/ID.json by trial id; powers:
    trial id -> power_pct.
    """
    groups: dict[float, dict[str, float]] = {}
    for name, status in statuses.items():
        hz = (status.get("flapping") or {}).get("flap_hz")
        if status.get("ok") and hz:
            groups.setdefault(powers[name], {})[name] = hz
    return [*_apart(groups), *_falling(groups)]


def _apart(groups: Mapping[float, Mapping[str, float]]) -> Iterator[str]:
    for power, hz in sorted(groups.items()):
        slow, fast = min(hz, key=hz.__getitem__), max(hz, key=hz.__getitem__)
        if hz[fast] > (1 + SAME_POWER_SHARE) * hz[slow]:
            yield (
                f"Trials at {power:g} % power flap at {hz[slow]:.2f} Hz ({slow}) to {hz[fast]:.2f} "
                f"Hz ({fast}). {REMEDY}"
            )


def _falling(groups: Mapping[float, Mapping[str, float]]) -> Iterator[str]:
    medians = {p: float(np.median(list(hz.values()))) for p, hz in sorted(groups.items())}
    for (low, slow), (high, fast) in pairwise(medians.items()):
        if fast * (1 + SAME_POWER_SHARE) < slow:
            yield (
                f"Trials at {high:g} % power flap at {fast:.2f} Hz, more slowly than those at "
                f"{low:g} % ({slow:.2f} Hz). {REMEDY}"
            )

"""Trials whose frame rate alone may be wrong."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from ..fitting import Series
from ..model import plates

CLOCK_CAUSE, CLOCK_PART_NAME = "clock_error", "clock_part"


def with_clock_part(series: Sequence[Series], wrong: Collection[str]) -> list[Series]:
    """Trials of which those named in `wrong` alone have an error of the frame rate."""
    place, out = plates().constants.index(CLOCK_PART_NAME), []
    for one in series:
        constants = one.constants.copy()
        constants[place] = float(one.name in wrong)
        out.append(replace(one, constants=constants))
    return out


def trials_with_wrong_clock(series: Sequence[Series]) -> list[str]:
    """Names of the trials whose frame rate alone may be wrong; empty where it is that of all."""
    place = plates().constants.index(CLOCK_PART_NAME)
    part = [s.name for s in series if s.constants[place] == 1]
    return part if len(part) < len(series) else []

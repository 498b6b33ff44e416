"""Which trials may have a wrong frame rate, and whether that may change within a trial."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from ..engine import CandidateCause
from ..fitting import TrialSeries
from ..model import two_plate_system

CLOCK_CAUSE, CLOCK_PART_NAME = "clock_error", "clock_part"
CLOCK_DRIFT_PARAMETER = f"{CLOCK_CAUSE}.drift"


def with_clock_error_in_trials(
    series: Sequence[TrialSeries], wrong: Collection[str]
) -> list[TrialSeries]:
    """Trials of which those named in `wrong` alone have an error of the frame rate."""
    place, out = two_plate_system().constants.index(CLOCK_PART_NAME), []
    for one in series:
        constants = one.constants.copy()
        constants[place] = float(one.name in wrong)
        out.append(replace(one, constants=constants))
    return out


def trials_with_wrong_clock(series: Sequence[TrialSeries]) -> list[str]:
    """Names of the trials whose frame rate alone may be wrong; empty where it is that of all."""
    place = two_plate_system().constants.index(CLOCK_PART_NAME)
    part = [s.name for s in series if s.constants[place] == 1]
    return part if len(part) < len(series) else []


def candidates_with_constant_clock_error(
    candidates: Sequence[CandidateCause], series: Sequence[TrialSeries]
) -> tuple[CandidateCause, ...]:
    """Candidates of which a wrong frame rate is constant where no motor log is compared with it.

    The quartz of a camera is steady to 1e-4. A tail beat that drifts by more is then that of a
    motor whose supply sags, and a drifting clock would describe the same motion: all forces grow
    with the square of speed and frequency. A log tells the two apart.
    """
    if any("clock_ratio" in s.evidence for s in series):
        return tuple(candidates)
    return tuple(
        replace(c, forms=tuple(f for f in c.forms if f.name != CLOCK_DRIFT_PARAMETER))
        if c.name == CLOCK_CAUSE else c
        for c in candidates
    )  # fmt: skip

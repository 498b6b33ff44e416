"""Whether speeds and tail beats are those of a swimmer: numbers that need no motor log.

    body lengths per second   U / L
    Froude number             U / sqrt(g L)    gravity is a clock that no frame rate changes
    stride                    U / (f L)        body lengths per tail beat
    Strouhal number           f A / U          A: peak-to-peak excursion of the tail tip

f is the motor's frequency where it is known, else that in the video; stride and Strouhal number of
the latter do not depend on the clock and check lengths instead. Outside these limits a trial is
used, with a warning.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from ..data import FlappingFrequency, KeypointPositions, SteadyState
from ..study import Robot
from .clock_comparison import CLOCK_RATIO_TOLERANCE, MAX_RELATIVE_CLOCK_ERROR
from .motor_log import MIN_LOGGED_SHARE
from .tail_beat import tail_excursion

GRAVITY_M_S2 = 9.81
PLAUSIBLE_RANGES: Mapping[str, tuple[float, float, str]] = {
    "body_lengths_s": (0.05, 10.0, "{} body lengths per second (plausible: 0.05 to 10)"),
    "froude": (0.0, 0.5, "a Froude number of {} (plausible near the surface: up to 0.5)"),
    "stride_lengths": (0.0, 1.2, "{} body lengths per tail beat (plausible: up to 1.2)"),
    "strouhal": (0.1, 2.0, "a Strouhal number of {} (plausible: 0.1 to 2)"),
}
"""Plausible range of each number and its name. Sources: Videler, Fish Swimming, 1993, ch. 1 and 5
(speed, stride); Hoerner, Fluid-Dynamic Drag, 1965, ch. 11 (wave drag); Triantafyllou et al., J.
Fluids Struct. 7 (1993) 205 (Strouhal number, thrust above 0.1)."""
CLOCK_RATIO_WARNING_TOLERANCE = 0.01
"""Clocks that differ by less than this share are left to the search, without a warning."""
TAIL_LENGTH_RATIO_RANGE = (0.6, 1.3)
"""Distance from tail base to tail tip over tail_length_m: a bent tail is shorter than stated."""
CHECK_LENGTHS_REMEDY = (
    "Check fps in trials.csv against the camera's setting, and the lengths in study.yaml; a motor "
    "log or flap_hz would decide which is wrong."
)


def dimensionless_swimming_numbers(
    steady: SteadyState, flapping: FlappingFrequency, positions: KeypointPositions, robot: Robot
) -> dict[str, float]:
    """Dimensionless numbers of one trial, as in `PLAUSIBLE_RANGES`; NaN where not known."""
    length, speed, hz = robot.body_length_m, steady.speed_m_s, flapping.flap_hz
    if not (np.isfinite(speed) and speed > 0):
        return dict.fromkeys(PLAUSIBLE_RANGES, float("nan"))
    beating = hz > 0
    return {
        "body_lengths_s": speed / length,
        "froude": speed / np.sqrt(GRAVITY_M_S2 * length),
        "stride_lengths": speed / (hz * length) if beating else float("nan"),
        "strouhal": hz * tail_excursion(positions) / speed if beating else float("nan"),
    }


def clock_and_length_warnings(statuses: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """A sentence for each doubt about clocks or lengths, with the trials that give rise to it.

    statuses: content of status/ID.json by trial id.
    """
    good = {i: status for i, status in statuses.items() if status.get("ok")}
    ratios = _disagreeing_clock_ratios(good)
    others = {i: s["swimming"] for i, s in good.items() if i not in ratios and s.get("swimming")}
    stopped = {
        i: f["video_hz"] for i, s in good.items()
        if (f := s.get("flapping")) and f.get("flap_hz") == 0 and not f["agrees"]
    }  # fmt: skip
    pairs = exchanged_recordings(statuses)
    for pair in pairs:
        ratios = {i: ratio for i, ratio in ratios.items() if i not in pair}
    return [
        *map(_exchanged_recordings_warning, pairs),
        *_clock_warnings(ratios, len(good)),
        *_stopped_motor_warnings(stopped, len(good)),
        *_logged_share_warnings(
            {i: v for i, s in good.items() if (v := s.get("logged_share")) is not None}, len(good)
        ),
        *_implausible_swimming_warnings(others, len(good)),
    ]


def _disagreeing_clock_ratios(good: Mapping[str, Mapping[str, Any]]) -> dict[str, float]:
    """Trial -> tail-beat frequency in the video over the motor's, of trials whose clocks differ."""
    return {
        i: f["ratio"]
        for i, s in good.items()
        if (f := s.get("flapping"))
        and f.get("ratio") is not None
        and not f["agrees"]
        and abs(f["ratio"] - 1) > CLOCK_RATIO_WARNING_TOLERANCE
    }


def exchanged_recordings(statuses: Mapping[str, Mapping[str, Any]]) -> list[tuple[str, str]]:
    """Pairs of trials in each of whose videos the tail beats as the motor of the other one does,
    and more so than as its own.

    statuses: content of status/ID.json by trial id. A trial that fits two others is in no pair.
    """
    good = {i: status for i, status in statuses.items() if status.get("ok")}
    ratios = _disagreeing_clock_ratios(good)
    motor_hz = {i: good[i]["flapping"]["flap_hz"] for i in ratios}
    pairs = [
        (one, two) for one, two in combinations(ratios, 2)
        if all(
            abs(ratios[a] * motor_hz[a] / motor_hz[b] - 1)
            < min(CLOCK_RATIO_TOLERANCE, abs(ratios[a] - 1))
            for a, b in ((one, two), (two, one))
        )
    ]  # fmt: skip
    seen = Counter(name for pair in pairs for name in pair)
    return [pair for pair in pairs if all(seen[name] == 1 for name in pair)]


def median_tail_length_m(positions: KeypointPositions) -> float:
    """Median distance from tail base to tail tip, m; NaN where one of them was not tracked."""
    if not {"tail_tip", "tail_base"} <= set(positions.names):
        return float("nan")
    distance = np.linalg.norm(positions.part("tail_tip") - positions.part("tail_base"), axis=1)
    known = distance[np.isfinite(distance)]
    return float(np.median(known)) if len(known) else float("nan")


def tail_length_warnings(
    statuses: Mapping[str, Mapping[str, Any]], tail_length_m: float
) -> list[str]:
    """A sentence where the tail of most trials has another length than study.yaml states. The fits
    do not show it: only some of the candidate causes depend on it, inversely.
    """
    seen = [v for s in statuses.values() if s.get("ok") and (v := s.get("tail_m")) is not None]
    ratio = float(np.median(seen)) / tail_length_m if seen else 1.0
    if TAIL_LENGTH_RATIO_RANGE[0] <= ratio <= TAIL_LENGTH_RATIO_RANGE[1]:
        return []
    return [
        f"tail_length_m is {1000 * tail_length_m:.0f} mm, but tail base and tail tip lie "
        f"{1000 * ratio * tail_length_m:.0f} mm apart in the videos. Is it measured from the root "
        "of the tail, not from the hinge, and does each keypoint bear its own name?"
    ]


def implausible_numbers_text(trials: Sequence[Mapping[str, float | None]]) -> str:
    """What lies outside `PLAUSIBLE_RANGES` in these trials, with its range, or no text."""
    parts = []
    for name, (low, high, phrase) in PLAUSIBLE_RANGES.items():
        values = [v for trial in trials if (v := trial.get(name)) is not None]
        outside = [v for v in values if v < low or v > high]
        if outside:
            span = {f"{min(outside):.2g}": None, f"{max(outside):.2g}": None}
            parts.append(phrase.format(" to ".join(span)))
    return ", ".join(parts)


def _clock_warnings(ratios: dict[str, float], of: int) -> Iterator[str]:
    """One sentence for each group of trials that share a wrong clock, the largest first."""
    while ratios:
        groups = ([j for j, b in ratios.items() if abs(b / a - 1) < CLOCK_RATIO_TOLERANCE]
                  for a in ratios.values())  # fmt: skip
        group = max(groups, key=len)
        value = float(np.mean([ratios.pop(i) for i in group]))
        near = abs(value - 1) < MAX_RELATIVE_CLOCK_ERROR
        yield (
            f"{trial_list_text(group, of)}: the tail beats {value:.4g} times as fast in the "
            f"video as the "
            f"motor does. Either fps is {value:.4g} times the true frame rate (clock_error), and "
            "speeds and rates are wrong by that factor, or the motor log or flap_hz is wrong"
            f"{', or frames are missing within the recording' if near else ''}."
        )


def _exchanged_recordings_warning(pair: tuple[str, str]) -> str:
    return (
        f"trials {' and '.join(pair)}: in each one's video the tail beats as the motor of the "
        "other does. Are their videos or keypoint files exchanged, or their rows in trials.csv?"
    )


def _stopped_motor_warnings(beats_hz: Mapping[str, float], of: int) -> Iterator[str]:
    if beats_hz:
        low, high = min(beats_hz.values()), max(beats_hz.values())
        hz = f"{low:.3g}" if high < 1.01 * low else f"{low:.3g} to {high:.3g}"
        yield (
            f"{trial_list_text(list(beats_hz), of)}: flap_hz is 0, but the tail beats at {hz} Hz "
            "in the video. State the frequency, or leave flap_hz empty."
        )


def _logged_share_warnings(shares: Mapping[str, float], of: int) -> Iterator[str]:
    few = {i: share for i, share in shares.items() if share < MIN_LOGGED_SHARE}
    if few:
        yield (
            f"{trial_list_text(list(few), of)}: the motor log covers "
            f"{100 * min(few.values()):.2g} % of the recording. Is fps far too low, or is the log "
            "another trial's?"
        )


def _implausible_swimming_warnings(
    numbers: Mapping[str, Mapping[str, float | None]], of: int
) -> Iterator[str]:
    odd = [i for i, trial in numbers.items() if implausible_numbers_text([trial])]
    if odd:
        implausible = implausible_numbers_text([numbers[i] for i in odd])
        yield f"{trial_list_text(odd, of)}: {implausible}. {CHECK_LENGTHS_REMEDY}"


def trial_list_text(ids: Sequence[str], of: int) -> str:
    """The ids of some trials out of `of`, in words; more than four are counted."""
    if len(ids) == of > 1:
        return f"all {of} trials"
    names = ", ".join(ids[:4]) + (f" and {len(ids) - 4} more" if len(ids) > 4 else "")
    return f"{'trial' if len(ids) == 1 else 'trials'} {names}"

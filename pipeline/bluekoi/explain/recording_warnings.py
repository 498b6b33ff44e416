"""What is unusual in recordings but may be right, in sentences."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..data import Float
from .model import Model
from .recording_faults import (
    MIN_SPIKE_DISTANCE_RANGES,
    MIN_SPIKE_SAMPLES,
    has_grouped_sampling,
    median_interval_s,
    samples_after_gaps,
)

if TYPE_CHECKING:
    from .trials import Trial

GAP_IN_INPUTS_MESSAGE = (
    " Inputs over the gap are not known: the parts before and after it are fitted apart."
)
MAX_SENTENCES_OF_A_KIND = 3
"""How many trials are named for one fault."""
MAX_INTERVAL_RATIO, MIN_DURATION_RATIO, MIN_MODEL_RATE_PER_S = 10.0, 0.5, 0.05
"""Sampling intervals longer and trials shorter than so many of the model's shortest time constants
are reported (the fastest part of a model may fade within a sample and be right); models slower than
1 / 20 s have no time constant to compare with."""
MIN_STUCK_SAMPLES, MIN_STUCK_RUNS, MIN_ENTERING_STEP_SHARE = 5, 2, 0.5
"""A sensor that stops in mid-motion repeats a value so many times; so many times in a recording;
the step into it is this share of the usual step or more. A body that comes to rest slows down."""


def unusual_recording_warnings(model: Model, trials: Sequence[Trial]) -> list[str]:
    """Sentences on what is unusual in trials but may be right."""
    pauses, still, stuck = [], [], []
    for t in trials:
        steps = np.diff(t.times)
        usual = float(np.median(steps))
        if has_grouped_sampling(t.times):
            pauses.append(
                f"{t.name}: times come in groups: most samples are {usual:.2g} s apart, on average "
                f"{steps.mean():.2g} s. Were the times rounded, or sent in packets?"
            )
        elif len(samples_after_gaps(t.times)):
            at = t.times[steps.argmax()]
            pauses.append(
                f"{t.name}: a gap of {steps.max():.3g} s at {at:.3g} s; "
                f"samples are {usual:.3g} s apart."
                f"{GAP_IN_INPUTS_MESSAGE if model.inputs else ''}"
            )
        for name, column in t.observed.items():
            known = column[np.isfinite(column)]
            if np.ptp(known) == 0:
                still.append(f"{t.name}: {name} does not change.")
            stuck += [f"{t.name}: {text}" for text in stuck_sensor_warnings(name, t.times, column)]
    out = [text for kind in (pauses, still, stuck) for text in _first_warnings_and_count(kind)]
    for i in model.inputs:
        columns = [t.inputs[i.name] for t in trials]
        changed = np.concatenate([np.diff(c) for c in columns])
        if np.ptp(level := np.concatenate(columns)) == 0:
            more = "" if level[0] else "; right column?"
            out.append(f"Input {i.name} is {level[0]:g} throughout: how forces depend on it is not "
                       f"determined{more}.")  # fmt: skip
        if not i.held and _is_stepwise(changed):
            out.append(f"Input {i.name} changes in steps; if it was held between samples, declare "
                       "it held=True in the model.")  # fmt: skip
    return out


def time_unit_warnings(trials: Sequence[Trial], rate_per_s: float) -> list[str]:
    """A warning that the trials' unit of time may be wrong: where the sampling interval or the
    duration does not suit a model whose shortest time constant is 1 / rate.
    """
    interval = median_interval_s(trials)
    longest = max(float(np.ptp(t.times)) for t in trials)
    about = f"the model's shortest time constant is {1.0 / max(rate_per_s, 1e-9):.3g} s: check the "
    if interval * rate_per_s > MAX_INTERVAL_RATIO:
        return [f"Samples are {interval:.3g} s apart and {about}unit of time."]
    if longest * rate_per_s < MIN_DURATION_RATIO and rate_per_s > MIN_MODEL_RATE_PER_S:
        return [f"The longest trial lasts {longest:.3g} s and {about}unit of time, or record for "
                "longer."]  # fmt: skip
    return []


def _is_stepwise(changes: Float) -> bool:
    """Whether an input rests most of the time and changes in few jumps."""
    moving = np.abs(changes) > 1e-12 * max(np.abs(changes).max(initial=0.0), 1e-300)
    beside = np.zeros(len(moving), dtype=bool)
    beside[1:] |= moving[:-1]
    beside[:-1] |= moving[1:]
    return bool(moving.any() and moving.mean() < 0.2 and (moving & beside).sum() < moving.sum() / 2)


def _first_warnings_and_count(sentences: Sequence[str]) -> list[str]:
    """The first sentences of one kind, and how many more there are."""
    more = len(sentences) - MAX_SENTENCES_OF_A_KIND
    if more <= 0:
        return list(sentences)
    return [
        *sentences[:MAX_SENTENCES_OF_A_KIND],
        f"The same in {more} further trial{'s' * (more > 1)}.",
    ]


def stuck_sensor_warnings(name: str, times: Float, column: Float) -> list[str]:
    """A sentence where an observation stops in mid-motion at one value, again and again or after a
    jump: a saturated sensor, or a value that stands for nothing seen.
    """
    rows = np.flatnonzero(np.isfinite(column))
    x, t = column[rows], times[rows]
    steps = np.abs(np.diff(x))
    moving = steps[steps > 0]
    if len(moving) < MIN_SPIKE_SAMPLES:
        return []
    usual = float(np.median(moving))
    least = max(MIN_ENTERING_STEP_SHARE * usual, 3.0 * float(moving.min()))
    edges = np.flatnonzero(np.diff(np.concatenate([[False], steps == 0, [False]]).astype(int)))
    runs = edges.reshape(-1, 2)  # of steps: from the first to behind the last
    runs = runs[(runs[:, 1] - runs[:, 0] + 1 >= MIN_STUCK_SAMPLES) & (runs[:, 0] > 0)]
    stops = [(a, b) for a, b in runs.tolist() if steps[a - 1] > least]
    jumps = [(a, b) for a, b in stops if steps[a - 1] > MIN_SPIKE_DISTANCE_RANGES * usual]
    if len(stops) < MIN_STUCK_RUNS and not jumps:
        return []
    a, b = (jumps or stops)[0]
    return [
        f"{name} stops at {x[a]:.4g} from {t[a]:.3g} to {t[b]:.3g} s"
        f"{' and elsewhere' if len(stops) > 1 else ''} while it moves: does the sensor saturate, "
        "or does this value stand for nothing seen? Leave such cells empty."
    ]

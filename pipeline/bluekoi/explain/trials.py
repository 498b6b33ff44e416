"""Trials of any system: named arrays, checked where they come in, as the filter has them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from ..data import Float
from ..errors import InputError, InputIssue, did_you_mean
from ..fitting import TrialSeries
from .initial_state import initial_state_mean_and_cov
from .model import Model
from .recording_faults import duplicate_recordings, samples_after_gaps, spike_findings
from .sampling import averaged_to_rate
from .system_assembly import AssembledSystem, scale_constant_names

FIT_ROLE, HELD_OUT_ROLE, MIN_SAMPLES = "fit", "held_out", 3
MIN_SAMPLES_BETWEEN_GAPS = 8
"""Samples of a part between gaps from which its initial state can be estimated."""
MAX_RECORDED_MAGNITUDE = 1e12
MIN_DEGREE_WRAP_JUMP = 300.0
"""An angle in rad that jumps by more is one in degrees."""


@dataclass(frozen=True)
class Trial:
    """One recording:

    - times: (n,) in s, increasing; inputs, observed: name -> (n,), NaN: not observed;
    - condition: label shared by repetitions of the same experiment; role: `fit` or `held_out`;
    - group: label shared by trials with the same `Model.per_group` coefficients;
    - evidence: name -> (value, std) of quantities measured without the model (`Cause.evidence`);
    - start: state -> value at the first sample, where it is known; source: file, for messages.
    """

    name: str
    times: Float
    observed: Mapping[str, Float]
    inputs: Mapping[str, Float] = field(default_factory=dict)
    constants: Mapping[str, float] = field(default_factory=dict)
    condition: str = ""
    group: str = "all"
    role: str = FIT_ROLE
    evidence: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    start: Mapping[str, float] = field(default_factory=dict)
    source: str = ""


def validated_trials(model: Model, trials: Sequence[Trial]) -> list[Trial]:
    """Trials with arrays of the right shapes, finite inputs, increasing times, unwrapped angles.

    Raises: InputError with all that is wrong in all trials.
    """
    findings = [f for t in trials for f in _trial_findings(model, t)]
    names = [t.name for t in trials]
    twice = sorted({n for n in names if names.count(n) > 1})
    findings += [InputIssue(n, "name", "two trials of that name", "a name for each trial")
                 for n in twice]  # fmt: skip
    if not trials:
        findings.append(InputIssue("trials", "", "no trial", "one trial at least"))
    if not findings and all(t.role == HELD_OUT_ROLE for t in trials):
        findings.append(InputIssue("trials", "role", "all trials held out", "a trial to fit"))
    findings = findings or duplicate_recordings(trials)
    if findings:
        raise InputError(findings)
    return [_with_unwrapped_angles(model, t) for t in trials]


def _trial_findings(model: Model, trial: Trial) -> list[InputIssue]:
    """All that is wrong with a trial."""
    file, out = trial.source or trial.name, []
    times = np.asarray(trial.times, dtype=float)
    if times.ndim != 1:
        return [InputIssue(file, "times", f"shape {times.shape}", "one dimension")]
    if len(times) < MIN_SAMPLES:
        return [
            InputIssue(file, "times", f"{len(times)} samples", f"{MIN_SAMPLES} samples or more")
        ]
    if not np.isfinite(times).all():
        row = int(np.flatnonzero(~np.isfinite(times))[0])
        out.append(InputIssue(file, f"time, sample {row}", f"{times[row]}", "finite times"))
    elif np.any(np.diff(times) <= 0):
        row = int(np.flatnonzero(np.diff(times) <= 0)[0]) + 1
        out.append(InputIssue(file, f"time, sample {row}",
                              f"{times[row]:g} s after {times[row - 1]:g} s", "increasing times",
                              "Sort the rows and remove repeated ones."))  # fmt: skip
    out += _missing_or_unknown_name_issues(
        file, "input", trial.inputs, [i.name for i in model.inputs]
    )
    out += _missing_or_unknown_name_issues(
        file, "observation", trial.observed, [o.name for o in model.observations]
    )
    required = [c.name for c in model.constants if not np.isfinite(c.value)]
    states = [s.name for s in model.states]
    out += _missing_or_unknown_name_issues(file, "start", trial.start, states, [])
    out += _missing_or_unknown_name_issues(
        file, "constant", trial.constants, [c.name for c in model.constants], required
    )
    for name, column in [*trial.inputs.items(), *trial.observed.items()]:
        out += _column_findings(file, name, np.asarray(column, dtype=float), len(times),
                                missing=name in trial.observed)  # fmt: skip
    out += [
        f
        for o in model.observations
        if o.angle and not out
        for f in _degrees_instead_of_radians_issues(
            file, o.name, np.asarray(trial.observed[o.name])
        )
    ]
    out += [InputIssue(file, f"constant {n}", f"{v}", "a finite number")
            for n, v in trial.constants.items() if not np.isfinite(v)]  # fmt: skip
    if trial.role not in (FIT_ROLE, HELD_OUT_ROLE):
        out.append(
            InputIssue(file, "role", f"'{trial.role}'", f"'{FIT_ROLE}' or '{HELD_OUT_ROLE}'")
        )
    known = {n for c in model.causes for n in c.evidence}
    out += [InputIssue(file, "evidence", f"'{n}'", "a side measurement of a cause",
                       did_you_mean(n, known) if known else "The model has none.")
            for n in trial.evidence if n not in known]  # fmt: skip
    return out


def _degrees_instead_of_radians_issues(file: str, name: str, column: Float) -> list[InputIssue]:
    """An angle that jumps by a turn of degrees."""
    jumps = np.abs(np.diff(column))
    if not np.any(jumps > MIN_DEGREE_WRAP_JUMP):
        return []
    row = int(np.nanargmax(jumps)) + 1
    return [InputIssue(file, f"{name}, sample {row}", f"a jump by {jumps[row - 1]:.0f} rad",
                       "an angle in rad, which jumps by one turn of 6.28 at most",
                       "If the column is in degrees, say unit: deg.")]  # fmt: skip


def _missing_or_unknown_name_issues(
    file: str, what: str, given: Mapping[str, object], known: Sequence[str],
    required: Sequence[str] | None = None,
) -> list[InputIssue]:  # fmt: skip
    a = "an" if what[0] in "aeiou" else "a"
    out = [InputIssue(file, what, f"'{n}'", f"{a} {what} of the model",
                      did_you_mean(n, known) if known else f"The model has no {what}.")
            for n in given if n not in known]  # fmt: skip
    lacking = [n for n in (known if required is None else required) if n not in given]
    return out + [InputIssue(file, what, f"no '{n}'", f"a value for each {what} of the model",
                             "Name its column in data.yaml.") for n in lacking]  # fmt: skip


def _column_findings(
    file: str, name: str, column: Float, count: int, *, missing: bool
) -> list[InputIssue]:
    if column.shape != (count,):
        return [InputIssue(file, name, f"shape {column.shape}", f"({count},), as times")]
    bad = np.isinf(column) | (np.abs(column) > MAX_RECORDED_MAGNITUDE)
    if not missing:
        bad |= np.isnan(column)
    if bad.any():
        row = int(np.flatnonzero(bad)[0])
        what = "finite values, empty cells where nothing was seen" if missing else (
            "a finite value in every row: an input acts all the time")  # fmt: skip
        return [InputIssue(file, f"{name}, sample {row}", f"{column[row]}", what)]
    if missing and np.isfinite(column).sum() < MIN_SAMPLES:
        return [InputIssue(file, name, f"{int(np.isfinite(column).sum())} values",
                           f"{MIN_SAMPLES} or more that are not missing")]  # fmt: skip
    return spike_findings(file, name, column) if missing else []


def _with_unwrapped_angles(model: Model, trial: Trial) -> Trial:
    """Plain arrays, angles without jumps by a turn."""
    observed = {}
    for o in model.observations:
        column = np.array(trial.observed[o.name], dtype=float)
        known = np.isfinite(column)
        if o.angle:
            turn = 2.0 * np.pi
            column[known] = np.unwrap(column[known], period=turn)
        observed[o.name] = column
    inputs = {i.name: np.array(trial.inputs[i.name], dtype=float) for i in model.inputs}
    return replace(trial, times=np.array(trial.times, dtype=float), observed=observed,
                   inputs=inputs, condition=trial.condition or trial.name)  # fmt: skip


def series_of_trials(
    model: Model, assembly: AssembledSystem, trials: Sequence[Trial], scales: Mapping[str, float],
    rate_hz: float,
) -> list[TrialSeries]:  # fmt: skip
    """Trials as the filter has them, at no more than `rate_hz`."""
    held = [i.held for i in model.inputs]
    return [
        averaged_to_rate(as_trial_series(model, assembly, t, scales), rate_hz, held) for t in trials
    ]


def as_trial_series(
    model: Model, assembly: AssembledSystem, trial: Trial, scales: Mapping[str, float]
) -> TrialSeries:
    """A trial as the filter has it, at its own rate."""
    system, n = assembly.system, len(trial.times)
    seen = np.column_stack([trial.observed[o.name] for o in model.observations])
    inputs = np.column_stack([trial.inputs[i.name] for i in model.inputs] or [np.zeros((n, 0))])
    constants = [trial.constants.get(c.name, c.value) for c in model.constants]
    constants += [scales.get(name, 1.0) for name in scale_constant_names(model)]
    mean, cov = initial_state_mean_and_cov(model, assembly, trial.times, seen, trial.start)
    noise = np.diag([o.std for o in model.observations]) ** 2
    assert len(mean) == len(system.all_states)
    return TrialSeries(trial.name, trial.group, trial.condition, trial.times, inputs,
                       np.array(constants, dtype=float), seen, np.tile(noise, (n, 1, 1)), mean, cov,
                       dict(trial.evidence))  # fmt: skip


def split_trials_at_gaps(model: Model, trials: Sequence[Trial]) -> list[Trial]:
    """Trials cut where the inputs are not known for many sampling intervals: what they did in a
    gap would be taken for known. The parts keep their condition; too short ones are left out.
    """
    out = []
    for t in trials:
        edges = [0, *(samples_after_gaps(t.times).tolist() if model.inputs else ()), len(t.times)]
        parts = [(a, b) for a, b in pairwise(edges) if b - a >= MIN_SAMPLES_BETWEEN_GAPS]
        if len(edges) == 2 or not parts:
            out.append(t)
            continue
        out += [
            _part_of_trial(t, a, b, name=f"{t.name}/{k + 1}", condition=t.condition or t.name)
            for k, (a, b) in enumerate(parts)
        ]
    return out


def _part_of_trial(t: Trial, a: int, b: int, *, name: str, condition: str) -> Trial:
    """Samples a to b of a trial; what was measured of the whole trial counts once, and where it
    begins is known only at its first sample.
    """
    first = a == 0
    return replace(
        t, name=name, condition=condition, start=t.start if first else {},
        evidence=t.evidence if first else {}, times=t.times[a:b],
        observed={n: c[a:b] for n, c in t.observed.items()},
        inputs={n: c[a:b] for n, c in t.inputs.items()},
    )  # fmt: skip


def split_trials_into_parts(trials: Sequence[Trial], count: int) -> list[Trial]:
    """Trials cut into stretches of equal duration, `count` of each, all of them conditions of their
    own: one long recording gives no other way to see how numbers vary.
    """
    out = []
    for t in trials:
        edges = np.linspace(0, len(t.times), count + 1).astype(int)
        for k, (a, b) in enumerate(pairwise(edges)):
            name = f"{t.name}/{k + 1}"
            out.append(_part_of_trial(t, a, b, name=name, condition=name))
    return out

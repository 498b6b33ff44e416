"""Remaining time of a run, estimated from the jobs finished so far."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

OVERDUE_FACTOR = 1.2
"""A single job that takes this many times its expected time leaves the rest unknown."""
MIN_DONE_SHARE_FOR_FIRST_ESTIMATE = 0.1
"""ASSUME share of the jobs that must be done before a run without an earlier one estimates its
time. The first jobs of a new installation compile: one of the demo's 112 jobs alone gave 18 min
for 5."""


@dataclass
class RemainingTimeEstimator:
    """Jobs expected, running and done, by rule; times in s on one monotonic clock.

    usual_s: what a job of a rule took an earlier run; stands in until one is done in this.
    """

    usual_s: Mapping[str, float] = field(default_factory=dict)
    waiting: dict[str, int] = field(default_factory=dict)
    started: dict[int, tuple[str, float]] = field(default_factory=dict)
    taken_s: dict[str, list[float]] = field(default_factory=dict)
    began_s: float = math.nan

    def set_expected_jobs(self, stats: Mapping[str, int]) -> None:
        """Take the number of jobs of each rule; rules without work of their own do not count."""
        self.waiting = {rule: n for rule, n in stats.items() if rule not in ("total", "all")}

    def job_started(self, job: int, rule: str, now_s: float) -> None:
        """Note that a job runs."""
        if rule in self.waiting and job not in self.started:
            self.began_s = now_s if math.isnan(self.began_s) else self.began_s
            self.started[job] = (rule, now_s)
            self.waiting[rule] -= 1

    def job_finished(self, job: int, now_s: float) -> str:
        """Name of the rule of a job that is done now."""
        rule, since = self.started.pop(job, ("", now_s))
        if rule:
            self.taken_s.setdefault(rule, []).append(now_s - since)
        return rule

    @property
    def finished_job_count(self) -> int:
        """How many jobs are done."""
        return sum(len(times) for times in self.taken_s.values())

    @property
    def total_job_count(self) -> int:
        """How many jobs the run has."""
        return self.finished_job_count + len(self.started) + sum(self.waiting.values())

    def running_rule_names(self) -> str:
        """Names of the rules at work."""
        return ", ".join(dict.fromkeys(rule for rule, _ in self.started.values()))

    def remaining_s(self, now_s: float) -> float | None:
        """Seconds left: work left over the pace so far; None before enough is done.

        None also where the only job of a rule takes longer than ever before.
        """
        too_early = (
            not self.usual_s
            and self.finished_job_count < MIN_DONE_SHARE_FOR_FIRST_ESTIMATE * self.total_job_count
        )
        if self.finished_job_count in (0, self.total_job_count) or too_early:
            return None
        done_s = sum(sum(times) for times in self.taken_s.values())
        since = [(rule, now_s - start) for rule, start in self.started.values()]
        if any(self._overdue(rule, spent) for rule, spent in since):
            return None
        pace = (done_s + sum(s for _, s in since)) / max(now_s - self.began_s, 1e-9)
        left = sum(n * self._expected_job_s(rule) for rule, n in self.waiting.items())
        left += sum(max(self._expected_job_s(rule) - spent, 0.0) for rule, spent in since)
        return left / max(pace, 1e-9)

    def _overdue(self, rule: str, spent_s: float) -> bool:
        """Whether the only job of a rule runs longer than expected."""
        alone = not self.waiting.get(rule) and rule not in self.taken_s
        return alone and spent_s > OVERDUE_FACTOR * self._expected_job_s(rule)

    def _expected_job_s(self, rule: str) -> float:
        """Mean of the jobs done; else what is usual at this run's pace; else the mean of all."""
        if times := self.taken_s.get(rule):
            return sum(times) / len(times)
        every = [t for all_s in self.taken_s.values() for t in all_s]
        usual = self.usual_s.get(rule)
        return sum(every) / len(every) if usual is None else usual * self._slowdown_factor()

    def _slowdown_factor(self) -> float:
        """Time that jobs took over what was usual: another machine, or a busy one."""
        both = [(sum(t) / len(t), self.usual_s[r]) for r, t in self.taken_s.items()
                if self.usual_s.get(r)]  # fmt: skip
        return sum(t for t, _ in both) / sum(u for _, u in both) if both else 1.0


def durations_of_last_run_s(results: Path) -> dict[str, float]:
    """Seconds that a job of each rule took the last time in this results folder.

    From `benchmarks/` in the results; of rules with many jobs, of one of them.
    """
    return dict(_recorded_durations_s(results / "benchmarks"))


def _recorded_durations_s(folder: Path) -> Iterator[tuple[str, float]]:
    for one in sorted(folder.glob("*")):
        path = one if one.suffix == ".tsv" else next(one.glob("*.tsv"), one)
        try:
            with path.open(newline="", encoding="utf-8") as lines:
                yield one.stem, float(next(csv.DictReader(lines, delimiter="\t"))["s"])
        except (OSError, StopIteration, KeyError, ValueError):
            continue  # half-written by a run that was killed


def duration_text(seconds: float) -> str:
    """A time as a person says it: `40 s`, `3 min`, `1 h 20 min`."""
    if seconds < 90:
        return f"{max(5 * math.ceil(seconds / 5), 5)} s"
    minutes = math.ceil(seconds / 60)
    return f"{minutes} min" if minutes < 90 else f"{minutes // 60} h {minutes % 60} min"

"""How long a run still takes, from the jobs done so far."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass
class Timing:
    """Jobs expected, running and done, by rule; times in s on one monotonic clock."""

    waiting: dict[str, int] = field(default_factory=dict)
    started: dict[int, tuple[str, float]] = field(default_factory=dict)
    taken_s: dict[str, list[float]] = field(default_factory=dict)
    began_s: float = math.nan

    def expect(self, stats: Mapping[str, int]) -> None:
        """Take the number of jobs of each rule; rules without work of their own do not count."""
        self.waiting = {rule: n for rule, n in stats.items() if rule not in ("total", "all")}

    def start(self, job: int, rule: str, now_s: float) -> None:
        """Note that a job runs."""
        if rule in self.waiting and job not in self.started:
            self.began_s = now_s if math.isnan(self.began_s) else self.began_s
            self.started[job] = (rule, now_s)
            self.waiting[rule] -= 1

    def finish(self, job: int, now_s: float) -> str:
        """Name of the rule of a job that is done now."""
        rule, since = self.started.pop(job, ("", now_s))
        if rule:
            self.taken_s.setdefault(rule, []).append(now_s - since)
        return rule

    @property
    def done(self) -> int:
        """How many jobs are done."""
        return sum(len(times) for times in self.taken_s.values())

    @property
    def total(self) -> int:
        """How many jobs the run has."""
        return self.done + len(self.started) + sum(self.waiting.values())

    def running(self) -> str:
        """Names of the rules at work."""
        return ", ".join(dict.fromkeys(rule for rule, _ in self.started.values()))

    def left_s(self, now_s: float) -> float | None:
        """Seconds left: work left over the pace so far; None before anything is done.

        A rule of which no job is done yet counts with the mean of all jobs done.
        """
        if self.done in (0, self.total):
            return None
        done_s = sum(sum(times) for times in self.taken_s.values())
        since = [(rule, now_s - start) for rule, start in self.started.values()]
        pace = (done_s + sum(s for _, s in since)) / max(now_s - self.began_s, 1e-9)
        left = sum(n * self._typical(rule) for rule, n in self.waiting.items())
        left += sum(max(self._typical(rule) - spent, 0.0) for rule, spent in since)
        return left / max(pace, 1e-9)

    def _typical(self, rule: str) -> float:
        times = self.taken_s.get(rule) or [t for all_s in self.taken_s.values() for t in all_s]
        return sum(times) / len(times)


def duration(seconds: float) -> str:
    """A time as a person says it: `40 s`, `3 min`, `1 h 20 min`."""
    if seconds < 90:
        return f"{max(5 * math.ceil(seconds / 5), 5)} s"
    minutes = math.ceil(seconds / 60)
    return f"{minutes} min" if minutes < 90 else f"{minutes // 60} h {minutes % 60} min"

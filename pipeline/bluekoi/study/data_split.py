"""Which trials are fitted and which are held out."""

from __future__ import annotations

from collections.abc import Sequence

from .types import Study

HELD_OUT_SHARE = 0.25
"""Share of the trials that is held out at most."""


def has_trial_roles(study: Study) -> bool:
    """Whether trials.csv says which trials to hold out."""
    return any(t.role in {"held_out", "fit"} for t in study.trials)


def held_out_trials(study: Study, names: Sequence[str]) -> list[str]:
    """Trials that no fit sees: by `role` where a study gives it, else whole conditions.

    Without roles: conditions (sides together) in the order of power, every fourth of those whose
    power and whose head angle both occur in other conditions as well, never more than a quarter
    of the trials.
    """
    trials = [study.trial(name) for name in names]
    if has_trial_roles(study):
        return [t.trial_id for t in trials if t.role == "held_out"]
    groups: dict[tuple[float, float, float], list[str]] = {}
    for t in trials:
        groups.setdefault((t.power_pct, abs(t.head_angle_deg), t.head_length_m), []).append(
            t.trial_id
        )
    chosen: list[str] = []
    kept = set(groups)
    for key in sorted(groups)[1::3]:
        rest = kept - {key}
        alone = not all(any(other[i] == key[i] for other in rest) for i in range(3))
        if not alone and len(chosen) + len(groups[key]) <= HELD_OUT_SHARE * len(trials) + 0.5:
            kept, chosen = rest, [*chosen, *groups[key]]
    return chosen

"""Trials whose recording contradicts what trials.csv states of them.

Such a trial has a track, a warning that says what contradicts, and no part in the fits: with the
head angle of another trial it would bend all coefficients, and the verdict with them.
"""

from __future__ import annotations

from collections.abc import Mapping

from ..camera.pool_edge_check import deviating_pool_edges_m
from ..camera.rigid_length_warnings import length_deviation_by_trial
from ..campaign import Campaign
from ..data import FlappingFrequency
from ..motor import trials_with_deviating_clock
from ..motor.swimming_plausibility import exchanged_recordings
from ..pose.trial_comparison import compare_head_angles

MIN_LENGTH_DEVIATION_SHARE = 0.02
"""Deviation of a trial's rigid lengths from the others' above which it is left out: all its
positions and speeds are wrong by that share, or its head is another one."""


def contradicted_trials(
    campaign: Campaign, flapping: Mapping[str, FlappingFrequency]
) -> dict[str, str]:
    """Trial with a track -> what of it contradicts trials.csv.

    A head angle or a body length unlike the other trials'; a tail end that is not seen, though it
    is in most trials, where the edges of the pool deviate as well; a tail beat of another rate
    than the motor's, unless most trials share that ratio; a recording that is exchanged with
    another one.
    None where they are half of the trials or more: then it is not known which ones are wrong.
    """
    trials = {trial.trial_id: trial for trial in campaign.study.trials}
    clocks = trials_with_deviating_clock(flapping)
    exchanged = [i for pair in exchanged_recordings(campaign.statuses) for i in pair]
    angles = compare_head_angles(trials, campaign.statuses).contradicted
    lengths = length_deviation_by_trial(campaign.geometry, MIN_LENGTH_DEVIATION_SHARE)
    deviating_edges = deviating_pool_edges_m(campaign.statuses, campaign.study.setup.pool)
    trials_without_tail_end = (campaign.geometry or {}).get("trials_without_tail_end", ())
    found = {
        **dict.fromkeys(lengths, "rigid lengths"),
        **dict.fromkeys(
            [i for i in trials_without_tail_end if i in deviating_edges], "edges of the pool"
        ),
        **dict.fromkeys(angles, "head angle"),
        **dict.fromkeys([*clocks, *exchanged], "tail-beat frequency"),
    }
    found = {i: why for i, why in found.items() if i in campaign.tracks}
    return found if 2 * len(found) < len(campaign.tracks) else {}


def contradiction_warning(left_out: Mapping[str, str]) -> str:
    """A sentence on the trials that the fits leave out, or no text."""
    if not left_out:
        return ""
    names = ", ".join(f"{trial} ({why})" for trial, why in left_out.items())
    return (
        f"Not used in the fits, because the recording contradicts trials.csv: {names}. See the "
        "warnings on these trials; once they are corrected, or their rows are removed, run again."
    )


def few_trials_warning(used: int, with_turned_head: int, stated: int) -> str:
    """A sentence where the fits use fewer than half of the stated trials, or no text.

    used, with_turned_head: trials that the fits use, and those of them with a head angle.
    """
    if 2 * used >= stated:
        return ""
    turns = (
        f"{with_turned_head} of them with a turned head"
        if with_turned_head
        else "none with a turned head"
    )
    return (
        f"The verdict rests on {used} of {stated} trials, {turns}: the others could not be used. "
        "Read the messages on them first."
    )

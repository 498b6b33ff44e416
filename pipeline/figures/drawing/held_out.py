"""Whether a search could hold trials out, and what to call those that it was judged on."""

from __future__ import annotations

from ...campaign import Campaign


def judged_on(campaign: Campaign) -> tuple[str, ...]:
    """Ids of the trials that the errors before and after are told of, from mismatch.json."""
    found = (campaign.mismatch or {}).get("held_out") or {}
    return tuple(str(name) for name in found.get("trials") or ())


def none_held_out(campaign: Campaign) -> bool:
    """Whether the errors before and after are told of the very trials that were fitted.

    A study too small to spare any is judged on all of its trials: mismatch.json then lists every
    trial that the joint fit saw, and no fit can be made to none.
    """
    joint = campaign.coefficients.get("joint") or {}
    fitted = joint.get("trials") or [trial.trial_id for trial in campaign.analysed]
    return bool(fitted) and set(judged_on(campaign)) >= {str(name) for name in fitted}

"""What the search bought: errors before and after, or of the one model, and on which trials."""

from __future__ import annotations

import math

from ..campaign import Campaign
from ..figures.drawing.held_out import judged_on, none_held_out
from .numbers import number
from .story import Row


def columns(campaign: Campaign) -> list[str]:
    """Heads of the table of `held_out`."""
    models = ["before", "after"] if campaign.has_additions else ["model"]
    return ["error", *models, "noise floor"]


def held_out(campaign: Campaign) -> list[Row]:
    """Errors on held-out trials before and after, or of the one model, and the noise floor."""
    found = (campaign.mismatch or {}).get("held_out") or {}
    rows = [
        ("path, rms (mm)", "path_rmse_m", 1000.0),
        ("turn radius (%)", "radius_error_pct", 1.0),
        ("steady speed (%)", "speed_error_pct", 1.0),
    ]
    return [
        Row(
            label,
            (
                *(
                    _scaled(campaign.held_out_error(model, key), factor)
                    for model in campaign.held_out_models
                ),
                _floor(campaign) if key == "path_rmse_m" else "",
            ),
        )
        for label, key, factor in rows
        if found
    ]


def _floor(campaign: Campaign) -> str:
    floor = ((campaign.mismatch or {}).get("held_out") or {}).get("noise_floor_path_rmse_m")
    known = floor is not None and float(floor) < campaign.study.setup.pool.width_m
    return number(1000 * float(floor)) if floor is not None and known else "–"


def which_trials(campaign: Campaign) -> dict[str, str]:
    """Heading, caption of the table, sentence: on which trials, and stretch: how long the errors
    are told for.
    """
    names = ", ".join(judged_on(campaign))
    stretch = ((campaign.mismatch or {}).get("held_out") or {}).get("stretch_s")
    what = "Does it help" if campaign.has_additions else "How large are the errors"
    told = {"stretch": f"over stretches of {float(stretch):.1f} s, each" if stretch else ""}
    if none_held_out(campaign):
        return told | {
            "heading": f"{what} where it was fitted?",
            "caption": "Errors on the trials that were fitted",
            "sentence": f"No trial was held out, the study is too small for it: {names} were fitted"
            " as well, so that smaller errors are no proof.",
        }
    return told | {
        "heading": f"{what} where it was not fitted?",
        "caption": "Errors on held-out trials",
        "sentence": f"Held out: {names}.",
    }


def _scaled(value: float, factor: float) -> str:
    return "runs away" if math.isinf(value) else number(factor * value)

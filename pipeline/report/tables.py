"""Rows of the report's tables."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..campaign import Campaign
from ..model import TABLE_1, TABLE_2_PCT

NAMES = ("C_T", "C_D0", "C_Da", "C_La", "C_Ma", "C_Md")


def trial_rows(campaign: Campaign) -> list[dict[str, Any]]:
    """A row an analysed trial."""
    rows = []
    for trial in campaign.analysed:
        s = campaign.steady[trial.trial_id]
        status = campaign.statuses.get(trial.trial_id, {})
        rows.append({
            "id": trial.trial_id,
            "power": trial.power_pct,
            "angle": trial.head_angle_deg,
            "head": trial.head_length_m,
            "flap": s.flap_hz,
            "speed": s.speed_m_s,
            "speed_std": s.speed_std_m_s,
            "radius": s.radius_m if np.isfinite(s.radius_m) else None,
            "radius_std": s.radius_std_m if np.isfinite(s.radius_std_m) else None,
            "arc": s.arc_deg,
            "quality": s.quality,
            "reason": s.reason,
            "remarks": list(status.get("remarks", [])),
        })  # fmt: skip
    return rows


def power_rows(campaign: Campaign) -> list[dict[str, Any]]:
    """Table I: a row a power, this study's coefficients beside the paper's."""
    steps = campaign.coefficients.get("paper_steps", {})
    return [
        {
            "power": power,
            "flap_hz": found["flap_hz"],
            "cells": [
                {"name": name, **found["coefficients"][name],
                 "paper": TABLE_1.get(int(float(power)), {}).get(name)}
                for name in NAMES
            ],
        }
        for power, found in steps.items()
    ]  # fmt: skip


def radius_rows(campaign: Campaign) -> list[dict[str, Any]]:
    """Table II: a row a turning condition, model minus data."""
    one_x = campaign.study.setup.robot.head_length_m
    rows = []
    for power, found in campaign.coefficients.get("paper_steps", {}).items():
        for c in found["steps"].values():
            if c["step"] == 1 or not c["head_angle_deg"] or c["radius_m"] is None:
                continue
            size = 1.0 if abs(c["head_length_m"] - one_x) < 1e-6 else 1.5
            paper = TABLE_2_PCT.get((round(c["head_angle_deg"]), size), {})
            rows.append({"power": power, **c, "paper": paper.get(int(float(power)))})
    return rows


def coefficient_rows(campaign: Campaign) -> list[dict[str, Any]]:
    """Coefficients before and after what was left out is put in."""
    told = (campaign.mismatch_detail or {}).get("coefficients")
    if not told:
        return []
    names = list(dict.fromkeys([*told["before"], *told["after"]]))
    return [
        {"name": n, "before": told["before"].get(n), "after": told["after"].get(n)} for n in names
    ]


def candidate_rows(campaign: Campaign) -> list[dict[str, Any]]:
    """Candidates that were refitted, round by round, the best first."""
    return list((campaign.mismatch_detail or {}).get("candidates", []))

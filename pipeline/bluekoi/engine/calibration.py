"""Stated probabilities, calibrated by how often names of the same posterior probability were right.

No candidate is exactly right, so that the posterior of the statistical model is too sure. The log
odds p of a name are therefore multiplied by a slope (Platt scaling without an intercept: Platt,
Adv. Large Margin Classif. (1999), 61):

    log P / (1 - P) = b log p / (1 - p),   p > 1/2

A probability below 1/2 stays as it is: there, the posterior was right. Of several alternatives with
posterior probabilities p_i, the calibrated shares are p_i^b / sum_j p_j^b; for two of them this is
the same formula.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from .posterior import CAUSE_POSTERIOR_BOOTSTRAP_SAMPLES

LOG_ODDS_CALIBRATION_SLOPE = 0.36
"""b, from 227 names in 187 studies of nine independent generators, each analysed before its truth
was looked at: `python -m validation calibration-slope` estimates it from validation/results."""
MAX_POSTERIOR = 1.0 - 0.5 / CAUSE_POSTERIOR_BOOTSTRAP_SAMPLES
"""Resolution of an average over bootstrap samples; a probability nearer to 1 counts as this one."""


def calibrated_probability(p: float, slope: float = LOG_ODDS_CALIBRATION_SLOPE) -> float:
    """How probable a cause of posterior probability p is, by the record of earlier verdicts."""
    if p <= 0.5:
        return p
    bounded = min(p, MAX_POSTERIOR)
    return 1.0 / (1.0 + (1.0 / bounded - 1.0) ** slope)


def calibrated_shares_of_alternatives(
    posterior: Mapping[str, float], slope: float = LOG_ODDS_CALIBRATION_SLOPE
) -> dict[str, float]:
    """Shares (sum 1) of alternatives, one of which acts, by their posterior probabilities."""
    powers = {name: math.pow(max(p, 0.0), slope) for name, p in posterior.items()}
    total = sum(powers.values()) or 1.0
    return {name: power / total for name, power in powers.items()}

"""Candidate measurement errors: one file each, the folder is the list. Each adds to the stages of
`observation`.
"""

from __future__ import annotations

SESSION_TREND_PRIOR_STD = 0.5
"""ASSUME errors of scale and depth that grow from 0 to twice their mean, or the reverse, are
extreme cases, two prior standard deviations off a constant error."""

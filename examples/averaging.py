"""Means over stretches of time, for models of slow motion where errors hang together.

Errors of neighbouring frames are correlated (waves, quantisation, a tracker's habits). Taken frame
by frame, the filter's random forces fit those errors and explain the physics away with them; over
means of a stretch longer than the errors' memory they cannot.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from bluekoi.data import Float


def block_means(times: Float, seen: Float, length_s: float) -> tuple[Float, Float]:
    """Times (k,) and means (k, observations) over whole stretches, one after the other."""
    count = max(1, int((times[-1] - times[0]) / length_s + 1e-6))
    edges = times[0] + np.arange(count + 1) * length_s
    inside = [(times >= a - 1e-9) & (times < b - 1e-9) for a, b in pairwise(edges)]
    known = [k for k in inside if np.isfinite(seen[k]).all(axis=1).sum() > 1]
    rows = [(times[k].mean(), np.nanmean(seen[k], axis=0)) for k in known]
    return np.array([t for t, _ in rows]), np.array([v for _, v in rows])

"""Whether an input follows what was measured before: recordings made in closed loop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.special import fdtrc

from ..data import Float

LAG_SAMPLES = 3
"""Samples before each that may act on an input."""
MIN_EXPLAINED_SHARE, F_TEST_LEVEL = 0.05, 1e-3
"""Share of the rest of an input that innovations explain, and level of the F test, from which on it
is reported."""
MIN_UNPREDICTED_INPUT_SHARE = 1e-9
"""Share of an input's variance below which nothing is left that its own past does not give."""
ROUNDING_SHARE = 1e-20
"""Share of an input's squares that is rounding: an input that never changes leaves no more."""


def input_share_from_innovations(
    inputs: Sequence[Float], innovations: Sequence[Float], *, held: bool
) -> float:
    """Share of what an input's own past leaves of it that earlier innovations explain; 0 where the
    F test does not reject (Granger, Econometrica 37 (1969), 424).

    inputs: (n,) a trial; innovations: (n, observations) a trial, 0 where nothing was seen; held:
    whether an input acts after its sample only, so that the innovation at the same sample counts as
    earlier. In open loop innovations say nothing of later inputs.
    """
    pairs = [(u, e) for u, e in zip(inputs, innovations, strict=True) if len(u) > 2 * LAG_SAMPLES]
    if not pairs:
        return 0.0
    target = np.concatenate([u[LAG_SAMPLES:] for u, _ in pairs])
    own = np.concatenate([_lagged_columns(u[:, None], 1) for u, _ in pairs])
    own = np.column_stack([own, np.ones(len(own))])
    other = np.concatenate([_lagged_columns(e, 0 if held else 1) for _, e in pairs])
    df = len(target) - own.shape[1] - other.shape[1]
    before, after = (
        _residual_sum_of_squares(own, target),
        _residual_sum_of_squares(np.column_stack([own, other]), target),
    )
    least = MIN_UNPREDICTED_INPUT_SHARE * float(np.sum((target - target.mean()) ** 2))
    if df <= 0 or before <= max(least, ROUNDING_SHARE * float(np.sum(target**2))):
        return 0.0
    ratio = (before - after) / other.shape[1] / max(after / df, 1e-300)
    share = 1.0 - after / before
    sure = fdtrc(other.shape[1], df, ratio) < F_TEST_LEVEL
    return float(share) if sure and share > MIN_EXPLAINED_SHARE else 0.0


def feedback_sentences(
    held: Mapping[str, bool], inputs: Sequence[Float], innovations: Sequence[Float]
) -> list[str]:
    """A sentence on each input that follows earlier innovations; held: name -> whether it is held;
    inputs: (n, inputs) a trial.
    """
    out = []
    for k, (name, holds) in enumerate(held.items()):
        share = input_share_from_innovations([u[:, k] for u in inputs], innovations, held=holds)
        if share:
            out.append(
                f"Input {name} follows earlier errors of the prediction ({share:.0%} of what its "
                "past leaves): a controller closes the loop, and its answer to noise may be taken "
                "for a law."
            )
    return out


def _lagged_columns(columns: Float, first: int) -> Float:
    """Columns (n, c) at `first` to L = `LAG_SAMPLES` samples before, (n - L, c (L - first + 1))."""
    count = len(columns)
    return np.column_stack(
        [columns[LAG_SAMPLES - k : count - k] for k in range(first, LAG_SAMPLES + 1)]
    )


def _residual_sum_of_squares(design: Float, target: Float) -> float:
    scale = np.maximum(np.abs(design).max(axis=0), 1e-300)
    fit = np.linalg.lstsq(design / scale, target, rcond=1e-10)[0]
    return float(np.sum((target - design / scale @ fit) ** 2))

"""Causes of several strengths of which only some act.

A keypoint may be displaced along the body, across it, or both; a hull may differ between its sides
in lift alone. A cause of k strengths therefore is a mixture of the nonempty subsets of them: each
number of acting strengths is equally probable, and so is each subset of that number (spike and slab
within a group: Xu and Ghosh, Bayesian Anal. 10 (2015), 909),

    p(subset) = 1 / (k C(k, n)),   n strengths act

A strength that does not act is 0, or 0 within the tolerance of careful work where it has one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product
from math import comb

import numpy as np
from scipy.special import logsumexp

from ..data import Float
from .set_columns import CauseSetColumns

LogEvidence = Callable[[Float, Float, CauseSetColumns], float]
"""What the numbers of a set add to the log likelihood: by information (p, p) and gradient (p,) in
the columns of a layout, and the layout."""


@dataclass(frozen=True)
class _ActingStrengths:
    """Positions of the strengths that act, of one cause, and the log prior probability of that."""

    positions: tuple[int, ...]
    log_prior: float


def log_mean_over_strength_subsets(
    H: Float, g: Float, lay: CauseSetColumns, evidence: LogEvidence
) -> float:
    """Log evidence of a set as the mean over the acting strengths of its causes, relative to that
    with all strengths acting.

    H (p, p), g (p,): information and gradient of the likelihood in the columns of the layout.
    """
    several = [cause for cause, block in lay.blocks.items() if len(block) > 1]
    if not several:
        return 0.0
    whole = evidence(H, g, lay)
    terms = []
    for acting in product(*(list(_subsets(lay.blocks[cause])) for cause in several)):
        own = {c: one.positions for c, one in zip(several, acting, strict=True)}
        left = sorted({int(k) for c in several for k in lay.blocks[c]}
                      - {k for positions in own.values() for k in positions})  # fmt: skip
        value = whole if not left else _without_strengths(H, g, lay, left, evidence)
        terms.append(sum(one.log_prior for one in acting) + value - whole)
    found = float(logsumexp(np.nan_to_num(terms, nan=-np.inf)))
    return found if np.isfinite(found) else 0.0


def _subsets(block: np.ndarray) -> Iterator[_ActingStrengths]:
    k = len(block)
    for n in range(1, k + 1):
        for chosen in combinations(block.tolist(), n):
            yield _ActingStrengths(chosen, -float(np.log(k * comb(k, n))))


def _without_strengths(
    H: Float, g: Float, lay: CauseSetColumns, left: Sequence[int], evidence: LogEvidence
) -> float:
    """Log evidence with the strengths at positions `left` at 0, or 0 within their tolerances."""
    tolerated = [k for k in left if lay.tolerance[k] > 0]
    dropped = [k for k in left if lay.tolerance[k] == 0]
    at = lay.at[dropped]
    gain = -float(g[dropped] @ at + 0.5 * at @ H[np.ix_(dropped, dropped)] @ at)
    keep = np.setdiff1d(np.arange(len(g)), dropped)
    slopes = (g + H[:, dropped] @ at)[keep]
    return gain + evidence(H[np.ix_(keep, keep)], slopes, _reduced(lay, keep, tolerated))


def _reduced(lay: CauseSetColumns, keep: np.ndarray, tolerated: Sequence[int]) -> CauseSetColumns:
    """The layout of the columns kept; those of `tolerated` strengths belong to no cause."""
    place = {int(old): new for new, old in enumerate(keep)}
    acting = {cause: [k for k in block.tolist() if k in place and k not in tolerated]
              for cause, block in lay.blocks.items()}  # fmt: skip
    gaussian, precision, held = lay.gaussian.copy(), lay.precision.copy(), lay.held.copy()
    gaussian[list(tolerated)] = True
    precision[list(tolerated)] = lay.tolerance[list(tolerated)] ** -2.0
    held[list(tolerated)] = False
    return replace(
        lay,
        columns=lay.columns[keep],
        blocks={c: np.array([place[k] for k in own], dtype=int) for c, own in acting.items()},
        precision=precision[keep], gaussian=gaussian[keep], included=lay.included[keep],
        at=lay.at[keep], held=held[keep], tolerance=lay.tolerance[keep],
        sizes={c: lay.sizes[c][np.isin(lay.blocks[c], own)] for c, own in acting.items()},
        discrepancy={c: own[keep] for c, own in lay.discrepancy.items()},
    )  # fmt: skip

"""Which trials of a large study a search uses: those that together say most on all candidates."""

from __future__ import annotations

from heapq import heapify, heappop, heappush

import numpy as np

from ..data import Float


def d_optimal_trial_subset(information: Float, count: int) -> list[int]:
    """Indices, in order, of `count` trials whose information matrices (t, p, p) have the sum of
    largest determinant, taken one by one (D-optimal design).

    Each column is scaled to one unit of information in all trials together; the first trial is
    added to the information of an average trial whose columns are independent. A trial adds less
    the more have been taken, so that its last known gain is an upper bound: only what may be the
    best is computed again. Such a choice reaches 1 - 1/e of the best gain.
    (Nemhauser, Wolsey and Fisher, Math. Programming 14 (1978), 265)
    """
    total = np.einsum("tpp->p", information)
    seen = np.flatnonzero(total > 0)
    scale = 1.0 / np.sqrt(total[seen])
    scaled = information[:, seen[:, None], seen] * np.outer(scale, scale)
    if count >= len(scaled):
        return list(range(len(scaled)))
    sum_of_chosen = np.eye(len(seen)) / len(scaled)
    chosen: list[int] = []

    def gain(trial: int) -> float:
        return float(np.linalg.slogdet(sum_of_chosen + scaled[trial])[1] - level)

    level = float(np.linalg.slogdet(sum_of_chosen)[1])
    queue = [(-gain(t), t) for t in range(len(scaled))]
    heapify(queue)
    while len(chosen) < count:
        _, trial = heappop(queue)
        now = gain(trial)
        if queue and now < -queue[0][0]:
            heappush(queue, (-now, trial))
            continue
        chosen.append(trial)
        sum_of_chosen = sum_of_chosen + scaled[trial]
        level += now
    return sorted(chosen)

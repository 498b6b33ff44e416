"""Faults of measuring in a part of the trials: from one trial on, up to one, or at one frame rate.

A camera is set otherwise on the second day, a frame rate is typed in wrongly for some recordings.
For every part z (trials,) of 0 and 1 a step of Newton's in a cause's strengths b, which act there
alone, and in the numbers a of the model, which act everywhere, foretells what a fit would gain,

    1/2 g' H^-1 g,   g = (sum_i g_i^a, sum_i z_i g_i^b),

from each trial's own normal equations.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..fitting import Free, Normal, Series, normal_equations, pseudo_inverse
from ..integrate import Kernel
from ..study import Study
from .bench import Bench
from .judge import Trialled, candidate_frees
from .select import Choice

FLAG = "in_part"
CAUSES = (
    "clock_error", "keypoint_bias", "lens_error", "scale_error", "uncorrected_refraction",
)  # fmt: skip
"""The faults that heed the flag."""
FEWEST = 3
"""Trials that a part, and what is left, have at least."""
LEAST, LEAST_GAIN = 4.0, 10.0
"""Log likelihood over the inflation that a cause must be foretold in a part of the trials beyond
what any is foretold in all, and that the trials left out gain where it is sought there.
"""


@dataclass(frozen=True)
class Part:
    """Trials in which a cause seems to act, and by how much it is foretold more than in all of
    them, in log likelihood over the inflation.
    """

    cause: str
    trials: tuple[str, ...]
    ahead: float


def parts_of(study: Study, series: Sequence[Series]) -> Iterator[frozenset[str]]:
    """The parts that are tried, as names of trials of the study; each also as what it leaves."""
    order = [t.trial_id for t in study.trials]
    rates = {t.trial_id: t.fps for t in study.trials}
    ends = [frozenset(order[:k]) for k in range(1, len(order))]
    same = [frozenset(n for n in order if rates[n] == rate) for rate in {*rates.values()}]
    have = {s.name for s in series}
    seen: set[frozenset[str]] = set()
    for one in (*same, *ends):
        for part in (one, frozenset(order) - one):
            inside = part & have
            if min(len(inside), len(have - inside)) >= FEWEST and inside not in seen:
                seen.add(inside)
                yield part


def part_of_trials(bench: Bench, study: Study, model: Trialled) -> Part | None:
    """The part of the trials in which a cause is foretold clearly more than any is in all."""
    causes = [c for c in CAUSES if c in bench.candidates and c not in model.effects]
    frees = {c: _strengths(bench.kernel, c) for c in causes}
    every = [*model.fit.free, *(f for c in causes for f in frees[c])]
    values = np.concatenate([model.fit.values, np.zeros(len(every) - len(model.fit.free))])
    normal = normal_equations(bench.kernel, bench.series, bench.base, every, values,
                              noise=model.noise)  # fmt: skip
    if not normal.usable:
        return None
    own, at = np.arange(len(model.fit.free)), len(model.fit.free)
    columns = {}
    for c in causes:
        columns[c] = np.arange(at, at + len(frees[c]))
        at += len(frees[c])
    names = [s.name for s in bench.series]
    whole = max(_gain(normal, own, columns[c], np.ones(len(names))) for c in causes)
    told = [(_gain(normal, own, columns[c], np.array([float(n in part) for n in names])), c, part)
            for part in parts_of(study, bench.series) for c in causes]  # fmt: skip
    if not told:
        return None
    gain, cause, part = max(told, key=lambda one: one[0])
    ahead = (gain - whole) / model.inflation
    return Part(cause, tuple(t.trial_id for t in study.trials if t.trial_id in part), ahead)


def with_part(kernel: Kernel, series: Sequence[Series], part: Part) -> list[Series]:
    """The trials, those outside the part told that no fault of measuring acts in them. What side
    measurements say there is left away with it.
    """
    slot, out = kernel.system.constants.index(FLAG), []
    for one in series:
        inside = one.name in part.trials
        constants = one.constants.copy()
        constants[slot] = float(inside)
        out.append(replace(one, constants=constants, evidence=one.evidence if inside else {}))
    return out


def _strengths(kernel: Kernel, cause: str) -> list[Free]:
    frees, count = candidate_frees(kernel.system, cause)
    return list(frees[:count])


def _gain(normal: Normal, own: np.ndarray, new: np.ndarray, inside: Float) -> float:
    """Log likelihood that a step in the model's numbers and those of a cause foretells, over what
    one in the model's alone does.
    """
    g = np.concatenate([normal.gradient[:, own].sum(axis=0), inside @ normal.gradient[:, new]])
    H = normal.hessian
    aa = H[:, own[:, None], own].sum(axis=0)
    ab = np.einsum("t,tij->ij", inside, H[:, own[:, None], new])
    bb = np.einsum("t,tij->ij", inside, H[:, new[:, None], new])
    both = np.block([[aa, ab], [ab.T, bb]])
    alone = g[: len(own)]
    return 0.5 * float(g @ pseudo_inverse(both) @ g - alone @ pseudo_inverse(aa) @ alone)


def pays_in_part(whole: Choice, apart: Choice) -> bool:
    """Whether a search in which the faults of measuring act in a part of the trials found one of
    them, and explains the trials better than one in which they act in all.
    """
    inflation = max(whole.chosen.inflation, apart.chosen.inflation)
    gain = (apart.chosen.total - whole.chosen.total) / inflation
    return bool({*apart.chosen.effects} & {*CAUSES}) and gain > LEAST_GAIN

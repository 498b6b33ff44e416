"""Faults of measuring in a part of the trials: from one trial on, up to one, or at one frame rate.

A camera is set otherwise on the second day, a frame rate is typed in wrongly for some recordings.
For every part z (trials,) of 0 and 1 a step of Newton's in a cause's strengths b, which act there
alone, and in the numbers a of the model, which act everywhere, foretells what a fit would gain,

    1/2 g' H^-1 g,   g = (sum_i g_i^a, sum_i z_i g_i^b),

from each trial's own normal equations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..fitting import Free, Normal, Series, normal_equations, pseudo_inverse
from ..integrate import Kernel
from ..study import Study
from .bench import Bench
from .judge import Trialled, candidate_frees
from .select import Choice
from .setting import PART_FLAG, PARTIAL

FEWEST = 3
"""Trials that a part, and what is left, have at least."""
OWN_EVIDENCE = frozenset({"clock_ratio"})
"""Side measurements that each trial has for itself; what rigid lengths say is pooled over all."""
LEAST, LEAST_GAIN = 4.0, 10.0
"""Log likelihood over the inflation that a cause must be foretold in a part of the trials beyond
what any is foretold in all, and that the trials left out gain where it is sought there.
"""


@dataclass(frozen=True)
class Part:
    """Trials in which a cause seems to act, and by how much it is foretold more than in all of
    them, in log likelihood over the inflation; open: trials not fitted on which the trials that
    are leave it open whether they belong to it.
    """

    cause: str
    trials: tuple[str, ...]
    ahead: float
    open: tuple[str, ...] = ()


def parts_of(
    study: Study, series: Sequence[Series]
) -> dict[frozenset[str], tuple[frozenset[str], frozenset[str]]]:
    """The parts that are tried: the trials of `series` in each -> the study's trials that belong
    to it, and those that may or may not.
    """
    order = [t.trial_id for t in study.trials]
    rates = {t.trial_id: t.fps for t in study.trials}
    ends = [frozenset(order[:k]) for k in range(1, len(order))]
    same = [frozenset(n for n in order if rates[n] == rate) for rate in {*rates.values()}]
    have = {s.name for s in series}
    found: dict[frozenset[str], list[frozenset[str]]] = {}
    for one in (*same, *ends):
        for part in (one, frozenset(order) - one):
            inside = part & have
            if min(len(inside), len(have - inside)) >= FEWEST:
                found.setdefault(inside, []).append(part)
    sure = {inside: frozenset.intersection(*every) for inside, every in found.items()}
    return {i: (sure[i], frozenset.union(*every) - sure[i]) for i, every in found.items()}


def part_of_trials(bench: Bench, study: Study, model: Trialled) -> Part | None:
    """The part of the trials in which a cause is foretold clearly more than any is in all: one that
    the model has not, or one that it has in all trials.
    """
    causes = [c for c in PARTIAL if c in bench.candidates]
    every, columns = list(model.fit.free), {}
    for c in causes:
        labels = [f.label for f in every]
        strengths = _strengths(bench.kernel, c)
        every += [f for f in strengths if f.label not in labels]
        labels = [f.label for f in every]
        columns[c] = np.array([labels.index(f.label) for f in strengths])
    values = np.concatenate([model.fit.values, np.zeros(len(every) - len(model.fit.free))])
    normal = normal_equations(bench.kernel, bench.series, bench.base, every, values,
                              noise=model.noise)  # fmt: skip
    parts = parts_of(study, bench.series)
    if not normal.usable or not parts:
        return None
    own, names = np.arange(len(model.fit.free)), [s.name for s in bench.series]
    whole = max(_gain(normal, own, columns[c], np.ones(len(names))) for c in causes)
    flags = {inside: np.array([float(n in inside) for n in names]) for inside in parts}
    told = [(_gain(normal, own, columns[c], flags[inside]), c, inside)
            for inside in parts for c in causes]  # fmt: skip
    gain, cause, inside = max(told, key=lambda one: one[0])
    sure, doubtful = parts[inside]
    ordered = [t.trial_id for t in study.trials]
    return Part(cause, tuple(n for n in ordered if n in sure), (gain - whole) / model.inflation,
                tuple(n for n in ordered if n in doubtful))  # fmt: skip


def with_part(kernel: Kernel, series: Sequence[Series], part: Part) -> list[Series]:
    """The trials, those outside the part told that no fault of measuring acts in them.

    What side measurements say there is left away with it, and everywhere what is pooled over all
    trials, which holds in neither part.
    """
    slot, out = kernel.system.constants.index(PART_FLAG), []
    for one in series:
        inside = one.name in part.trials
        constants = one.constants.copy()
        constants[slot] = float(inside)
        evidence = {k: v for k, v in one.evidence.items() if inside and k in OWN_EVIDENCE}
        out.append(replace(one, constants=constants, evidence=evidence))
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
    them, and explains the paths better than one in which they act in all: side measurements are
    not the same for both.
    """
    inflation = max(whole.chosen.inflation, apart.chosen.inflation)
    by_paths = [one.chosen.total - one.chosen.side for one in (apart, whole)]
    gain = (by_paths[0] - by_paths[1]) / inflation
    return bool({*apart.chosen.effects} & {*PARTIAL}) and gain > LEAST_GAIN

"""Input of the finder: a system, its trials, its candidate causes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from ..data import Float
from ..fitting import FilterResults, FreeParameter, Noise, TrialSeries, trial_parameter_vector
from ..integrate import CompiledSystem
from .candidates import CandidateCause

MAX_SEARCH_TRIALS = 24
"""A search uses at most so many trials, those that say most; what it finds is verified on all. The
noise too is estimated on at most so many. As many as the studies have on which the finder is
validated (FINDER, protocol); `benchmarks/search_subset.py` compares with a search on all trials."""

ProgressCallback = Callable[[str], None]
BaselineCheck = Callable[[Noise, FilterResults], None]


def no_progress(_: str) -> None:
    """Progress that nobody follows."""


def accept_any_baseline(_: Noise, __: FilterResults) -> None:
    """A check that any fit of the model without causes passes."""


@dataclass(frozen=True)
class CauseSearchProblem:
    """Trials to fit and candidates to judge.

    base (parameters,): values of what is not fitted. coefficients: the model's own numbers. noise:
    where estimates of the random part begin. tolerances: strength of a candidate -> standard
    deviation to which a careful laboratory makes it 0; integrated out where it is not a cause.
    most_causes: how many a set may have. collinear_terms: residual terms that are collinear
    with a listed cause; they belong to discrepancies, but are no candidates of their own.
    state_variables: variables of residual terms that follow from the system's state and inputs; a
    law whose formula is not quite right leaves, in its own channels, a force that depends on these.
    check_baseline: called with the noise and the filtered trials of the model without causes,
    before any cause is fitted; an error that it raises ends the search.
    """

    kernel: CompiledSystem
    series: Sequence[TrialSeries]
    base: Float
    coefficients: tuple[FreeParameter, ...]
    candidates: tuple[CandidateCause, ...]
    noise: Noise
    tolerances: Mapping[str, float] = field(default_factory=dict)
    residual_sizes: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    state_variables: frozenset[str] = frozenset()
    progress: ProgressCallback = field(default=no_progress)
    most_causes: int = 4
    collinear_terms: frozenset[str] = frozenset()
    check_baseline: BaselineCheck = accept_any_baseline

    @cached_property
    def candidate_by_name(self) -> dict[str, CandidateCause]:
        """Candidates by name."""
        return {c.name: c for c in self.candidates}

    def cause_covers_residual_term(self, cause: CandidateCause, term: CandidateCause) -> bool:
        """Whether a residual term may stem from the formula of a cause: the same channel and
        variable, or the same channel and both depend on the state.
        """
        if cause.is_residual or not term.is_residual:
            return False
        if cause.sources & term.sources:
            return True
        own = {c for c, v in cause.sources if v in self.state_variables}
        return any(c in own and v in self.state_variables for c, v in term.sources)

    def trial_parameter_vectors(self, free: Sequence[FreeParameter], values: Float) -> list[Float]:
        """Full parameter vectors, one a trial."""
        return [
            trial_parameter_vector(self.kernel, self.base, free, values, s.group)
            for s in self.series
        ]

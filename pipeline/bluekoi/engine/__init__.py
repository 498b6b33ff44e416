"""The finder for any dynamic model: which causes did it leave out, with which probability.

candidates  what may be added, and what is known of it before any data
problem     a system, its trials, its candidates
refit       nonlinear fits of a set of causes with its own noise
expansion   second-order expansion of the likelihood in the numbers of all candidates
columns     numbers of a set in an expansion, and their priors
forces      forces of a set's causes and of residual terms along the trials
evidence    marginal likelihood of a set of causes
scored      log posterior of a fitted set, its discrepancy integrated out
search      which sets are worth a fit
posterior   probabilities of sets and causes, averaged over samples of trials
naming      what is named, and what may act in its place
"""

from .candidates import Candidate, Priors, candidates_of
from .expansion import Expansion, expanded
from .naming import Named, best_set, named_causes
from .posterior import Posterior, posterior
from .problem import Problem
from .refit import FittedSet, fitted, own_noise, unconstrained, without_discrepancy
from .scored import Scored
from .search import Visited, search

__all__ = [
    "Candidate",
    "Expansion",
    "FittedSet",
    "Named",
    "Posterior",
    "Priors",
    "Problem",
    "Scored",
    "Visited",
    "best_set",
    "candidates_of",
    "expanded",
    "fitted",
    "named_causes",
    "own_noise",
    "posterior",
    "search",
    "unconstrained",
    "without_discrepancy",
]

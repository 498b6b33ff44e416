"""The finder for any dynamic model: which causes did it leave out, with which probability.

candidates  what may be added, and what is known of it before any data
problem     a system, its trials, its candidates
refit       nonlinear fits of a set of causes, with all its functional forms
own_noise   fits of a set under its own noise
expansion   second-order expansion of the likelihood in the numbers of all candidates
collinear_terms residual terms that are collinear with a listed cause
set_columns numbers of a set in an expansion, and their priors
forces      forces of a set's causes and of residual terms along the trials
evidence    marginal likelihood of a set of causes
set_score   log posterior of a fitted set, its discrepancy integrated out
search      which sets are worth a fit
posterior   probabilities of sets and causes, averaged over samples of trials
calibration stated probabilities, by how often verdicts were right
naming      what is named, and what may act in its place
significance  whether the trials agree that a named cause acts
"""

from .candidates import CandidateCause, PriorInclusionProbabilities, candidates_from_effects
from .cause_selection import choose_causes, most_probable_set_with_causes, named_causes
from .cause_set_fit import FittedCauseSet, fit_cause_set, off_bounds_mask
from .expansion import LikelihoodExpansion, expand_likelihood
from .fitted_sets import FitRequest, FittedCauseSets
from .named_cause import NamedCause
from .noise_estimation import fit_noise_and_parameters, refit_without_discrepancy
from .posterior import Posterior, posterior_over_sets
from .problem import CauseSearchProblem
from .search import search_cause_sets
from .set_score import ScoredCauseSet
from .significance import insignificance_sentence, insignificant_causes, strength_estimates

__all__ = [
    "CandidateCause",
    "CauseSearchProblem",
    "FitRequest",
    "FittedCauseSet",
    "FittedCauseSets",
    "LikelihoodExpansion",
    "NamedCause",
    "Posterior",
    "PriorInclusionProbabilities",
    "ScoredCauseSet",
    "candidates_from_effects",
    "choose_causes",
    "expand_likelihood",
    "fit_cause_set",
    "fit_noise_and_parameters",
    "insignificance_sentence",
    "insignificant_causes",
    "most_probable_set_with_causes",
    "named_causes",
    "off_bounds_mask",
    "posterior_over_sets",
    "refit_without_discrepancy",
    "search_cause_sets",
    "strength_estimates",
]

"""Causes of several strengths as mixtures over the strengths that act."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from math import comb

import numpy as np
import pytest
from scipy.special import logsumexp

from bluekoi.engine.evidence import laplace_log_evidence
from bluekoi.engine.set_columns import CauseSetColumns
from bluekoi.engine.strength_subsets import log_mean_over_strength_subsets

SIZES = np.array([1.0, 2.0, 0.5])


def _layout(at: np.ndarray, sizes: np.ndarray, tolerance: np.ndarray) -> CauseSetColumns:
    """A set of one cause with these strengths and nothing else."""
    k = len(sizes)
    off = np.zeros(k, dtype=bool)
    return CauseSetColumns(
        columns=np.arange(k), count=0, blocks={"cause": np.arange(k)}, precision=sizes**-2.0,
        gaussian=off, included=off, signed={"cause": False}, at=at, held=off,
        sizes={"cause": sizes}, tolerance=tolerance,
    )  # fmt: skip


def _information(rng: np.random.Generator) -> np.ndarray:
    J = rng.normal(size=(40, 3)) * [10.0, 5.0, 20.0]
    return np.asarray(J.T @ J)


@pytest.mark.parametrize("seed", range(4))
def test_the_mean_is_that_of_the_evidences_of_all_subsets(seed: int) -> None:
    """Of a quadratic likelihood: about the fit, and each subset expanded about 0."""
    rng = np.random.default_rng(seed)
    H, fit = _information(rng), rng.normal(size=3) * [0.3, 0.0, 0.02]
    lay = _layout(fit, SIZES, np.zeros(3))
    at_fit = laplace_log_evidence(H, np.zeros(3), lay)
    found = at_fit + log_mean_over_strength_subsets(H, np.zeros(3), lay, laplace_log_evidence)
    g = H @ fit  # about 0, where the log likelihood is lower by fit' H fit / 2
    terms = []
    for n in (1, 2, 3):
        for own in map(list, combinations(range(3), n)):
            part = _layout(np.zeros(n), SIZES[own], np.zeros(n))
            value = laplace_log_evidence(H[np.ix_(own, own)], g[own], part)
            terms.append(value - 0.5 * fit @ g - np.log(3 * comb(3, n)))
    assert found == pytest.approx(logsumexp(terms), abs=1e-3)


def test_a_cause_of_one_acting_strength_has_more_evidence_than_with_all() -> None:
    """By the Occam factors of the others, less the prior probability of the subset, 1/9."""
    H = np.diag([1e4, 1e4, 1e4])
    one = _layout(np.array([0.2, 0.0, 0.0]), SIZES, np.zeros(3))
    every = _layout(np.array([0.2, 0.2, 0.2]), SIZES, np.zeros(3))
    gains = [log_mean_over_strength_subsets(H, np.zeros(3), lay, laplace_log_evidence)
             for lay in (one, every)]  # fmt: skip
    assert gains[0] > 3.0
    assert gains[1] == pytest.approx(-np.log(3), abs=0.01)


def test_a_strength_that_does_not_act_is_0_within_its_tolerance() -> None:
    """An offset of two tolerances that the data show leaves the subset without it possible."""
    H, zero = np.diag([1e4, 1e6, 1e4]), np.zeros(3)
    fit = np.array([0.2, 0.02, 0.0])
    exact = _layout(fit, SIZES, zero)
    within = replace(exact, tolerance=np.array([0.0, 0.01, 0.0]))
    found = [log_mean_over_strength_subsets(H, zero, lay, laplace_log_evidence)
             for lay in (exact, within)]  # fmt: skip
    assert found[1] > found[0] + 1.0


def test_a_cause_of_one_strength_is_as_before() -> None:
    lay = _layout(np.array([0.3]), SIZES[:1], np.zeros(1))
    assert log_mean_over_strength_subsets(np.eye(1), np.zeros(1), lay, laplace_log_evidence) == 0.0

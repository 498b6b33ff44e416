"""Size of a discrepancy: what known columns cannot represent of others."""

import numpy as np
import pytest

from validation.discrepancy import discrepancy_report, residual_sum_of_squares, weighted_quantiles


def test_remainder_is_the_square_of_the_residual_of_a_regression() -> None:
    columns = np.random.default_rng(3).standard_normal((50, 6))
    products = columns.T @ columns
    known, others = [0, 2, 3], [1, 5]
    fit = np.linalg.lstsq(columns[:, known], columns[:, others], rcond=None)[0]
    left = columns[:, others] - columns[:, known] @ fit
    assert residual_sum_of_squares(products, known, others) == pytest.approx(
        (left**2).sum(axis=0), rel=1e-6
    )


def test_what_is_known_leaves_nothing() -> None:
    columns = np.random.default_rng(4).standard_normal((50, 3))
    columns = np.column_stack([columns, columns @ [1.0, -2.0, 0.5]])
    left = residual_sum_of_squares(columns.T @ columns, [0, 1, 2], [3])
    assert left[0] < 1e-6 * (columns[:, 3] ** 2).sum()


def test_report_states_the_root_mean_square_of_each_cause() -> None:
    text = discrepancy_report({"stall": [0.01, 0.03], "added_mass": [0.04]})
    assert "stall                        0.141  (2 forms)" in text
    assert "median: 0.171" in text


def test_quantiles_count_each_cause_once() -> None:
    values = {"stall": [0.01, 0.04, 0.09, 0.16], "added_mass": [1.0]}
    assert weighted_quantiles(values, (0.1, 0.45, 0.9)) == pytest.approx([0.1, 0.4, 1.0])

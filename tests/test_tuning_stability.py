"""What is said of straight swimming, and what is not."""

from __future__ import annotations

import numpy as np
import pytest

from bluekoi.model import TABLE_1
from bluekoi.tuning.stability import stability_verdict, straight_swimming_growth_per_s
from paper_robot import PAPER_SETUP


def test_a_growth_that_all_draws_share_is_asserted_with_its_range() -> None:
    reported = stability_verdict(3.6, np.linspace(2.0, 5.0, 61).tolist())
    assert reported["stable"] is False
    assert reported["interval_95"] == pytest.approx([2.0, 5.0], abs=0.1)
    assert "does not swim straight" in reported["sentence"]
    assert "+2.1 to +4.9" in reported["sentence"]


def test_a_growth_that_fades_in_all_draws_swims_straight() -> None:
    reported = stability_verdict(-1.0, [-2.0, -1.5, -0.5])
    assert reported["stable"] is True
    assert "The fitted model swims straight" in reported["sentence"]


@pytest.mark.parametrize("draws", [np.linspace(-3.0, 6.0, 61).tolist(), [1.0] * 50 + [np.nan] * 10])
def test_nothing_is_asserted_where_the_draws_hold_both_answers_or_many_have_none(
    draws: list[float],
) -> None:
    reported = stability_verdict(3.6, draws)
    assert reported["stable"] is None
    assert "not determined by these trials" in reported["sentence"]


def test_without_draws_the_fit_itself_speaks() -> None:
    assert stability_verdict(0.0)["stable"] is True
    assert stability_verdict(3.6)["interval_95"] is None


def test_coefficients_that_run_away_have_no_eigenvalue() -> None:
    wild = TABLE_1[100] | {"C_D0": -5.0, "C_T": 0.2}
    assert np.isnan(straight_swimming_growth_per_s(wild, setup=PAPER_SETUP, flap_hz=5.8))

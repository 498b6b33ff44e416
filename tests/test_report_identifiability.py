"""Identifiability in the report: spectrum, profile likelihoods, intervals."""

from __future__ import annotations

import exact_campaign as exact
import numpy as np
import pytest

from bluekoi.report import identifiability, tables
from bluekoi.report.page import report_html


@pytest.fixture
def campaign():
    given = exact.coefficients_json()
    cell = given["joint"]["coefficients"]["C_T"]
    best = cell["value"]
    cell |= {"interval_95": [0.9 * best, 1.1 * best], "naive_std": 0.01 * best}
    given["joint"]["identifiability"] = {
        "spectrum": [
            {"combination": "+1.00 dC_Da/C_Da", "relative_std": None, "determined": False},
            {"combination": "+0.70 dC_T/C_T", "relative_std": 0.021, "determined": True},
        ],
        "profiles": {"C_T": {"values": [1.1 * best, 0.9 * best], "lost": [3.0, 6.0],
                             "lower": 0.95 * best, "upper": None}},
    }  # fmt: skip
    return exact.exact_campaign(coefficients=given)


def test_spectrum_marks_what_is_not_determined(campaign) -> None:
    first, second = identifiability.fisher_spectrum(campaign)
    assert first.marked
    assert first.cells == ("unbounded", "no")
    assert not second.marked
    assert second.cells == ("2.1 %", "yes")


def test_combinations_read_as_products_of_powers() -> None:
    """A direction of relative changes is the gradient of the log of a product of powers."""
    assert identifiability.as_power_product("-0.97 dC_Ma/C_Ma") == "C_Ma"
    both = identifiability.as_power_product("-0.58 dC_T/C_T +0.37 dC_Da/C_Da")
    assert both == "C_T^0.58 · C_Da^−0.37"
    assert identifiability.as_power_product("something else") == "something else"


def test_profile_is_drawn_from_left_to_right_through_the_fit(campaign) -> None:
    (one,) = identifiability.likelihood_profile_curves(campaign)
    points = one.points.split()
    assert points[0] == "0.0,0.0"
    assert "50.0,60.0" in points
    assert points[-1] == "100.0,30.0"
    x = [float(point.split(",")[0]) for point in points]
    assert x == sorted(x)
    assert one.value_x == pytest.approx(50.0)
    assert one.limit_y == pytest.approx(60 * (1 - 1.92 / 6))
    assert "no upper end" in one.interval


def test_a_drawn_profile_is_a_smooth_curve_with_the_fit_at_its_bottom(campaign) -> None:
    joint = campaign.coefficients["joint"]
    best = joint["coefficients"]["C_T"]["value"]
    values = [best * (1 + 0.1 * k) for k in (-2, -1, 1, 2)]
    lost = [4.0, 1.0, 1.0, 4.0]
    joint["identifiability"]["profiles"] = {
        "C_T": {"values": values, "lost": lost, "lower": None, "upper": None}
    }
    (one,) = identifiability.likelihood_profile_curves(campaign)
    x, y = np.array([p.split(",") for p in one.points.split()], dtype=float).T
    down = identifiability.CURVE_HEIGHT * (
        1 - 4.0 * ((x - one.value_x) / (one.value_x)) ** 2 / identifiability.MAX_DROP_SHOWN
    )
    assert y == pytest.approx(down, abs=0.5)
    assert len(x) > 30
    assert one.limit_y < y.max()  # what lies below the line is inside the interval


def test_joint_table_has_the_interval_over_trials_and_the_naive_one(campaign) -> None:
    row = tables.joint_fit_rows(campaign)[0]
    assert row.cells[0] == "0.00450 ± 0.00045"
    assert row.cells[1] == "8.8 × 10⁻⁵"


def test_page_shows_both_and_does_without(campaign) -> None:
    text = report_html(campaign, [], {})
    assert "Profile likelihood of C_T" in text
    assert "unbounded" in text
    assert "Profile likelihood of" not in report_html(exact.exact_campaign(), [], {})

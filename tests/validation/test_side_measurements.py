"""What the constants of drifting trials and of rigid lengths rest on."""

from __future__ import annotations

from validation.drift_detection import detection_rate_report as drift_report
from validation.rigid_length_misfit import length_misfit_report as lengths_report


def test_rates_of_reported_drifts_are_counted_over_studies() -> None:
    text = drift_report([(False, True), (True, True), (False, False)])
    assert "without a drift: 1 of 3" in text
    assert "with 8.5 cm in one trial: 2 of 3" in text


def test_studies_with_a_stretched_picture_do_not_count_as_right_geometry() -> None:
    text = lengths_report([("a", False, 8.0, 8), ("b", False, 4.0, 8), ("c", True, 300.0, 9)])
    assert text.splitlines()[0] == "c: 300.0 of 9"
    assert "others, 2 studies: mean 0.75, median 0.75, largest 1.0" in text

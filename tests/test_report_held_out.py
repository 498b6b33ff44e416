"""The text follows the evaluation: on held-out trials, or on fitted ones in a small study."""

from __future__ import annotations

import pytest
from exact_campaign import campaign_with_damping_found, exact_campaign

from bluekoi import figures
from bluekoi.campaign import Campaign
from bluekoi.data import Float
from bluekoi.figures.drawing.style import (
    BASELINE_MODEL_LABEL,
    EXTENDED_MODEL_LABEL,
    NOISE_FLOOR_LABEL,
)
from bluekoi.report.page import report_html


@pytest.fixture
def held_out_campaign() -> Campaign:
    return campaign_with_damping_found(exact_campaign(powers=(75,)))


@pytest.fixture
def small_campaign(held_out_campaign: Campaign) -> Campaign:
    """The same, but the search was evaluated on all of its trials."""
    every = [t.trial_id for t in held_out_campaign.analysed]
    mismatch = {
        **held_out_campaign.mismatch,
        "held_out": {**held_out_campaign.mismatch["held_out"], "trials": every},
    }
    return Campaign(**{**held_out_campaign.__dict__, "mismatch": mismatch})


def test_held_out_trials_are_named(held_out_campaign: Campaign) -> None:
    text = report_html(held_out_campaign, [], {})
    assert "<h3>Errors on held-out trials</h3>" in text
    assert "Held out: T02." in text
    assert text.count('<span class="tag">held out</span>') == 2
    assert "Trials that no fit used." in figures.figure_caption(
        "mismatch_held_out", held_out_campaign
    )


def test_a_small_study_reports_no_trial_as_held_out(small_campaign: Campaign) -> None:
    text = report_html(small_campaign, [], {})
    assert "<h3>Errors on the fitted trials</h3>" in text
    assert "No trial was held out" in text
    assert "path error on the fitted trials" in text
    assert "Held out:" not in text
    assert "held-out trials" not in text
    assert '<span class="tag">held out</span>' not in text


def test_the_figure_states_which_trials_it_shows(small_campaign: Campaign, tmp_path) -> None:
    name = "mismatch_held_out"
    assert (
        figures.figure_title(name, small_campaign)
        == "Fitted trials: errors of the model before and after"
    )
    assert "no fit used" not in figures.figure_caption(name, small_campaign)
    assert "too small to hold trials out" in figures.figure_caption(name, small_campaign)
    assert "(A) Errors of the baseline model (before, orange)" in figures.figure_caption(
        name, small_campaign
    )
    figures.write_figure_files(name, small_campaign, tmp_path / "a.png", tmp_path / "a.pdf")
    assert b"too small to hold trials out" in (tmp_path / "a.png").read_bytes()


def test_without_an_identified_cause_there_is_one_model(held_out_campaign: Campaign) -> None:
    mismatch = {**held_out_campaign.mismatch, "verdict": "none", "causes": []}
    held_out_campaign = Campaign(
        **{**held_out_campaign.__dict__, "simulations": with_models_as_measured(held_out_campaign)}
    )
    none = Campaign(**{**held_out_campaign.__dict__, "mismatch": mismatch})
    assert figures.figure_title("mismatch_held_out", none) == "Held-out trials: errors of the model"
    assert "Trials that no fit used. No cause was identified" in figures.figure_caption(
        "mismatch_held_out", none
    )
    assert legend_texts("mismatch_held_out", held_out_campaign) == [
        "measured", BASELINE_MODEL_LABEL, EXTENDED_MODEL_LABEL, NOISE_FLOOR_LABEL,
    ]  # fmt: skip
    assert legend_texts("mismatch_held_out", none) == ["measured", "model", NOISE_FLOOR_LABEL]
    assert "named" in legend_texts("mismatch_candidates", held_out_campaign)
    assert "named" not in legend_texts("mismatch_candidates", none)
    assert len(legend_texts("paths", held_out_campaign)) == 3
    assert legend_texts("paths", none) == ["measured", "model"]
    assert 'class="after"' in report_html(held_out_campaign, [], {})
    text = report_html(none, [], {})
    assert 'class="after"' not in text
    assert "before and after" not in text
    assert "baseline model" not in text
    assert "path error of baseline" not in text
    row = text[text.index("path, rms (mm)") :]
    assert row[: row.index("</tr>")].count("<td") == 2  # the model and the floor


def with_models_as_measured(campaign: Campaign) -> dict[str, dict[str, Float]]:
    """Model paths, both as measured."""
    return {
        name: {"time_s": track.time_s}
        | {f"{k}_x_m": track.x_m for k in ("joint", "extended")}
        | {f"{k}_y_m": track.y_m for k in ("joint", "extended")}
        for name, track in campaign.tracks.items()
    }


def legend_texts(name: str, campaign: Campaign) -> list[str]:
    return [text.get_text() for text in figures.draw(name, campaign).legends[0].get_texts()]


def test_trials_that_the_tuning_could_not_use_are_not_counted(small_campaign: Campaign) -> None:
    """All fitted trials are evaluated, and one analysed trial was not fitted."""
    fitted = [t.trial_id for t in small_campaign.analysed][1:]
    mismatch = {
        **small_campaign.mismatch,
        "held_out": {**small_campaign.mismatch["held_out"], "trials": fitted},
    }
    coefficients = {**small_campaign.coefficients}
    coefficients["joint"] = {**coefficients["joint"], "trials": fitted}
    one = Campaign(
        **{**small_campaign.__dict__, "mismatch": mismatch, "coefficients": coefficients}
    )
    assert "No trial was held out" in report_html(one, [], {})

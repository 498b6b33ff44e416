"""Words follow what was done: held out, or, in a study too small for it, fitted as well."""

from __future__ import annotations

import pytest
from exact_campaign import campaign, searched

from pipeline import figures
from pipeline.campaign import Campaign
from pipeline.data import Float
from pipeline.report.page import page


@pytest.fixture
def spared() -> Campaign:
    return searched(campaign(powers=(75,)))


@pytest.fixture
def small(spared: Campaign) -> Campaign:
    """The same, but the search was judged on all of its trials."""
    every = [t.trial_id for t in spared.analysed]
    mismatch = {**spared.mismatch, "held_out": {**spared.mismatch["held_out"], "trials": every}}
    return Campaign(**{**spared.__dict__, "mismatch": mismatch})


def test_a_page_with_trials_held_out_says_so(spared: Campaign) -> None:
    text = page(spared, [], {})
    assert "Does it help where it was not fitted?" in text
    assert "Errors on held-out trials" in text
    assert "Held out: T02." in text
    assert text.count('<span class="tag">held out</span>') == 2
    assert "Trials that no fit saw." in figures.caption("mismatch_held_out", spared)


def test_a_page_of_a_study_too_small_calls_no_trial_held_out(small: Campaign) -> None:
    text = page(small, [], {})
    assert "Does it help where it was fitted?" in text
    assert "No trial was held out" in text
    assert "path error on the fitted trials" in text
    assert "Held out:" not in text
    assert "held-out trials" not in text
    assert '<span class="tag">held out</span>' not in text


def test_the_figure_says_which_trials_it_shows(small: Campaign, tmp_path) -> None:
    name = "mismatch_held_out"
    assert figures.title(name, small) == "The fitted trials, before and after"
    assert "no fit saw" not in figures.caption(name, small)
    assert "too small to hold trials out" in figures.caption(name, small)
    assert "(A) Errors of the model before" in figures.caption(name, small)
    figures.draw_file(name, small, tmp_path / "a.png", tmp_path / "a.pdf")
    assert b"too small to hold trials out" in (tmp_path / "a.png").read_bytes()


def test_where_nothing_was_put_in_there_is_one_model(spared: Campaign) -> None:
    mismatch = {**spared.mismatch, "verdict": "none", "causes": []}
    spared = Campaign(**{**spared.__dict__, "simulations": as_measured(spared)})
    none = Campaign(**{**spared.__dict__, "mismatch": mismatch})
    assert figures.title("mismatch_held_out", none) == "Held-out trials and the model"
    assert "Trials that no fit saw. Nothing was put" in figures.caption("mismatch_held_out", none)
    assert legend("mismatch_held_out", spared) == ["measured", "before", "after"]
    assert legend("mismatch_held_out", none) == ["measured", "model"]
    assert "chosen" in legend("mismatch_candidates", spared)
    assert "chosen" not in legend("mismatch_candidates", none)
    assert len(legend("paths", spared)) == 3
    assert legend("paths", none) == ["measured", "model, one coefficient set"]
    assert 'class="after"' in page(spared, [], {})
    text = page(none, [], {})
    assert 'class="after"' not in text
    assert "before and after" not in text
    assert "model before" not in text
    assert "path error before" not in text
    assert "How large are the errors where it was not fitted?" in text
    row = text[text.index("path, rms (mm)") :]
    assert row[: row.index("</tr>")].count("<td") == 2  # the model and the floor


def as_measured(campaign: Campaign) -> dict[str, dict[str, Float]]:
    """Model paths, both as measured."""
    return {
        name: {"time_s": track.time_s}
        | {f"{k}_x_m": track.x_m for k in ("joint", "extended")}
        | {f"{k}_y_m": track.y_m for k in ("joint", "extended")}
        for name, track in campaign.tracks.items()
    }


def legend(name: str, campaign: Campaign) -> list[str]:
    return [text.get_text() for text in figures.draw(name, campaign).legends[0].get_texts()]


def test_trials_that_the_tuning_could_not_use_do_not_count(small: Campaign) -> None:
    """All that were fitted are judged on, though one of those analysed was not fitted."""
    fitted = [t.trial_id for t in small.analysed][1:]
    mismatch = {**small.mismatch, "held_out": {**small.mismatch["held_out"], "trials": fitted}}
    coefficients = {**small.coefficients}
    coefficients["joint"] = {**coefficients["joint"], "trials": fitted}
    one = Campaign(**{**small.__dict__, "mismatch": mismatch, "coefficients": coefficients})
    assert "No trial was held out" in page(one, [], {})

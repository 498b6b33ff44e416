"""The report page: all parts rendered into the template."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from markupsafe import Markup

from ..campaign import Campaign
from ..files import write_text
from . import findings, held_out_errors, identifiability, tables
from .media import (
    EmbeddedFigure,
    OverlayClip,
    compressed_plotly_script,
    embedded_figures,
    embedded_overlay_clips,
)
from .settings import software_versions, study_settings
from .template import read_resource, render_template
from .trials import excluded_trials, trial_cards

JAVASCRIPT_FILES = ("charts.js", "explorer.js", "page.js")


def write_report(
    campaign: Campaign,
    figures: Mapping[str, tuple[str, str]],
    figures_dir: str | Path,
    overlays_dir: str | Path,
    path: str | Path,
) -> None:
    """Write report.html: a page that works offline, with all text escaped.

    figures: name -> (title, caption) of the png files in `figures_dir`. overlays_dir: ID.mp4,
    embedded up to a limit, otherwise loaded from the file.
    """
    beside = Path(path).parent
    shown = embedded_figures(figures, Path(figures_dir), beside)
    videos = embedded_overlay_clips(Path(overlays_dir), beside, campaign)
    write_text(path, report_html(campaign, shown, videos))


def report_html(
    campaign: Campaign, shown: Sequence[EmbeddedFigure], videos: Mapping[str, OverlayClip]
) -> str:
    """Text of the page."""
    return render_template(
        "page.html",
        name=campaign.study.root.name or "study",
        summary=findings.study_summary_sentence(campaign),
        verdict=findings.verdict_texts(campaign),
        warnings=findings.campaign_warnings(campaign),
        key_figures=findings.headline_values(campaign),
        causes=findings.cause_texts(campaign),
        where=findings.missing_force_dependence_rows(campaign),
        probabilities=findings.probability_table_rows(campaign),
        rivals=findings.rival_cause_texts(campaign),
        next_trial=findings.next_trial_sentence(campaign),
        held_out=held_out_errors.held_out_error_rows(campaign),
        held_out_text=held_out_errors.held_out_table_text(campaign),
        held_out_columns=held_out_errors.held_out_column_headings(campaign),
        with_additions=campaign.has_additions,
        shifts=tables.coefficient_changes(campaign),
        joint=tables.joint_fit_rows(campaign),
        joint_fit_notes=tables.joint_fit_notes(campaign),
        spectrum=identifiability.fisher_spectrum(campaign),
        profiles=identifiability.likelihood_profile_curves(campaign),
        table_1=tables.coefficients_per_power_table(campaign),
        table_2=tables.turn_radius_error_table(campaign),
        columns=tables.COEFFICIENT_COLUMNS,
        mismatch_figures=[one for one in shown if one.name.startswith("mismatch")],
        figures=[one for one in shown if not one.name.startswith("mismatch")],
        excluded=excluded_trials(campaign),
        cards=trial_cards(campaign, videos),
        settings=study_settings(campaign),
        versions=software_versions(),
        js=Markup('"use strict";\n' + "\n".join(map(read_resource, JAVASCRIPT_FILES))),  # noqa: S704  our own files
        plotly=compressed_plotly_script(),
        pool=campaign.study.setup.pool,
    )

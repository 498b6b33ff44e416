"""The report page: all parts rendered into the template."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from markupsafe import Markup

from ..campaign import Campaign
from ..files import write_text
from . import findings, held_out_errors, identifiability, tables
from .media import FigureDataUri, OverlayClip, embedded_overlay_clips, pictures, plotting_library
from .settings import software_versions, study_settings
from .template import load_template, read_resource
from .trials import excluded_trials, trial_cards

SCRIPTS = ("charts.js", "explorer.js", "page.js")


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
    shown = pictures(figures, Path(figures_dir), beside)
    videos = embedded_overlay_clips(Path(overlays_dir), beside, campaign)
    write_text(path, report_html(campaign, shown, videos))


def report_html(
    campaign: Campaign, shown: Sequence[FigureDataUri], videos: Mapping[str, OverlayClip]
) -> str:
    """Text of the page."""
    return load_template(
        "page.html",
        name=campaign.study.root.name or "study",
        summary=findings.study_summary_sentence(campaign),
        verdict=findings.verdict(campaign),
        warnings=findings.campaign_warnings(campaign),
        key_figures=findings.headline_values(campaign),
        causes=findings.cause_texts(campaign),
        where=findings.dependence_rows(campaign),
        probabilities=findings.probability_table_rows(campaign),
        rivals=findings.rival_cause_texts(campaign),
        next_trial=findings.next_trial_sentence(campaign),
        held_out=held_out_errors.error_rows(campaign),
        held_out_text=held_out_errors.held_out_table_text(campaign),
        held_out_columns=held_out_errors.column_headings(campaign),
        with_additions=campaign.has_additions,
        shifts=tables.coefficient_changes(campaign),
        joint=tables.joint_fit_rows(campaign),
        joint_fit_notes=tables.joint_fit_notes(campaign),
        spectrum=identifiability.fisher_spectrum(campaign),
        profiles=identifiability.likelihood_profile_curves(campaign),
        table_1=tables.table_1(campaign),
        table_2=tables.table_2(campaign),
        columns=tables.COEFFICIENT_COLUMNS,
        mismatch_figures=[one for one in shown if one.name.startswith("mismatch")],
        figures=[one for one in shown if not one.name.startswith("mismatch")],
        excluded=excluded_trials(campaign),
        cards=trial_cards(campaign, videos),
        settings=study_settings(campaign),
        versions=software_versions(),
        js=Markup('"use strict";\n' + "\n".join(map(read_resource, SCRIPTS))),  # noqa: S704  our own files
        plotly=plotting_library(),
        pool=campaign.study.setup.pool,
    )

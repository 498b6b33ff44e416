"""The page of `bluekoi explain`: what a model of any system leaves out."""

from __future__ import annotations

import base64
import io
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..explain import CauseSearchResult, PredictedTrials
from ..explain.comparison import cut_trials_into_segments
from ..explain.estimated_noise import NOISE_TABLE_HEAD, noise_rows
from ..explain.results_json import verdict_sentence
from ..explain.text import (
    cause_rows,
    coefficient_rows,
    error_rows,
    error_table,
    probability_rows,
    table_of_measures,
)
from ..figures.drawing.style import AFTER_COLOUR, BEFORE_COLOUR, MEASURED_COLOUR, RC_PARAMS
from ..files import write_text
from ..fitting import free_runs
from .template import render_template, verdict_heading

MAX_TRIALS_SHOWN, PNG_DPI = 4, 130


def write_explanation(
    found: CauseSearchResult, predicted: PredictedTrials | None, path: Path
) -> None:
    """Write the page, with all text escaped and the figure inside."""
    write_text(path, explanation_html(found, predicted))


def explanation_html(found: CauseSearchResult, predicted: PredictedTrials | None = None) -> str:
    """Text of the page."""
    held, sentence = found.held_out, verdict_sentence(found)
    heading = verdict_heading(found.verdict, sentence)
    if found.named:
        heading += ": " + " and ".join(c.name.replace("_", " ") for c in found.named)
    samples = sum(len(s.times) for s in found.prepared.series)
    return render_template(
        "explanation.html",
        name=found.model.name,
        summary=f"{len(found.prepared.series)} trials, {samples} samples in the fit.",
        kind=found.verdict,
        heading=heading,
        sentence=sentence,
        warnings=found.warnings,
        causes=cause_rows(found),
        probabilities=probability_rows(found),
        errors=error_rows(found),
        errors_note=f"Baseline fitted to {held.fitted_to[0]}, extended model to "
        f"{held.fitted_to[1]}; starts fitted; stretches of {held.stretch_s:.3g} s at most.",
        coefficients=coefficient_rows(found),
        noise_head=NOISE_TABLE_HEAD,
        noise=noise_rows(found),
        prediction=_prediction_tables(found, predicted),
        picture=_figure_data_uri(measured_and_simulated_figure(found)),
    )


def _prediction_tables(
    found: CauseSearchResult, predicted: PredictedTrials | None
) -> dict[str, Any] | None:
    if predicted is None:
        return None
    return {"messages": predicted.messages, "errors": error_table(found.model, predicted),
            "measures": table_of_measures(predicted)}  # fmt: skip


def measured_and_simulated_figure(found: CauseSearchResult) -> Figure:
    """Observations over time of a few trials, measured and simulated by both models."""
    model, problem = found.model, found.prepared.problem
    every = problem.series
    chosen = [every[i] for i in np.unique(np.linspace(0, len(every) - 1, MAX_TRIALS_SHOWN).round())
              .astype(int)]  # fmt: skip
    with mpl.rc_context(RC_PARAMS):
        figure = Figure(figsize=(3.0 * len(chosen), 2.0 * len(model.observations)),
                        layout="constrained")  # fmt: skip
        axes = figure.subplots(len(model.observations), len(chosen), squeeze=False)
        for fitted, colour in ((found.baseline, BEFORE_COLOUR), (found.extended, AFTER_COLOUR)):
            for column, one in enumerate(chosen):
                parts = cut_trials_into_segments(problem, fitted, [one], found.held_out.stretch_s)
                if not parts:
                    continue
                runs = free_runs(problem.kernel, parts, fitted.parameter_vectors(problem, parts),
                              open_states=len(model.states))  # fmt: skip
                for part, run in zip(parts, runs, strict=True):
                    for row in range(len(model.observations)):
                        axes[row, column].plot(part.times, run.observed[:, row], color=colour)
        for column, one in enumerate(chosen):
            for row, o in enumerate(model.observations):
                axes[row, column].plot(
                    one.times, one.seen[:, row], color=MEASURED_COLOUR, lw=3, alpha=0.3
                )
                axes[row, column].set(title=one.name if row == 0 else "", xlabel="time, s",
                                      ylabel=f"{o.name}, {o.unit}")  # fmt: skip
    return figure


def _figure_data_uri(figure: Figure) -> str:
    """The figure as png, laid out and drawn once (`Figure.savefig` does both twice)."""
    buffer = io.BytesIO()
    with mpl.rc_context(RC_PARAMS):
        figure.set_dpi(PNG_DPI)
        FigureCanvasAgg(figure).print_png(buffer, metadata={"Software": None})
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")

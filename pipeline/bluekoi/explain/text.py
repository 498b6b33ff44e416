"""What was found, as short text and tables in Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from .cause_search import CauseSearchResult
from .estimated_noise import NOISE_TABLE_HEAD, noise_rows
from .model import Model
from .numbers import FittedNumber
from .prediction import PredictedTrials
from .results_json import residual_term_probabilities, rivals_json, verdict_sentence


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def summary(found: CauseSearchResult) -> str:
    """Verdict, causes with their numbers, probabilities, held-out errors, noise, and warnings."""
    parts = [f"{found.model.name}: {found.verdict}", verdict_sentence(found)]
    if found.named:
        head = ("cause", "kind", "probability", "gain", "size", "credible set")
        parts.append(markdown_table(head, cause_rows(found)))
    parts.append(markdown_table(("coefficient", "baseline", "with the named causes"),
                                coefficient_rows(found)))  # fmt: skip
    errors_head = ("error, conditions left out", "baseline", "extended", "noise floor")
    parts.append(markdown_table(errors_head, error_rows(found)))
    held = found.held_out
    parts.append(f"Fitted to {held.fitted_to[0]} (baseline) and {held.fitted_to[1]} (extended); "
                 f"intervals of {held.stretch_s:.3g} s at most.")  # fmt: skip
    parts.append(markdown_table(NOISE_TABLE_HEAD, noise_rows(found)))
    parts.append(markdown_table(("probability", ""), probability_rows(found)))
    others = rivals_json(found)
    if others:
        parts.append("Not excluded: " + ", ".join(f"{r['name']} {r['weight']:.2f}" for r in others))
    if found.compared:
        parts.append(markdown_table(*requested_cause_sets_table(found)))
    parts += [f"Warning: {w}" for w in found.warnings]
    return "\n\n".join(parts)


def cause_rows(found: CauseSearchResult) -> list[tuple[str, ...]]:
    """Named causes: kind, probability, gain in log evidence, numbers, credible set."""
    out: list[tuple[str, ...]] = []
    for c in found.named:
        own = [n for n in found.numbers if n.label.startswith(c.name + ".")]
        names = [n if n in found.model.by_name else "unexplained" for n in c.credible_set]
        out.append((c.name, found.model.by_name[c.name].kind, f"{c.probability:.2f}",
                    f"{found.gains[c.name]:.1f}", ", ".join(map(number_with_std, own)),
                    ", ".join(names)))  # fmt: skip
    return out


def number_with_std(number: FittedNumber) -> str:
    """A number with its deviation and unit, and whether it stands at a bound."""
    label = number.label if "@" in number.label else number.label.split(".", 1)[-1]
    if number.at_bound:
        return f"{label} {number.value:.3g} {number.unit} (at its {number.at_bound} bound)"
    if not np.isfinite(number.std):
        return f"{label} {number.value:.3g} {number.unit} (not determined)"
    digits = max(0, 1 - int(np.floor(np.log10(number.std)))) if number.std < 10 else 0
    return f"{label} {number.value:.{digits}f} ± {number.std:.{digits}f} {number.unit}"


def coefficient_rows(found: CauseSearchResult) -> list[tuple[str, str, str]]:
    """The model's own numbers without and with the named causes."""
    extended = {n.label: n for n in found.numbers}
    return [
        (n.label, number_with_std(n), number_with_std(extended[n.label]))
        for n in found.baseline_numbers
    ]


def probability_rows(found: CauseSearchResult) -> list[tuple[str, str]]:
    """Every candidate, and an unlisted force, the most probable first."""
    rows = sorted(found.probabilities.items(), key=lambda x: -x[1])
    terms = ", ".join(f"{n} {p:.2f}" for n, p in residual_term_probabilities(found).items())
    last = f"{found.unexplained:.3f}" + (f" ({terms})" if terms else "")
    return [*((n, f"{p:.3f}") for n, p in rows), ("a force that no candidate describes", last)]


def requested_cause_sets_table(found: CauseSearchResult) -> tuple[list[str], list[list[str]]]:
    """Head and rows of the sets that were asked for."""
    names = list(found.held_out.baseline)
    units = [f"{n}, {unit_of_error(found.model, n)}" for n in names]
    rows = []
    for c in found.compared:
        own = [n for n in c.numbers if "." in n.label]
        rows.append([" + ".join(c.causes) or "none", f"{c.log_posterior:.1f}",
                     ", ".join(map(number_with_std, own)), c.fitted_to,
                     *(f"{c.errors.get(n, np.nan):.4g}" for n in names)])  # fmt: skip
    return ["set", "log posterior, less the best", "size", "fitted to", *units], rows


def error_rows(found: CauseSearchResult) -> list[tuple[str, ...]]:
    """Held-out errors in the model's units."""
    held = found.held_out
    return [(f"{n}, {unit_of_error(found.model, n)}", *(f"{e.get(n, np.nan):.4g}" for e in
             (held.baseline, held.extended, held.noise_floor))) for n in held.baseline]  # fmt: skip


def unit_of_error(model: Model, name: str) -> str:
    """Unit of an error by its name."""
    observed = name.removesuffix("_rmse")
    return model.unit_of(model.path[0] if observed == "path" and model.path else observed)


def prediction_text(model: Model, found: PredictedTrials) -> str:
    """Errors of all predicted trials together and of each, then their measures."""
    parts = [f"Note: {m}" for m in found.messages]
    parts.append(markdown_table(*error_table(model, found)))
    if any(found.measured):
        parts.append(markdown_table(*table_of_measures(found)))
    return "\n\n".join(parts)


def error_table(model: Model, found: PredictedTrials) -> tuple[list[str], list[list[str]]]:
    """Head and rows of the errors of the path, or of every observation."""
    names = ["path_rmse"] if model.path else [f"{o.name}_rmse" for o in model.observations]
    head, first = ["trial"], next(iter(found.runs.values()))
    rows = [["all"], *([r.trial] for r in first)]
    for (which, start), runs in found.runs.items():
        for n in names:
            head.append(f"{which}, {start}: {n}, {unit_of_error(model, n)}")
            each = [r.errors[n] for r in runs]
            cells = [float(np.sqrt(np.nanmean(np.square(each)))), *each]
            for row, cell in zip(rows, cells, strict=True):
                row.append(f"{cell:.4g}")
    return head, rows


def table_of_measures(found: PredictedTrials) -> tuple[list[str], list[list[str]]]:
    """Head and rows of measures: measured, and simulated with the relative error."""
    head = ["trial", "measure", "measured"]
    runs = dict(found.runs)
    head += [f"{which}, {start}" for which, start in runs]
    rows = []
    for i, measured_ in enumerate(found.measured):
        trial = next(iter(runs.values()))[i].trial
        for name, value in measured_.items():
            cells = [r[i].measures.get(name, np.nan) for r in runs.values()]
            rows.append(
                [trial, name, f"{value:.4g}", *(_with_relative_error(c, value) for c in cells)]
            )
    return head, rows


def _with_relative_error(simulated: float, value: float) -> str:
    """A simulated measure with its relative error."""
    if not np.isfinite(simulated):
        return "not reached"
    share = f" ({100 * (simulated / value - 1):+.1f} %)" if value else ""
    return f"{simulated:.4g}{share}"

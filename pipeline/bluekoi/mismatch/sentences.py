"""The verdict in one sentence."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from ..engine.cause_selection import UNLISTED_FORCE_LABEL
from ..tuning import coefficient_table
from .find import MismatchResult

UNLISTED_FORCE_TEXT = "an unlisted force"
"""Words for a residual term, which stands for a force that is not on the list of causes."""
MAX_STATED_CAUSE_PROBABILITY = 0.8
MAX_NOISE_FLOOR_RATIO = 1.5
"""Held-out errors of the true model exceed this multiple of the noise floor in 3 of 236 studies."""


def verdict_sentence(found: MismatchResult, named: Sequence[Mapping[str, Any]]) -> str:
    """One sentence of verdict."""
    if found.verdict == "none":
        return _no_cause_sentence(found)
    taken = {c["name"] for c in named}
    names = " and ".join(
        _cause_with_doubt_text(c, taken) for c in named if c["name"] != UNLISTED_FORCE_LABEL
    )
    errors = _path_error_clause(found)
    first = f"{_cause_kind_text(named)}: {names}" if names else ""
    excess = excess_error_clause(found)
    if found.verdict == UNLISTED_FORCE_LABEL:
        beside = f"{first}; in addition a" if first else "A"
        return f"{beside} force acts that no listed cause describes; {errors}{excess}."
    return f"{first}; {errors}{excess}."


def _no_cause_sentence(found: MismatchResult) -> str:
    if not _is_half_of_coefficients_determined(found):
        return (
            "These trials determine fewer than half of the coefficients, so the search cannot tell "
            "what the model lacks: film turns to both sides at two head angles and two powers."
        )
    if extra := excess_error_clause(found):
        return f"No cause has a probability above 1/2, but {_path_error_clause(found)}{extra}."
    if found.misfit_warnings:
        return (
            "No cause has a probability above 1/2, but the model without further causes does not "
            "describe these trials (see the warnings)."
        )
    return "No mismatch beyond the noise: the model without further causes describes these trials."


def _path_error_clause(found: MismatchResult) -> str:
    before, after = (1000 * found.errors[k]["path_rmse_m"] for k in ("baseline", "extended"))
    held = set(found.held_out) < {f.name for f in found.forces}
    on = "on held-out trials" if held else "on the fitted trials (none could be held out)"
    if found.verdict == "none":
        return f"{on} the path error is {before:.1f} mm"
    way = "falls" if after < before else "rises"
    doubt = ", which does not confirm this" if held and after > before else ""
    return f"{on} the path error {way} from {before:.1f} to {after:.1f} mm{doubt}"


def unexplained_sentence(variable: str) -> str:
    """Statement of an unlisted force."""
    return (
        "A force acts that no listed cause describes; it is modelled by a fitted residual term and "
        f"depends most on {variable}."
    )


def _cause_kind_text(named: Sequence[Mapping[str, Any]]) -> str:
    kind = next((c["kind"] for c in named if c["name"] != UNLISTED_FORCE_LABEL), "")
    return "Measurement error" if kind == "measurement" else "Missing physics"


def _cause_with_doubt_text(cause: Mapping[str, Any], named: Collection[str]) -> str:
    """Name of a cause, its probability where that is small, and the alternatives to it."""
    p = float(cause["weight"])
    probability = [f"probability {p:.2f}"] if p < MAX_STATED_CAUSE_PROBABILITY else []
    others = sorted(set(cause.get("credible_set", ())) - set(named))
    listed = ", ".join(UNLISTED_FORCE_TEXT if n == UNLISTED_FORCE_LABEL else n for n in others)
    doubt = [*probability, *([f"or {listed}: these trials cannot separate them"] if others else [])]
    return str(cause["name"]) + (f" ({'; '.join(doubt)})" if doubt else "")


def excess_error_clause(found: MismatchResult) -> str:
    """What to add where the held-out paths of the extended model are far above the noise floor."""
    after, floor = found.errors["extended"]["path_rmse_m"], found.floor_m
    if not after > MAX_NOISE_FLOOR_RATIO * floor > 0:
        return ""
    return (f", {after / floor:.1f} times the noise floor: a force has another form than in the "
            "model, or these trials do not identify everything that is missing")  # fmt: skip


def _is_half_of_coefficients_determined(found: MismatchResult) -> bool:
    """Whether the baseline's fit determines at least half of its coefficients."""
    rows = coefficient_table(found.baseline).values()
    return 2 * sum(bool(row["determined"]) for row in rows) >= len(rows)

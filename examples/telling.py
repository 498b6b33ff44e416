"""What a search found, as tables in Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from bluekoi.integrate import Parameter

from .engine import Beside, Case, Outcome

LEAST_WEIGHT = 0.02


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A Markdown table; numbers as they are given."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def found(given: Case, outcome: Outcome) -> str:
    """The chosen effects: kind, numbers, held-out gain, chance, rivals with their weights."""
    chosen = outcome.chosen
    if not chosen.effects:
        return "Nothing beyond the noise is sure: no effect is named. Nearest were:\n\n" + tried(
            outcome
        )
    gains = outcome.gains()
    rows = [
        (f"`{name}`", given.system.effect(name).kind, numbers(given, outcome, name),
         f"{gains[name]:.1f}", f"{chosen.p_value[name]:.1e}", rivals(outcome, name))
        for name in gains
    ]  # fmt: skip
    head = ("named", "kind", "size", "held-out gain", "chance", "weight, rivals")
    return table(head, rows)


def numbers(given: Case, outcome: Outcome, name: str) -> str:
    """Parameters of an effect with their deviations and units, and whether one is at its bound."""
    parameters = {p.name: p for p in given.system.parameters}
    values = outcome.chosen.fit.by_label()
    return ", ".join(
        f"{label.split('.', 1)[1]} {_number(parameters[label], values[label], outcome.std[label])}"
        for label in values
        if label.startswith(name + ".")
    )


def _number(parameter: Parameter, value: float, std: float) -> str:
    if not parameter.lower < value < parameter.upper:
        return f"{value:.3g} {parameter.unit} (at its bound: not to be believed)"
    return f"{value:.3g} ± {std:.2g} {parameter.unit}"


def rivals(outcome: Outcome, name: str) -> str:
    """Weight of a chosen effect and of those that competed for its place."""
    weights = outcome.weights(name)
    own = weights.pop(name, 1.0)
    rest = [f"`{k}` {w:.2f}" for k, w in sorted(weights.items(), key=lambda i: -i[1])
            if w >= LEAST_WEIGHT]  # fmt: skip
    return ", ".join([f"{own:.2f}", *rest])


def tried(outcome: Outcome, count: int = 4) -> str:
    """The candidates of the last round that came nearest, with gain and chance."""
    last = outcome.choice.rounds[-1]
    rows = [
        (f"`{t.effects[-1]}`", f"{t.total - last.before.total:.1f}",
         f"{t.p_value[t.effects[-1]]:.1e}")
        for t in last.tried[:count] if np.isfinite(t.total)
    ]  # fmt: skip
    return table(("candidate", "held-out gain", "chance"), rows)


def asked(question: str, answers: Mapping[str, Beside]) -> str:
    """Rivals that answer one question, with size, gain, chance and weight."""
    rows = []
    for name, one in answers.items():
        own = {k.split(".", 1)[1]: v for k, v in one.model.fit.by_label().items()
               if k.startswith(name + ".")}  # fmt: skip
        size = ", ".join(f"{k} {v:.3g}" for k, v in own.items())
        chance = f"{one.model.p_value[name]:.1e}" if name in one.model.p_value else ""
        rows.append((f"`{name}`" if own else name, size, f"{one.gain:.1f}", chance,
                     f"{one.weight:.2f}"))  # fmt: skip
    return table((question, "size", "held-out gain", "chance", "weight"), rows)


def coefficients(outcome: Outcome) -> str:
    """The chosen model's own numbers with their deviations."""
    values = outcome.chosen.fit.by_label()
    own = [k for k in values if k.split(".")[0] not in outcome.chosen.effects]
    return ", ".join(f"{k} {values[k]:.4g} ± {outcome.std[k]:.2g}" for k in own)

"""The form of a law: shapes of effects that are held where they are likely, and freed where that
pays.
"""

from __future__ import annotations

from collections.abc import Mapping

from ..integrate import Kernel
from .bench import Bench
from .judge import Trialled
from .paying import WRONG
from .search import held_shapes

LEAST_FOR_SHAPE = 2.0
"""Held-out log likelihood over the inflation for which shapes are freed."""


def shaped(bench: Bench, model: Trialled) -> Trialled:
    """A model with the shapes of its effects free, where that pays: a law may have another form
    than the candidate's, and what that leaves over must not pass for a further cause. While much
    else is missing they stay as they are: they would take up what another cause does.
    """
    held = held_shapes(bench.kernel, model)
    if not held or model.inflation > WRONG:
        return model
    return _if_better(bench, model, held) or model


def shaped_anyway(bench: Bench, model: Trialled) -> Trialled | None:
    """A wrong model with the shapes of its effects free, where that pays: for when nothing pays
    beside it, because what is left over is its form.
    """
    held = held_shapes(bench.kernel, model)
    return _if_better(bench, model, held) if held and model.inflation > WRONG else None


def _if_better(bench: Bench, model: Trialled, held: Mapping[str, float]) -> Trialled | None:
    free = formed(bench, model, held)
    gain = (free.total - model.total) / free.inflation
    better = gain > LEAST_FOR_SHAPE and free.inflation <= 2 * model.inflation
    return free if better else None


def formed(bench: Bench, model: Trialled, held: Mapping[str, float]) -> Trialled:
    """A model with these shapes of its effects free as well, under its own noise."""
    bench.progress(f"form of {', '.join(model.effects)}")
    return bench.settled(bench.refit(model.effects, model, {**model.fit.by_label(), **held}))


def own_shapes(kernel: Kernel, model: Trialled) -> dict[str, float]:
    """`held_shapes` of the effect added last alone."""
    last = f"{model.effects[-1]}."
    return {k: v for k, v in held_shapes(kernel, model).items() if k.startswith(last)}

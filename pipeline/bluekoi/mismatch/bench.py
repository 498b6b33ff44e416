"""What all rounds of the search share, and the ways in which a model is fitted in them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from ..data import Float
from ..fitting import (
    Free,
    Passes,
    Series,
    filter_all,
    fit_noise,
    trial_values,
    with_forces_of,
)
from ..integrate import Kernel
from .judge import Trialled
from .search import PASSES, Foretold, other_shapes, screened, try_effects, unlikelihood

Progress = Callable[[str], None]
NOISE_ROUNDS = 4


@dataclass(frozen=True)
class Bench:
    """What all rounds share: kernel, trials to fit, base (values of what is not fitted), names of
    the candidates, the model's own coefficients, whom to tell of progress.
    """

    kernel: Kernel
    series: Sequence[Series]
    base: Float
    candidates: tuple[str, ...]
    coefficients: tuple[Free, ...]
    progress: Progress

    def points(self, model: Trialled) -> list[Float]:
        """Full parameter vectors of a model, one a trial."""
        free, values = model.fit.free, model.fit.values
        return [trial_values(self.kernel, self.base, free, values, s.group) for s in self.series]

    def foretold(
        self, model: Trialled, candidates: Sequence[str], predictor: Passes
    ) -> dict[str, Foretold]:
        """`screened`, with candidates that have other shapes differenced at several, the most
        promising of which is where their refit begins.
        """
        at = partial(screened, self.kernel, self.series, model, predictor=predictor)
        told = at(self.base, candidates)
        shapes = {c: other_shapes(self.kernel, c) for c in candidates}
        for k in range(max((len(turns) for turns in shapes.values()), default=0)):
            put = {c: turns[k] for c, turns in shapes.items() if k < len(turns)}
            moved = self.base.copy()
            for name, value in (item for shape in put.values() for item in shape.items()):
                moved[self.kernel.system.slot[name]] = value
            for c, found in at(moved, list(put)).items():
                gain = found.gain - unlikelihood(self.kernel, put[c])
                if gain > told[c].gain:
                    told[c] = Foretold(gain, {**found.start, **put[c]})
        return told

    def refit(
        self, effects: Sequence[str], under: Trialled, start: Mapping[str, float] | None = None,
        predictor: Passes | None = None,
    ) -> Trialled:  # fmt: skip
        """The model with these effects, fitted under the noise of another.

        predictor: the other's filter, whose gains are held for one pass: many candidates are then
        fitted as predictors of one form.
        """
        known = under.fit.by_label() if start is None else start
        return try_effects(self.kernel, self.series, self.base, self.coefficients, effects,
                           noise=under.noise, predictor=predictor, start=known,
                           passes=1 if predictor else PASSES)  # fmt: skip

    def followed(self, effects: Sequence[str], under: Trialled) -> Trialled:
        """As `refit`, with gains that follow each step of the fit: where those held have led it
        astray, at several times the cost.
        """
        return try_effects(self.kernel, self.series, self.base, self.coefficients, effects,
                           noise=under.noise, start=under.fit.by_label(), passes=1)  # fmt: skip

    def renoised(self, model: Trialled, rounds: int = NOISE_ROUNDS) -> Trialled:
        """A model under all of its own noise: what was lacking before may have passed for errors
        of measurement as well.
        """
        noise = fit_noise(self.kernel, self.series, self.points(model), model.noise,
                          rounds=rounds)  # fmt: skip
        return self.refit(model.effects, replace(model, noise=noise))

    def less(self, model: Trialled, names: Sequence[str], bare: Trialled) -> Trialled:
        """A model with effects taken away, all else refitted, under noise of its own.

        bare: the model without effects: where none are left it is that, under what measuring noise
        the other has.
        """
        rest = [e for e in model.effects if e not in names]
        if not rest:
            noise = with_forces_of(self.kernel, model.noise, bare.noise)
            return self.settled(replace(bare, noise=noise))
        taken = tuple(f"{name}." for name in names)
        start = {k: v for k, v in model.fit.by_label().items() if not k.startswith(taken)}
        return self.settled(self.refit(rest, model, start))

    def settled(self, model: Trialled) -> Trialled:
        """A model under its own noise: random forces and numbers fitted in turn."""
        points = self.points(model)
        noise = fit_noise(self.kernel, self.series, points, model.noise, forces_only=True)
        predictor = filter_all(self.kernel, self.series, points, noise)
        return try_effects(self.kernel, self.series, self.base, self.coefficients, model.effects,
                           noise=noise, predictor=predictor,
                           start=model.fit.by_label())  # fmt: skip

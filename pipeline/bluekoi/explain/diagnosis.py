"""Why a model runs away from its trials, or does not compile: the equation at fault."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from ..data import Float
from ..errors import InputError, input_error
from ..numba_settings import njit
from .model import Function, Model, names_of_arguments
from .trials import Trial

SAMPLES_PER_TRIAL, TRIALS_CHECKED = 41, 4
"""Times of a trial, and trials, at which the equations are evaluated."""


def divergence_error(model: Model, trials: Sequence[Trial]) -> InputError:
    """A fault of a model that cannot be followed along its trials."""
    place = f"model '{model.name}'"
    for given in _equation_arguments_along_trials(model, trials):
        if (fault := _first_nonfinite_equation(model, given)) is not None:
            where, found = fault
            return input_error(place, where, found, "finite values wherever the trials lead",
                               "Write the equation so that it holds there, too.")  # fmt: skip
    return input_error(
        place,
        "",
        "a simulation that runs away from the trials",
        "start values of the coefficients at which the model stays near its trials",
        "Check signs and units of the equations, and the units of the columns.",
    )


def _equation_arguments_along_trials(
    model: Model, trials: Sequence[Trial]
) -> Iterator[dict[str, float]]:
    """States as the trials show them, inputs, constants, coefficients and the time, by name."""
    for trial in trials[:TRIALS_CHECKED]:
        times = np.linspace(trial.times[0], trial.times[-1], SAMPLES_PER_TRIAL)

        def at(column: Float, trial: Trial = trial, times: Float = times) -> Float:
            known = np.isfinite(column)
            return np.interp(times, trial.times[known], column[known])

        rows = {"t": times - times[0]}
        for s in model.states:
            rows[s.name] = np.full(SAMPLES_PER_TRIAL, s.start)
            if s.observed:
                rows[s.name] = at(trial.observed[s.observed])
            elif s.rate_of:
                rows[s.name] = np.gradient(at(trial.observed[s.rate_of]), times)
        rows |= {i.name: at(trial.inputs[i.name]) for i in model.inputs}
        fixed = {c.name: trial.constants.get(c.name, c.value) for c in model.constants}
        fixed |= {p.name: p.start for p in model.coefficients}
        for k in range(SAMPLES_PER_TRIAL):
            yield {name: float(row[k]) for name, row in rows.items()} | fixed


def _first_nonfinite_equation(model: Model, given: dict[str, float]) -> tuple[str, str] | None:
    """Place and fault of the first equation without a finite value."""
    for stage in model.stages:
        values: Sequence[float] = [0.0] * len(stage.outputs)
        if stage.function is not None:
            own = {a: given[a] for a in names_of_arguments(stage.function)}
            at = ", ".join(f"{a} = {v:.4g}" for a, v in own.items())
            where = f"stage {stage.name}: {stage.function.__name__}"
            try:
                values = stage.function(**own)
                bad = any(isinstance(v, complex) or not np.isfinite(v) for v in values)
            except (ArithmeticError, ValueError, TypeError) as error:
                return where, f"{type(error).__name__}: {error}, at {at}"
            if bad:
                return where, f"{', '.join(f'{v:g}' for v in values)} at {at}"
        given = {**dict(zip(stage.outputs, values, strict=True)), **given}
    return None


@contextmanager
def reporting_compiler_errors(model: Model) -> Iterator[None]:
    """What fails because an equation does not compile is reported as that equation's fault."""
    try:
        yield
    except InputError:
        raise
    except Exception:
        for where, function in _functions_with_location(model):
            if fault := _compiler_message(function):
                raise input_error(
                    f"model '{model.name}'", f"{where}: {function.__name__}", fault,
                    "arithmetic, abs and functions of math and numpy, which numba can compile",
                    "Write the equation without texts, lists, objects and other functions; "
                    "import modules at the top of the file.",
                ) from None  # fmt: skip
        raise


def _functions_with_location(model: Model) -> Iterator[tuple[str, Function]]:
    for s in model.stages:
        if s.function is not None:
            yield f"stage {s.name}", s.function
    for c in model.causes:
        own = [*c.hooks.values(), *([c.rates] if c.rates is not None else [])]
        yield from ((f"cause {c.name}", f) for f in own)


def _compiler_message(function: Function) -> str:
    """What the compiler says against a function, in a line; empty where it compiles."""
    try:
        njit(function)(*(0.5 + 0.1 * i for i in range(len(names_of_arguments(function)))))
    except ArithmeticError:
        return ""
    except Exception as error:
        lines = [line.strip() for line in str(error).splitlines()]
        messages = [x for x in lines if x and not x.startswith("Failed in nopython mode")]
        return f"{type(error).__name__}: {messages[0] if messages else ''}"
    return ""

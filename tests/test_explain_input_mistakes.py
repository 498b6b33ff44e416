"""Slips in recordings and models of `bluekoi explain` that end in a plausible wrong result."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bluekoi.errors import InputError
from bluekoi.explain import Parameter, Stage, Trial, explain, load_model, read_trials
from bluekoi.explain.checks import refuse_invalid_model
from bluekoi.explain.diagnosis import divergence_error, reporting_compiler_errors
from bluekoi.explain.numbers import FittedNumber, at_bound_sentences
from bluekoi.explain.prediction import FreeSimulation, runaway_sentences
from bluekoi.explain.recording_warnings import (
    stuck_sensor_warnings,
    time_unit_warnings,
    unusual_recording_warnings,
)
from bluekoi.explain.trials import validated_trials

MODEL = load_model(Path(__file__).parent / "cart_model.py")
TIMES = 0.05 * np.arange(60)
COLUMNS = """columns:
  time: {column: t, unit: s}
  position: {column: x, unit: m}
  push: {column: u, unit: N}
"""


def cart_trial(name: str = "a", shift: float = 0.0) -> Trial:
    return Trial(name, TIMES, {"position": np.sin(TIMES + shift)}, {"push": np.cos(TIMES)})


def write_data_folder(folder: Path, settings: str, header: str = "t,x,u") -> Path:
    rows = "\n".join(f"{t:.2f},{np.sin(t):.4f},1.5" for t in TIMES)
    (folder / "run.csv").write_text(f"{header}\n{rows}\n")
    (folder / "data.yaml").write_text(settings)
    return folder


def refusal_message(folder: Path) -> str:
    """The one message that a folder is refused with."""
    with pytest.raises(InputError) as raised:
        validated_trials(MODEL, read_trials(MODEL, folder))
    assert len(raised.value.findings) == 1
    return str(raised.value)


def test_a_copy_of_a_recording_is_refused():
    assert validated_trials(MODEL, [cart_trial("a"), cart_trial("b", 0.1)])
    later = replace(cart_trial("b"), times=TIMES + 1.0)
    with pytest.raises(InputError, match=r"b: found the samples of a; .* Remove one of the two"):
        validated_trials(MODEL, [cart_trial("a"), later])


def test_two_recordings_at_rest_are_no_copies():
    rest = {"position": np.zeros(60)}
    assert validated_trials(MODEL, [replace(cart_trial(n), observed=rest) for n in "ab"])


def test_trials_in_which_nothing_moves_are_refused():
    rest = {"position": np.full(60, 2.0)}
    still = [replace(cart_trial(n), observed=rest) for n in "ab"]
    with pytest.raises(InputError, match="observations that are constant in each trial; expected"):
        explain(MODEL, [*still, replace(cart_trial("c"), role="held_out")])


@pytest.mark.parametrize("code", [99999.0, -9999.0, -1e6])
def test_a_code_for_nothing_seen_is_refused(code):
    x = cart_trial().observed["position"].copy()
    x[[20, 41]] = code
    with pytest.raises(InputError, match=r"position, sample 20: .*Leave the cell empty"):
        validated_trials(MODEL, [replace(cart_trial(), observed={"position": x})])


@pytest.mark.parametrize("x", [np.where(TIMES < 1.0, 0.0, 50.0), np.where(TIMES == 1.0, 5.0, 0.0),
                               np.where(TIMES == 1.0, 5.0, np.sin(TIMES))])  # fmt: skip
def test_steps_rest_and_moderate_outliers_are_no_codes(x):
    assert validated_trials(MODEL, [replace(cart_trial(), observed={"position": x})])


@pytest.mark.parametrize(
    ("settings", "header", "message"),
    [
        (COLUMNS.replace("column: u", "column: x"), "t,x,u",
         "columns: found 'x' in m as position and 'x' in N as push; expected one unit of a column"),
        (COLUMNS.replace("column: t", "column: x"), "t,x,u", "'x' in s as time"),
        (COLUMNS + "constants: {mass: 3}\n", "t,x,u",
         "data.yaml: constants: found 'mass'; expected a constant of the model. The model has no"),
        (COLUMNS + "trials: [{file: run.csv, start_s: 2, end_s: 1}]\n", "t,x,u",
         "found an end at 1 s before the start at 2 s"),
        (COLUMNS.replace("  time", "\ttime"), "t,x,u", "Indent by spaces, not by tabs."),
        (COLUMNS, "t,x", "columns must be apart by semicolons"),
        (COLUMNS, "t,x,x", "found two columns 'x'"),
    ],
    ids=["output as input", "position as time", "unknown constant", "end before start", "tab",
         "decimal commas", "a name twice"],
)  # fmt: skip
def test_each_slip_has_one_message_that_leads_to_its_fix(settings, header, message, tmp_path):
    assert message in refusal_message(write_data_folder(tmp_path, settings, header))


def test_samples_further_apart_than_ten_time_constants_are_reported():
    assert time_unit_warnings([cart_trial()], 20.0) == []
    (sentence,) = time_unit_warnings([replace(cart_trial(), times=1000.0 * TIMES)], 0.3)
    assert "check the unit of time" in sentence


@pytest.mark.parametrize(("level", "more"), [(0.0, "; right column?"), (25.0, "")])
def test_an_input_of_one_value_is_reported(level, more):
    assert unusual_recording_warnings(MODEL, [cart_trial()]) == []
    one = [replace(cart_trial(n), inputs={"push": np.full(60, level)}) for n in "ab"]
    warning = (
        f"Input push is {level:g} throughout: how forces depend on it is not determined{more}."
    )
    assert unusual_recording_warnings(MODEL, one) == [warning]
    other = replace(one[1], inputs={"push": np.full(60, 3.0)})
    assert unusual_recording_warnings(MODEL, [one[0], other]) == []


@pytest.mark.parametrize("far", [100.0, np.inf, np.nan])
def test_a_free_run_that_leaves_its_recording_is_named(far):
    seen = np.column_stack([TIMES, np.where(TIMES < 1.0, np.nan, 0.0)])
    near = FreeSimulation("a", TIMES, seen + 1.0, seen, {}, {})
    away = FreeSimulation("b", TIMES, seen + far, seen, {}, {})
    (sentence,) = runaway_sentences(
        {("baseline", "start"): [near, away], ("extended", "start"): [near]}
    )
    assert sentence.startswith("Free runs of the baseline model leave b by more than 10 times")


def test_a_number_at_its_bound_asks_for_the_units():
    (sentence,) = at_bound_sentences([FittedNumber("M", 1.0, np.nan, "kg", "lower")])
    assert "M stands at its lower bound, 1 kg" in sentence
    assert "check the units of the columns" in sentence


@pytest.mark.parametrize(
    ("equation", "found"),
    [(lambda v, c: (-c * v**0.5 if v >= 0 else np.nan,), r"nan at v = -0\.\d+, c = 0.5"),
     (lambda v, c: (1.0 / (c - 0.5) + v,), r"ZeroDivisionError: .*, at v = ")],
    ids=["root of a negative speed", "division by zero"],
)  # fmt: skip
def test_the_equation_that_makes_a_model_run_away_is_named(equation, found):
    states = (MODEL.states[0], replace(MODEL.states[1], rate_of="position"))
    stages = (Stage("force", ("F",), equation, open=True), *MODEL.stages[1:])
    error = divergence_error(replace(MODEL, states=states, stages=stages), [cart_trial()])
    assert error.findings[0].where.startswith("stage force")
    with pytest.raises(InputError, match=found):
        raise error
    assert "Check signs and units" in str(divergence_error(MODEL, [cart_trial()]))


def test_a_name_that_the_integration_uses_is_refused():
    coefficients = (Parameter("d_v", "1/s", 0.5, 0.0, 5.0, "drag"),)
    with pytest.raises(
        InputError, match=r"'d_v', which the integration uses for the derivative of the state 'v'"
    ):
        refuse_invalid_model(replace(MODEL, coefficients=coefficients))


def test_the_equation_that_does_not_compile_is_named():
    def pushed(v, c):
        return (float(f"{-c * v}"),)

    model = replace(MODEL, stages=(Stage("force", ("F",), pushed, open=True), *MODEL.stages[1:]))
    with (
        pytest.raises(InputError, match=r"stage force: pushed: found .*without texts, lists"),
        reporting_compiler_errors(model),
    ):
        raise ValueError("could not convert")
    with pytest.raises(ZeroDivisionError), reporting_compiler_errors(MODEL):
        raise ZeroDivisionError


def stuck(x: np.ndarray) -> list[str]:
    return stuck_sensor_warnings("position", TIMES_20_HZ, x)


TIMES_20_HZ = 0.05 * np.arange(400)
SWING = np.sin(1.3 * TIMES_20_HZ) + 1e-4 * np.random.default_rng(0).normal(size=400)


def test_a_saturated_sensor_is_a_warning():
    (text,) = stuck(np.clip(SWING, -0.6, 0.6))
    assert text.startswith("position stops at 0.6 from")
    assert "and elsewhere while it moves: does the sensor saturate" in text


def test_a_value_that_stands_for_nothing_seen_is_a_warning():
    x = SWING + 2.0
    x[100:120] = 0.0
    (text,) = stuck(x)
    assert text.startswith("position stops at 0 from 5 to 5.95 s while it moves")


@pytest.mark.parametrize(
    "x",
    [SWING, np.round(SWING, 2), np.round(0.05 * SWING, 3),
     np.clip(np.cumsum(np.repeat([1.0, 0.5, 0.2, 0.05, 0.0], 80)), 0, None)],
    ids=["moving", "coarse encoder", "coarse encoder, slow", "comes to rest"],
)  # fmt: skip
def test_quantised_and_resting_motion_is_no_stuck_sensor(x):
    assert stuck(x) == []


def test_a_warning_that_holds_for_many_trials_names_three_of_them():
    x, push = np.clip(SWING, -0.6, 0.6), {"push": np.cos(TIMES_20_HZ)}
    trials = [Trial(f"r{k}", TIMES_20_HZ, {"position": x + 0.001 * k}, push) for k in range(9)]
    texts = [
        w
        for w in unusual_recording_warnings(MODEL, trials)
        if "position stops" in w or "further" in w
    ]
    assert [w[:3] for w in texts] == ["r0:", "r1:", "r2:", "The"]
    assert texts[-1] == "The same in 6 further trials."


def test_times_in_groups_are_a_warning():
    times = np.floor(TIMES / 0.5) * 0.5 + 1e-6 * np.arange(60)
    (text,) = (
        w
        for w in unusual_recording_warnings(MODEL, [replace(cart_trial(), times=times)])
        if "groups" in w
    )
    assert text.startswith("a: times come in groups: most samples are 1e-06 s apart")


def test_trials_shorter_than_the_model_s_time_constant_are_a_warning():
    (text,) = time_unit_warnings([replace(cart_trial(), times=0.01 * TIMES)], 1.0)
    assert text.endswith("check the unit of time, or record for longer.")
    assert time_unit_warnings([cart_trial()], 1.0) == []


def test_an_equation_that_has_no_real_value_is_named():
    def root_drag(v: float, c: float) -> tuple[float]:
        return (-c * v**0.5,)

    stages = (Stage("force", ("F",), root_drag, open=True), *MODEL.stages[1:])
    error = divergence_error(replace(MODEL, stages=stages), [cart_trial()])
    assert "root_drag" in str(error) or "runs away" in str(error)
    states = (MODEL.states[0], replace(MODEL.states[1], rate_of="position"))
    error = divergence_error(replace(MODEL, stages=stages, states=states), [cart_trial()])
    assert "stage force: root_drag: found" in str(error)
    assert "at v = -" in str(error)


def test_a_code_that_fills_a_second_is_refused():
    x = SWING.copy()
    x[100:120] = -999.0
    trial = Trial("a", TIMES_20_HZ, {"position": x}, {"push": np.cos(TIMES_20_HZ)})
    with pytest.raises(InputError, match=r"position, sample 100: found -999; .* Leave the cell"):
        validated_trials(MODEL, [trial])

"""`bluekoi.explain` on a driven mass whose causes are known, and on faulty models and data."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from bluekoi.cli import main
from bluekoi.engine import strength_estimates
from bluekoi.errors import InputError
from bluekoi.explain import (
    Cause,
    Input,
    Model,
    Observation,
    Parameter,
    Stage,
    State,
    Trial,
    explain,
    explanation_json,
    load_model,
    predict,
    predict_left_out,
    read_trials,
)
from bluekoi.explain.checks import refuse_invalid_model
from bluekoi.explain.results_json import verdict_sentence
from bluekoi.explain.sampling import averaged_to_rate
from bluekoi.explain.system_assembly import assemble_system
from bluekoi.explain.text import summary
from bluekoi.explain.trials import as_trial_series, validated_trials
from bluekoi.integrate import compile_system
from bluekoi.integrate.batch import simulate_batch

NOISE_STD_M = 1e-3
MODEL_FILE = Path(__file__).parent / "cart_model.py"


@pytest.fixture(scope="module")
def cart_model() -> Model:
    return load_model(MODEL_FILE)


def simulated_run(
    name: str,
    rng: np.random.Generator,
    *,
    drag: float,
    current: float,
    amplitude: float,
    n: int = 100,
    period: int = 1,
) -> Trial:
    """A cart with drag v |v| and a current, driven by a push that is held between samples."""
    dt, fine = 0.05, 5
    times = dt * np.arange(n)
    push = np.repeat(amplitude * rng.uniform(-1, 1, n // period + 1), period)[:n]
    x, v, seen = 0.0, 0.0, []
    for k in range(n):
        seen.append(x + NOISE_STD_M * rng.standard_normal())
        for _ in range(fine):
            middle = v + 0.5 * dt / fine * (push[k] - 0.4 * v - drag * v * abs(v))
            v += dt / fine * (push[k] - 0.4 * middle - drag * middle * abs(middle))
            x += dt / fine * (middle + current)
    return Trial(name, times, {"position": np.array(seen)}, {"push": push})


def simulated_runs(
    *, drag: float = 0.0, current: float = 0.0, seed: int = 3, period: int = 5
) -> list[Trial]:
    rng = np.random.default_rng(seed)
    return [
        simulated_run(f"run {i}", rng, drag=drag, current=current, amplitude=1.0 + i, period=period)
        for i in range(6)
    ]


@pytest.fixture(scope="module")
def cart_explanation(cart_model):
    return explain(cart_model, simulated_runs(drag=0.8, current=0.1), compare=[["spring"]])


def test_the_causes_that_act_are_named_with_their_size(cart_explanation):
    assert {c.name for c in cart_explanation.named} == {"quadratic_drag", "current"}
    assert cart_explanation.verdict == "physics"
    values = {n.label: n for n in cart_explanation.numbers}
    drag = values["quadratic_drag.k"]
    assert drag.value == pytest.approx(0.8, abs=max(3 * drag.std, 0.05))
    assert values["current.c"].value == pytest.approx(0.1, abs=0.01)
    assert cart_explanation.probabilities["spring"] < 0.5
    assert (
        cart_explanation.held_out.extended["position_rmse"]
        < 0.5 * cart_explanation.held_out.baseline["position_rmse"]
    )


def test_a_complete_model_has_no_cause(cart_model):
    found = explain(cart_model, simulated_runs())
    assert found.verdict == "none"
    assert found.named == ()
    assert verdict_sentence(found).startswith("No mismatch beyond the noise")
    held = replace(found.held_out, noise_floor={k: v / 6 for k, v in
                                                found.held_out.baseline.items()})  # fmt: skip
    assert "wrong by 6.0 times the noise floor" in verdict_sentence(replace(found, held_out=held))


def test_a_probable_cause_on_whose_size_the_trials_do_not_agree_is_not_named(
    cart_model, monkeypatch
):
    def wide(model, candidates):
        found = strength_estimates(model, candidates)
        return {k: (v, 10.0 if k == "current.c" else std) for k, (v, std) in found.items()}

    monkeypatch.setattr("bluekoi.engine.cause_selection.strength_estimates", wide)
    found = explain(cart_model, simulated_runs(drag=0.8, current=0.1), without=["spring"])
    assert [c.name for c in found.named] == ["quadratic_drag"]
    assert "current improves the fit" in found.warnings[0]
    assert not any(n.label.startswith("current") for n in found.numbers)


def test_causes_of_the_site_are_not_applied_elsewhere(cart_model, cart_explanation):
    elsewhere = predict(cart_explanation, simulated_runs(drag=0.8, seed=9))
    assert elsewhere.not_applied == ("current",)
    assert "belongs to the site" in elsewhere.messages[0]
    errors = {k: np.mean([r.errors["position_rmse"] for r in v]) for k, v in elsewhere.runs.items()}
    assert errors["extended", "start fitted"] < 0.3 * errors["baseline", "start fitted"]
    assert errors["extended", "start fitted"] < 0.01


def test_each_condition_is_predicted_by_models_fitted_to_the_others(cart_explanation):
    left = predict_left_out(cart_explanation, known_s=1.0)
    errors = {k: np.mean([r.errors["position_rmse"] for r in v]) for k, v in left.runs.items()}
    assert errors["extended", "start fitted"] < 0.2 * errors["baseline", "start fitted"]
    first = "start from the first seconds"
    assert errors["extended", first] < 0.2 * errors["baseline", first]
    assert not left.not_applied


def test_a_set_that_was_asked_for_is_compared(cart_explanation):
    (spring,) = cart_explanation.compared
    assert spring.causes == ("spring",)
    assert spring.log_posterior < -10.0
    assert spring.errors["position_rmse"] > cart_explanation.held_out.extended["position_rmse"]


def test_a_known_start_is_where_a_trial_begins(cart_model):
    trial = replace(simulated_runs()[0], start={"v": 2.5})
    one = as_trial_series(cart_model, assemble_system(cart_model), trial, {})
    assert one.mean[1] == 2.5
    with pytest.raises(InputError, match="start: found 'w'"):
        validated_trials(cart_model, [replace(trial, start={"w": 1.0})])


def test_the_ships_measures_are_those_of_its_circle():
    ship = load_model(Path(__file__).parents[1] / "examples" / "ship_zigzag" / "model.py")
    t = np.arange(0.0, 100.0, 0.1)
    psi = np.maximum(t - 20.0, 0.0) * 0.05
    x = np.where(t < 20, t, 20 + 20 * np.sin(psi))
    y = np.where(t < 20, 0.0, 20 * (1 - np.cos(psi)))
    rudder = np.where(t < 20, 0.0, 0.6)
    found = ship.measures(t, np.column_stack([x, y, psi]), rudder[:, None])
    assert found["advance_m"] == pytest.approx(20.0, abs=0.1)
    assert found["tactical_diameter_m"] == pytest.approx(40.0, abs=0.1)


def test_the_results_have_the_keys_of_the_robots_mismatch_json(cart_explanation):
    content = json.loads(json.dumps(explanation_json(cart_explanation)))
    keys = {
        "verdict",
        "causes",
        "rivals",
        "probabilities",
        "held_out",
        "warnings",
        "overdispersion",
    }
    assert keys <= set(content)
    cause = content["causes"][0]
    assert {"name", "kind", "channels", "parameters", "weight", "credible_set", "sentence"} <= set(
        cause
    )
    assert content["probabilities"].keys() == {"quadratic_drag", "current", "spring", "unexplained"}


def test_estimated_errors_and_random_forces_are_stated(cart_explanation):
    content = json.loads(json.dumps(explanation_json(cart_explanation)))["noise"]
    (position,) = content["observations"]
    assert (position["name"], position["unit"]) == ("position", "m")
    whole = np.hypot(position["independent_std"], position["autocorrelated_std"])
    assert whole == pytest.approx(NOISE_STD_M, rel=0.3)
    assert len(content["random_forces"]) == len(cart_explanation.model.channels)
    assert "errors of position, m" in summary(cart_explanation)


def test_only_the_asked_causes_are_tried(cart_model):
    found = explain(cart_model, simulated_runs(drag=0.8), without=["current", "spring"])
    assert found.probabilities.keys() == {"quadratic_drag"}
    with pytest.raises(InputError, match=r"'quadratic'.*Did you mean 'quadratic_drag'"):
        explain(cart_model, simulated_runs(), candidates=["quadratic"])


def free_simulation(model: Model, trial: Trial) -> np.ndarray:
    assembly = assemble_system(model)
    kernel = compile_system(assembly.system)
    one = as_trial_series(model, assembly, trial, {})
    lanes = [
        np.repeat(np.asarray(a, float)[None, :, None], 16, axis=2)
        for a in (one.mean, assembly.system.parameter_vector({"c": 0.4}), one.constants)
    ]
    lanes[0][:, :2] = 0.0
    observed, _ = simulate_batch(kernel, *lanes, times=one.times[None], inputs=one.inputs[None])
    return observed[0, :, 0, 0]


def test_a_held_input_keeps_its_value_until_the_next_sample(cart_model):
    trial = simulated_run("square", np.random.default_rng(1), drag=0.0, current=0.0, amplitude=20.0)
    held = free_simulation(cart_model, trial) - trial.observed["position"]
    linear = free_simulation(replace(cart_model, inputs=(Input("push", "N"),)), trial)
    assert np.abs(held).max() < 0.01
    assert np.abs(linear - trial.observed["position"]).max() > 0.05


def test_a_lower_rate_keeps_curvature_and_impulse(cart_model):
    times = 0.001 * np.arange(4000)
    trial = Trial("t", times, {"position": times**2}, {"push": np.sin(3 * times)})
    assembly = assemble_system(cart_model)
    few = averaged_to_rate(as_trial_series(cart_model, assembly, trial, {}), 50.0, [False])
    assert len(few.times) == 200
    np.testing.assert_allclose(few.seen[:, 0], few.times**2, atol=1e-9)
    before, after = (
        np.trapezoid(u, t) for u, t in ((np.sin(3 * times), times), (few.inputs[:, 0], few.times))
    )
    assert after == pytest.approx(before, abs=0.01)


def test_angles_are_unwrapped(cart_model):
    model = replace(cart_model, observations=(Observation("position", "rad", 0.01, angle=True),))
    turns = np.linspace(0, 20, 200)
    (one,) = validated_trials(model, [Trial("t", 0.1 * np.arange(200),
                                   {"position": (turns + np.pi) % (2 * np.pi) - np.pi},
                                   {"push": np.zeros(200)})])  # fmt: skip
    np.testing.assert_allclose(np.diff(one.observed["position"]), np.diff(turns), atol=1e-9)


def test_missing_samples_are_allowed_and_numbers_at_bounds_are_reported(cart_model):
    trials = simulated_runs(drag=0.8)
    holes = [
        replace(
            t, observed={"position": np.where(np.arange(100) % 3, t.observed["position"], np.nan)}
        )
        for t in trials
    ]
    tight = replace(
        cart_model.causes[0], parameters=(replace(cart_model.causes[0].parameters[0], upper=0.5),)
    )
    found = explain(replace(cart_model, causes=(tight, *cart_model.causes[1:])), holes)
    assert "quadratic_drag" in [c.name for c in found.named]
    assert any("quadratic_drag.k stands at its upper bound, 0.5" in w for w in found.warnings)


# faulty models: three, each one message that leads to the fix


def test_a_model_whose_rates_are_too_few_is_named(cart_model):
    stages = tuple(replace(s, function=lambda v, F: (v,)) if s.name == "rates" else s
                   for s in cart_model.stages)  # fmt: skip
    with pytest.raises(InputError, match=r"stage rates.*1 values; expected a tuple of 2: x, v"):
        refuse_invalid_model(replace(cart_model, stages=stages))


def test_a_model_that_asks_for_an_unknown_name_is_reported_the_nearest(cart_model):
    def drag(v: float, kk: float) -> tuple[float]:
        return (-kk * v,)

    wrong = Cause("drag", "Drag.", {"force": drag}, (Parameter("k", "N s", 1.0, 0.0, 2.0, ""),))
    with pytest.raises(
        InputError, match=r"cause drag: drag: found argument 'kk'.*Did you mean 'k'"
    ):
        refuse_invalid_model(replace(cart_model, causes=(wrong,)))


def test_a_misspelt_stage_is_named(cart_model):
    wrong = replace(cart_model.causes[0], hooks={"forces": cart_model.causes[0].hooks["force"]})
    with pytest.raises(InputError, match=r"stage 'forces'.*expected an open stage.*'force'"):
        refuse_invalid_model(replace(cart_model, causes=(wrong,)))


def test_a_tuple_of_one_without_its_comma_is_named(cart_model):
    for part in ("causes", "inputs", "coefficients"):
        (kind,) = {type(x).__name__ for x in getattr(cart_model, part)}
        with pytest.raises(InputError, match=f"{part}: found a single {kind}.*needs a comma"):
            refuse_invalid_model(replace(cart_model, **{part: getattr(cart_model, part)[0]}))


def test_a_coefficient_that_no_equation_asks_for_is_named(cart_model):
    more = (*cart_model.coefficients, Parameter("m", "kg", 1.0, 0.1, 5.0, "mass"))
    with pytest.raises(InputError, match="coefficient m: found no equation that asks for it"):
        refuse_invalid_model(replace(cart_model, coefficients=more))


def test_an_accuracy_that_is_text_is_named(cart_model):
    wrong = (Observation("position", "m", "1e-3"),)
    with pytest.raises(InputError, match="position: std: found '1e-3'; expected a number"):
        refuse_invalid_model(replace(cart_model, observations=wrong))


@pytest.mark.parametrize(
    ("text", "message"),
    [("MODEL = 3", "MODEL: found int; expected MODEL"),
     ("import nothing_of_that_name", "line 1: found ModuleNotFoundError"),
     ("def f(:\n", "line 1: found SyntaxError"), ("x = 1", "found no such name")],
)  # fmt: skip
def test_a_file_without_a_model_is_named(text, message, tmp_path):
    path = tmp_path / "model.py"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        load_model(path)


# faulty data sets: each one message


def write_data_folder(
    path: Path, rows: str | bytes | None = None, settings: str | None = None
) -> Path:
    """A data set of one run; `rows` and `settings` replace its csv and data.yaml."""
    lines = [f"{0.05 * k:.2f},{0.01 * k:.3f},1.0" for k in range(30)]
    path.mkdir(exist_ok=True)
    text = rows if rows is not None else "\n".join(["t,x,u", *lines])
    (path / "run.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    (path / "data.yaml").write_text(settings if settings is not None else VALID_SETTINGS)
    return path


VALID_SETTINGS = """columns:
  time: {column: t, unit: s}
  position: {column: x, unit: m}
  push: {column: u, unit: N}
"""


def csv_text(change: int, line: str) -> str:
    lines = ["t,x,u", *(f"{0.05 * k:.2f},{0.01 * k:.3f},1.0" for k in range(30))]
    lines[change] = line
    return "\n".join(lines)


FAULTY_FOLDERS = {
    "no settings": (None, "", "found NoneType; expected keys columns"),
    "not a yaml": (None, "columns: [", "expected a yaml file"),
    "unknown key": (None, VALID_SETTINGS + "colums: {}\n", "'colums'.*Did you mean 'columns'"),
    "no columns": (None, "constants: {}\n", "expected an entry for each of time, push, position"),
    "missing column entry": (
        None,
        VALID_SETTINGS.replace("  push: {column: u, unit: N}\n", ""),
        "no 'push'",
    ),
    "unknown entry": (
        None,
        VALID_SETTINGS + "  pusch: {column: u, unit: N}\n",
        "'pusch'.*Did you mean 'push'",
    ),
    "wrong unit": (
        None,
        VALID_SETTINGS.replace("unit: m}", "unit: kg}"),
        "unit 'kg'; expected a unit of 'm'",
    ),
    "no such column": (None, VALID_SETTINGS.replace("column: x", "column: y"), "no column 'y'"),
    "no such file": (
        None,
        VALID_SETTINGS + "trials: [{file: other.csv}]\n",
        "other.csv: found no such file",
    ),
    "bad role": (
        None,
        VALID_SETTINGS + "trials: [{file: run.csv, role: test}]\n",
        "'test'; expected 'fit'",
    ),
    "all held out": (
        None,
        VALID_SETTINGS + "trials: [{file: run.csv, role: held_out}]\n",
        "all trials held out",
    ),
    "two of one name": (
        None,
        VALID_SETTINGS + "trials: [{file: run.csv}, {file: run.csv}]\n",
        "two trials of that name",
    ),
    "unknown constant": (
        None,
        VALID_SETTINGS + "constants: {mass: 2}\n",
        "'mass'.*The model has none",
    ),
    "constant that is text": (
        None,
        VALID_SETTINGS + "constants: {mass: heavy}\n",
        "'heavy'; expected a number",
    ),
    "words in a column": (csv_text(7, "0.30,far,1.0"), None, "row 8, column x: found 'far'"),
    "times go back": (csv_text(7, "0.10,0.06,1.0"), None, "sample 6.*expected increasing times"),
    "a time is missing": (csv_text(7, ",0.06,1.0"), None, "time, sample 6.*expected finite times"),
    "an input is missing": (csv_text(7, "0.30,0.06,"), None, "push, sample 6: found nan"),
    "an infinite place": (csv_text(7, "0.30,inf,1.0"), None, "position, sample 6: found inf"),
    "too short": ("t,x,u\n0,0,0\n1,0,0\n", None, "3 samples or more"),
    "empty file": ("", None, "expected a csv with a header"),
    "samples of one trial": ("t,x,u\n0,0,0\n", None, "found 1 samples; expected 3"),
    "header alone": ("t,x,u\n", None, "found 0 samples"),
    "two columns of one name": (
        csv_text(0, "t,x,x,u").replace(",1.0", ",9.0,1.0"),
        None,
        "header: found two columns 'x'",
    ),
    "no header": (csv_text(0, "0.00,0.00,1.0"), None, "no column 't', 'u', 'x'.*The first row is"),
    "more cells than names": (
        csv_text(0, "t,x,u").replace(",1.0", ",1.0,7"),
        None,
        "3 names above 4",
    ),
    "a row of units": (csv_text(1, "s,m,N"), None, "row 2, column t: found 's'; expected a number"),
    "wide characters": (csv_text(0, "t,x,u").encode("utf-16"), None, "expected a csv.*in UTF-8"),
    "a map of trials": (
        None,
        VALID_SETTINGS + "trials: {file: run.csv}\n",
        "expected a list of {file",
    ),
    "a list of evidence": (
        None,
        VALID_SETTINGS + "trials: [{file: run.csv, evidence: [1, 2]}]\n",
        r"run.csv: evidence: found \[1, 2\]; expected {NAME",
    ),
    "a list of columns": (None, "columns: [t, x, u]\n", "expected an entry for each of time"),
    "a window beside the recording": (
        None,
        VALID_SETTINGS + "trials: [{file: run.csv, start_s: 8}]\n",
        "no sample from 8 to inf s; expected times within those of the file, 0 to 1.45 s",
    ),
    "nothing seen": (
        "t,x,u\n" + "\n".join(f"{k},,1" for k in range(30)),
        None,
        "position: found 0 values",
    ),
}


@pytest.mark.parametrize("name", FAULTY_FOLDERS)
def test_a_faulty_data_set_is_reported_in_one_message(name, cart_model, tmp_path):
    table, settings, message = FAULTY_FOLDERS[name]
    with pytest.raises(InputError, match=message) as raised:
        validated_trials(
            cart_model, read_trials(cart_model, write_data_folder(tmp_path, table, settings))
        )
    assert len(raised.value.findings) == 1
    assert len(str(raised.value).splitlines()) == 1


@pytest.mark.parametrize(
    "written",
    [lambda s: s.replace(",", ";").replace(".", ","), lambda s: s.replace(",", "\t"),
     lambda s: "\ufeff" + s, lambda s: s.replace("\n", "\r\n"),
     lambda s: s.replace("t,x,u", "t , x , u")],
    ids=["decimal commas", "tabs", "byte order mark", "line ends", "spaces"],
)  # fmt: skip
def test_files_of_other_programs_are_read_as_they_are(written, cart_model, tmp_path):
    plain = csv_text(0, "t,x,u")
    (one,), (other,) = (read_trials(cart_model, write_data_folder(tmp_path / name, text))
                        for name, text in (("a", plain), ("b", written(plain))))  # fmt: skip
    for k in ("times", "observed", "inputs"):
        np.testing.assert_equal(getattr(other, k), getattr(one, k))


def test_arrays_of_the_wrong_shape_never_reach_compiled_code(cart_model):
    t = np.arange(30) * 0.1
    for times, seen, push in ((t, np.zeros((30, 2)), t), (t, np.zeros(29), t), (t, t, np.zeros(31)),
                              (t[:, None], t, t)):  # fmt: skip
        with pytest.raises(InputError, match="shape"):
            explain(cart_model, [Trial("t", times, {"position": seen}, {"push": push})])
    with pytest.raises(InputError, match="found 2 samples"):
        explain(cart_model, [Trial("t", t[:2], {"position": t[:2]}, {"push": t[:2]})])


def test_the_command_writes_json_text_and_page(cart_model, tmp_path):
    data = tmp_path / "data"
    data.mkdir()
    for t in simulated_runs(drag=0.8):
        np.savetxt(data / f"{t.name}.csv", np.column_stack([t.times, t.observed["position"] * 1000,
                                                            t.inputs["push"]]),
                   delimiter=",", header="t,x,u", comments="")  # fmt: skip
    (data / "data.yaml").write_text(
        VALID_SETTINGS.replace("column: x, unit: m", "column: x, unit: mm")
    )
    out = tmp_path / "out"
    result = CliRunner().invoke(main, ["explain", str(MODEL_FILE), str(data), "--out", str(out),
                                       "--predict", str(data), "--quiet"])  # fmt: skip
    assert result.exit_code == 0, result.output
    content = json.loads((out / "explanation.json").read_text())
    assert [c["name"] for c in content["causes"]] == ["quadratic_drag"]
    assert content["prediction"]["runs"]
    page = (out / "report.html").read_text()
    assert "quadratic_drag" in page
    assert "data:image/png" in page
    assert "quadratic_drag" in result.output


def test_a_start_from_which_the_model_runs_away_is_reported(cart_model):
    driven = Parameter("c", "1/s", -500.0, -900.0, 5.0, "drag")
    with pytest.raises(InputError, match=r"runs away.*Check signs and units"):
        explain(replace(cart_model, coefficients=(driven,)), simulated_runs())


def test_states_and_stages_are_classes_of_the_model():
    assert State("x", "m", 1.0).observed == ""
    assert Stage("force", ("F",), open=True).function is None

"""The boundary of `bluekoi.explain`: whatever comes in is taken whole or refused in a message."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from bluekoi.errors import InputError
from bluekoi.explain import Model, Observation, Trial, load_model, read_trials
from bluekoi.explain.checks import refuse_invalid_model
from bluekoi.explain.feedback import input_share_from_innovations
from bluekoi.explain.recording_warnings import time_unit_warnings
from bluekoi.explain.trials import validated_trials

CART = Path(__file__).parent / "cart_model.py"
MODEL = load_model(CART)
DRIVE = load_model(Path(__file__).parents[1] / "examples/drive/model.py")
SAMPLE_COUNT = 20
FEW_EXAMPLES = settings(max_examples=150, deadline=None,
               suppress_health_check=[HealthCheck.function_scoped_fixture])  # fmt: skip

numbers = st.floats(allow_nan=True, allow_infinity=True, width=64)
shapes = arrays.array_shapes(min_dims=0, max_dims=2, min_side=0, max_side=SAMPLE_COUNT + 1)
columns = st.one_of(
    arrays.arrays(np.float64, shapes, elements=numbers),
    arrays.arrays(np.float64, SAMPLE_COUNT, elements=st.floats(-10, 10)),
)
names = st.sampled_from(["position", "positon", "push", "pusch", "x", "v", "c", ""])
plain = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(-9, 9), numbers, st.text(max_size=5), names),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(
        st.one_of(names, st.sampled_from(["file", "column", "unit", "evidence"])), inner,
        max_size=3)),
    max_leaves=8,
)  # fmt: skip


def valid_trial() -> Trial:
    return Trial("t", 0.1 * np.arange(SAMPLE_COUNT), {"position": np.linspace(0, 1, SAMPLE_COUNT)},
                 {"push": np.ones(SAMPLE_COUNT)})  # fmt: skip


def refusal_message(call: Callable[[], object]) -> InputError | None:
    """What a call is refused with; any other exception passes."""
    try:
        call()
    except InputError as error:
        return error
    return None


def check_or_refuse(model: Model, trials: list[Trial]) -> list[Trial] | None:
    """Checked trials; None where they are refused, one line a finding."""
    error = refusal_message(lambda: validated_trials(model, trials))
    if error is None:
        return validated_trials(model, trials)
    assert error.findings
    assert len(str(error).splitlines()) == len(error.findings)
    return None


def read_or_refused(folder: Path) -> str:
    """Trials of a folder are read and checked, or refused with findings: which of the two."""
    error = refusal_message(lambda: read_trials(MODEL, folder))
    if error is None:
        check_or_refuse(MODEL, read_trials(MODEL, folder))
        return "read"
    assert error.findings
    return "refused"


@FEW_EXAMPLES
@given(times=columns, position=columns, push=columns)
def test_arrays_of_any_shape_and_content_are_refused_or_whole(times, position, push):
    found = check_or_refuse(MODEL, [Trial("t", times, {"position": position}, {"push": push})])
    if found is not None:
        (one,) = found
        assert one.times.shape == one.observed["position"].shape == one.inputs["push"].shape
        assert np.isfinite(one.times).all()
        assert np.isfinite(one.inputs["push"]).all()
        assert (np.diff(one.times) > 0).all()
        assert not np.isinf(one.observed["position"]).any()


@FEW_EXAMPLES
@given(at=st.integers(0, SAMPLE_COUNT - 1), value=numbers, which=st.sampled_from(["times", "push"]))
def test_one_wrong_time_or_input_is_refused(at, value, which):
    trial = valid_trial()
    column = (trial.times if which == "times" else trial.inputs["push"]).copy()
    column[at] = value
    changed = (replace(trial, times=column) if which == "times"
               else replace(trial, inputs={"push": column}))  # fmt: skip
    usable = np.isfinite(value) and abs(value) <= 1e12
    if which == "times":
        usable = np.isfinite(value) and bool((np.diff(column) > 0).all())
    assert (check_or_refuse(MODEL, [changed]) is not None) == usable


@FEW_EXAMPLES
@given(
    observed=names,
    driven=names,
    constants=st.dictionaries(names, numbers, max_size=2),
    start=st.dictionaries(names, numbers, max_size=2),
    role=st.sampled_from(["fit", "fitt"]),
)
def test_misspelt_names_are_refused(observed, driven, constants, start, role):  # fmt: skip
    trial = replace(
        valid_trial(),
        observed={observed: np.zeros(SAMPLE_COUNT) + 0.1 * np.arange(SAMPLE_COUNT)},
        inputs={driven: np.ones(SAMPLE_COUNT)},
        constants=constants,
        start=start,
        role=role,
    )
    right = (observed, driven, role) == ("position", "push", "fit") and not constants
    right = right and set(start) <= {"x", "v"} and all(map(np.isfinite, start.values()))
    assert (check_or_refuse(MODEL, [trial]) is not None) == right


VALID_SETTINGS = {
    "columns": {
        "time": {"column": "t", "unit": "s"},
        "position": {"column": "x", "unit": "m"},
        "push": {"column": "u", "unit": "N"},
    }
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("data")
    rows = "\n".join(f"{0.1 * k:.1f},{0.01 * k:.2f},1.0" for k in range(SAMPLE_COUNT))
    (path / "run.csv").write_text(f"t,x,u\n{rows}\n")
    return path


@FEW_EXAMPLES
@given(
    key=st.sampled_from(["columns", "constants", "trials", "position", "unit", "trial"]),
    value=plain,
    name=st.sampled_from(["condition", "role", "start_s", "evidence", "file"]),
)
def test_any_data_yaml_is_refused_or_read(key, value, name, folder):  # fmt: skip
    content = {k: dict(v) for k, v in VALID_SETTINGS.items()}
    if key == "position":
        content["columns"]["position"] = value
    elif key == "unit":
        content["columns"]["position"] = {"column": "x", "unit": value}
    elif key == "trial":
        content["trials"] = [{"file": "run.csv", name: value}]
    else:
        content[key] = value
    (folder / "data.yaml").write_text(yaml.safe_dump(content))
    assert read_or_refused(folder) in {"read", "refused"}


@FEW_EXAMPLES
@given(text=st.one_of(st.binary(max_size=200), st.text("t,xu0123.;\t\n\"' -eNA", max_size=200).map(
    lambda rows: ("t,x,u\n" + rows).encode())))  # fmt: skip
def test_any_csv_is_refused_or_read(text, folder):
    (folder / "data.yaml").write_text(
        yaml.safe_dump(VALID_SETTINGS | {"trials": [{"file": "any.csv"}]})
    )
    (folder / "any.csv").write_bytes(text)
    assert read_or_refused(folder) in {"read", "refused"}


def test_an_angle_in_degrees_that_is_declared_in_radians_is_refused():
    model = replace(MODEL, observations=(Observation("position", "rad", 0.01, angle=True),))
    turning = (np.degrees(np.linspace(0, 6, SAMPLE_COUNT)) + 180) % 360 - 180
    trial = replace(valid_trial(), observed={"position": turning})
    with pytest.raises(InputError, match=r"a jump by 3\d\d rad.*unit: deg"):
        validated_trials(model, [trial])
    right = replace(valid_trial(), observed={"position": np.radians(turning)})
    assert validated_trials(model, [right])


def test_a_wrong_unit_of_time_is_reported():
    trials = [valid_trial()]
    assert time_unit_warnings(trials, 2.0) == []
    (coarse,) = time_unit_warnings(
        [replace(valid_trial(), times=100.0 * np.arange(SAMPLE_COUNT))], 2.0
    )
    assert "100 s apart" in coarse
    assert "unit of time" in coarse
    (short,) = time_unit_warnings(
        [replace(valid_trial(), times=1e-4 * np.arange(SAMPLE_COUNT))], 2.0
    )
    assert "lasts 0.0019 s" in short


def closed_loop_run(
    gain: float, delay: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Input and innovations of x' = 0.9 x + u + random, u = reference - gain x seen before."""
    places, inputs, innovations = [0.0] * (delay + 1), [], [[0.0]]
    for wish in np.repeat(rng.standard_normal(80), 5):
        inputs.append(wish - gain * places[-1 - delay])
        innovations.append([rng.standard_normal()])
        places.append(0.9 * places[-1] + inputs[-1] + innovations[-1][0])
    return np.array(inputs), np.array(innovations[:-1])


@pytest.mark.parametrize(("delay", "held"), [(0, True), (1, True), (1, False)])
def test_an_input_that_a_controller_makes_is_recognised(delay, held):
    rng = np.random.default_rng(5)
    closed, free = ([closed_loop_run(gain, delay, rng) for _ in range(4)] for gain in (0.5, 0.0))
    assert input_share_from_innovations(*zip(*closed, strict=True), held=held) > 0.1
    assert input_share_from_innovations(*zip(*free, strict=True), held=held) == 0.0


@pytest.mark.parametrize("value", [0.2617993877991494, 1 / 3, 1e6 / 7])
def test_an_input_that_never_changes_follows_nothing(value):
    rng = np.random.default_rng(2)
    inputs = [np.full(n, value) for n in (160, 173, 151)]
    errors = [rng.normal(size=(len(u), 3)) for u in inputs]
    assert input_share_from_innovations(inputs, errors, held=True) == 0.0


BOUNDS_CHECKED = """
import numpy as np
from bluekoi.explain import load_model
from bluekoi.explain.system_assembly import assemble_system
from bluekoi.explain.trials import as_trial_series
from bluekoi.fitting import filter_series, free_runs
from bluekoi.explain.preparation import initial_noise
from bluekoi.integrate import compile_system
from bluekoi.explain import Trial
from numba import config

assert config.DISABLE_JIT == 1
model = load_model(__import__("pathlib").Path({path!r}))
assembly = assemble_system(model)
kernel = compile_system(assembly.system)
series = []
for n in (4, 7, 33):
    t = 0.05 * np.arange(n)
    trial = Trial(str(n), t, {{"position": np.where(np.arange(n) % 3, t, np.nan)}}, {{"push": t}})
    series.append(as_trial_series(model, assembly, trial, {{}}))
values = [assembly.system.parameter_vector({{}})] * len(series)
noise = initial_noise(kernel, series, values[0])
for one, value in zip(series, values):
    print(filter_series(kernel, one, value, noise).log_likelihood)
for run in free_runs(kernel, series, values, open_states=2):
    print(float(np.abs(run.observed).max()))
"""


def test_compiled_code_stays_within_its_arrays():
    """Filter and simulation of trials of different lengths, interpreted instead of compiled: an
    index beyond an array raises there, and both ways give the same numbers.
    """
    code = BOUNDS_CHECKED.format(path=str(CART))
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True,
                          text=True, check=False)  # fmt: skip
    assert done.returncode == 0, done.stderr
    checked = [float(line) for line in done.stdout.split()]
    plain_code = code.replace("assert config.DISABLE_JIT == 1", "")
    other = subprocess.run([sys.executable, "-c", plain_code], capture_output=True, text=True,
                           check=True)  # fmt: skip
    assert len(checked) == 6
    np.testing.assert_allclose(checked, [float(line) for line in other.stdout.split()], rtol=1e-9)


def test_the_tutorials_model_is_the_examples(tmp_path):
    """The first python block of docs/own_models.md is a model file, with causes of the example."""
    root = Path(__file__).parents[1]
    text = (root / "docs" / "own_models.md").read_text()
    (tmp_path / "model.py").write_text(text.split("```python\n")[1].split("```")[0])
    written, example = (
        load_model(tmp_path / "model.py"),
        load_model(root / "examples/drive/model.py"),
    )
    assert written.coefficients == example.coefficients
    assert [s.name for s in written.states] == [s.name for s in example.states]
    assert [c.name for c in written.causes] == [c.name for c in example.causes][:2]
    for one, other in zip(written.causes, example.causes, strict=False):
        assert one.parameters == other.parameters


def test_a_model_file_that_ends_the_program_is_refused(tmp_path):
    path = tmp_path / "model.py"
    path.write_text("import sys\nsys.exit(0)\n")
    with pytest.raises(InputError, match=r"line 2: found SystemExit: 0; expected a file that runs"):
        load_model(path)


def test_a_number_that_no_equation_computes_with_is_refused():
    """Its argument is there, but the trials say nothing on it."""

    def dry(v: float, F_c: float, v_s: float) -> tuple[float]:
        return (-F_c * math.copysign(1.0, v),)

    cause = replace(next(c for c in DRIVE.causes if c.name == "coulomb_friction"),
                    hooks={"force": dry})  # fmt: skip
    with pytest.raises(InputError, match="coulomb_friction: v_s: found a number that no equation"):
        refuse_invalid_model(replace(DRIVE, causes=(cause,)))
    refuse_invalid_model(DRIVE)

"""Recordings whose accuracy is stated wrongly, or of which one trial is unlike the others."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.integrate import solve_ivp

from bluekoi.cli import main
from bluekoi.errors import InputError
from bluekoi.explain import Parameter, State, Trial, explain, load_model
from bluekoi.explain.comparison import HeldOutErrors, unconfirmed_causes_sentence
from bluekoi.explain.fit_quality import MAX_ERROR_OVER_STATED
from bluekoi.explain.preparation import prepare_cause_search, with_correlation_times_above_frame
from bluekoi.explain.results_json import verdict_sentence
from bluekoi.explain.trials import split_trials_at_gaps
from bluekoi.fitting import Noise
from bluekoi.fitting.linear import NoiseGradient
from bluekoi.fitting.noise import _log_gradient

MODEL = load_model(Path(__file__).parent / "cart_model.py")
TRUE_DRAG, NOISE_M = 1.2, 0.02


def cart_trials(count: int = 4, duration_s: float = 8.0, flipped: int = -1) -> list[Trial]:
    """Runs of the cart with quadratic drag, an input held over 0.04 s, and white errors 20 times
    as large as the model states. flipped: a trial whose input is recorded with the wrong sign.
    """
    rng, times = np.random.default_rng(5), np.arange(0.0, duration_s, 0.04)
    out = []
    for k in range(count):
        push = 2.0 * np.sign(np.sin((0.7 + 0.3 * k) * times + k))

        def rates(t: float, y: np.ndarray, push: np.ndarray = push) -> list[float]:
            u = push[min(int(t / 0.04 + 1e-9), len(push) - 1)]
            return [y[1], u - 0.3 * y[1] - TRUE_DRAG * y[1] * abs(y[1])]

        path = solve_ivp(rates, (0, times[-1]), [0.0, 0.0], t_eval=times, max_step=0.01).y[0]
        seen = {"position": path + rng.normal(0, NOISE_M, len(times))}
        out.append(Trial(f"r{k}", times, seen, {"push": -push if k == flipped else push}))
    return out


def test_errors_20_times_as_large_as_stated_do_not_become_a_force():
    """Without random forces in the recordings, their estimate must go to 0: while it stayed, a
    force in proportion to the input, which only rescales the model, seemed to explain it.
    """
    found = explain(MODEL, cart_trials())
    assert [c.name for c in found.named] == ["quadratic_drag"]
    assert found.verdict == "physics"
    assert found.unexplained < 0.2
    (drag,) = (n for n in found.numbers if n.label == "quadratic_drag.k")
    assert drag.value == pytest.approx(TRUE_DRAG, abs=max(3 * drag.std, 0.05))
    (text,) = (w for w in found.warnings if w.startswith("The errors of position"))
    assert "estimated as 20 times the stated ones" in text
    assert MAX_ERROR_OVER_STATED < 20


def test_a_trial_whose_input_has_the_wrong_sign_is_named():
    found = explain(MODEL, cart_trials(flipped=2))
    assert found.verdict in ("none", "unexplained")
    assert not verdict_sentence(found).startswith("No mismatch beyond the noise")
    (text,) = (w for w in found.warnings if w.startswith("Parameters vary between trials"))
    assert "Most of it comes from r2" in text


def test_white_noise_can_grow_from_its_lower_bound():
    """The slope of the scale at its bound is dropped only where it points below the bound."""
    kernel = prepare_cause_search(
        MODEL, cart_trials(duration_s=3.0), (), lambda _: None
    ).problem.kernel
    noise = Noise(np.full(3, 0.1), np.full(3, 0.5), np.ones(1), least_scale=1.0)
    slopes = NoiseGradient(0.0, np.zeros(3), np.zeros(3), np.array([7.0]))
    assert _log_gradient(kernel, noise, slopes)[-1] == 7.0
    assert _log_gradient(kernel, noise, replace(slopes, scale=np.array([-7.0])))[-1] == 0.0


def rates_with_fast_state(v: float, push: float, F: float, w: float, z: float):
    """A third state that decays within 2 ms."""
    return v + w, push + F, -z / 0.002


def test_a_state_faster_than_a_sample_is_integrated_in_small_steps():
    stages = tuple(
        replace(s, outputs=("x", "v", "z"), function=rates_with_fast_state)
        if s.name == "rates" else s for s in MODEL.stages
    )  # fmt: skip
    model = replace(MODEL, name="fast", stages=stages, states=(*MODEL.states, State("z", "1", 0.1)))
    ready = prepare_cause_search(model, cart_trials(duration_s=3.0), (), lambda _: None)
    assert ready.step_s == pytest.approx(0.002, rel=0.1)


def test_random_parts_stay_correlated_over_a_frame():
    slow = with_correlation_times_above_frame(MODEL, 0.4)
    assert slow.error_s[:2] == (0.4, 0.4)
    assert slow.random_force_s[:2] == (0.5, 0.4)
    assert with_correlation_times_above_frame(MODEL, 0.001).error_s == MODEL.error_s


def write_folder(folder: Path, trials: list[Trial]) -> Path:
    folder.mkdir()
    for t in trials:
        rows = np.column_stack([t.times, t.observed["position"], t.inputs["push"]])
        np.savetxt(folder / f"{t.name}.csv", rows, delimiter=",", header="t,x,u", comments="")
    (folder / "data.yaml").write_text(
        "columns:\n  time: {column: t, unit: s}\n  position: {column: x, unit: m}\n"
        "  push: {column: u, unit: N}\n"
    )
    return folder


def refusal(*words: object) -> str:
    path = str(Path(__file__).parent / "cart_model.py")
    found = CliRunner().invoke(main, ["explain", path, *map(str, words)])
    assert found.exit_code == 1, found.output
    return found.output


def test_what_cannot_be_written_or_predicted_is_refused_before_the_fit(tmp_path):
    data = write_folder(tmp_path / "data", cart_trials(2, 3.0))
    other = write_folder(tmp_path / "other", cart_trials(2, 3.0))
    (tmp_path / "file").write_text("")
    assert "found a file; expected a folder for the results" in refusal(
        data, "--out", tmp_path / "file"
    )
    assert "two trials of that name" in refusal(data, "--predict", other, "--predict", other)
    assert "expected one longer than --known-s" in refusal(
        data, "--predict", other, "--known-s", 1000
    )
    assert "found a file; expected a folder with data.yaml" in refusal(data / "r0.csv")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"# \xe9\ncolumns: {}\n", "no text (byte 3 is not UTF-8)"),
        (b"columns: {}\ncolumns: {}\n", "the key 'columns' stands twice"),
    ],
)
def test_a_data_yaml_that_cannot_be_read_is_one_message(tmp_path, content, message):
    data = write_folder(tmp_path / "data", cart_trials(2, 3.0))
    (data / "data.yaml").write_bytes(content)
    assert message in refusal(data)


def model_with_coefficient(tmp_path: Path, change: tuple[str, str]) -> Path:
    text = (Path(__file__).parent / "cart_model.py").read_text()
    assert change[0] in text
    path = tmp_path / "changed_cart.py"
    path.write_text(text.replace(*change))
    return path


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('"1/s", 0.5, 0.0', '"1/s", "0.5", 0.0'), "coefficient c: start: found '0.5'"),
        (("return (-c * v,)", "raise ValueError('boom')"), "linear_drag: found ValueError: boom"),
        (("return (-c * v,)", "raise SystemExit(0)"), "linear_drag: found SystemExit: 0"),
    ],
    ids=["text for a number", "an error in an equation", "an exit in an equation"],
)
def test_the_first_message_on_a_faulty_model_is_its_fault(tmp_path, change, message):
    with pytest.raises(InputError) as refused:
        load_model(model_with_coefficient(tmp_path, change))
    assert message in str(refused.value).splitlines()[0]
    assert isinstance(MODEL.coefficients[0], Parameter)


def test_no_candidate_left_and_recordings_of_the_fit_are_noted(tmp_path):
    data = write_folder(tmp_path / "data", cart_trials(4, 3.0))
    path = str(Path(__file__).parent / "cart_model.py")
    words = ["--predict", str(data), "--candidates", "", "--out", str(tmp_path / "out"), "--quiet"]
    found = CliRunner().invoke(main, ["explain", path, str(data), *words])
    assert found.exit_code == 0, found.output
    assert "Note: No candidate cause was tested" in found.output
    assert "their errors are no predictions" in found.output


def with_gap(trial: Trial, first_s: float, last_s: float) -> Trial:
    kept = (trial.times < first_s) | (trial.times >= last_s)
    return replace(
        trial,
        times=trial.times[kept],
        observed={n: c[kept] for n, c in trial.observed.items()},
        inputs={n: c[kept] for n, c in trial.inputs.items()},
    )


def test_a_gap_in_the_inputs_does_not_spoil_the_other_trials():
    trials = cart_trials()
    trials[1] = with_gap(trials[1], 2.0, 6.0)
    parts = split_trials_at_gaps(MODEL, trials)
    assert [t.name for t in parts] == ["r0", "r1/1", "r1/2", "r2", "r3"]
    assert [t.condition for t in parts[1:3]] == ["r1", "r1"]
    assert [len(t.times) for t in parts[1:3]] == [50, 50]
    found = explain(MODEL, trials)
    assert [c.name for c in found.named] == ["quadratic_drag"]
    assert any(w.startswith("r1: a gap of") and w.endswith("fitted apart.") for w in found.warnings)


def test_times_in_packets_are_not_cut_and_a_measurement_of_a_whole_trial_counts_once():
    (trial,) = cart_trials(1)
    packets = 0.5 * np.floor(trial.times / 0.5) + 1e-6 * np.arange(len(trial.times))
    grouped = replace(trial, times=packets)
    assert split_trials_at_gaps(MODEL, [grouped]) == [grouped]
    measured = replace(with_gap(trial, 2.0, 6.0), evidence={"mass": (1.0, 0.1)})
    assert [t.evidence for t in split_trials_at_gaps(MODEL, [measured])] == [
        {"mass": (1.0, 0.1)},
        {},
    ]


def test_a_gap_without_inputs_is_not_cut():
    free = replace(MODEL, inputs=())
    trials = [with_gap(t, 2.0, 6.0) for t in cart_trials(1)]
    assert split_trials_at_gaps(free, trials) == trials


def test_errors_far_smaller_than_stated_are_a_warning():
    rough = replace(MODEL, observations=(replace(MODEL.observations[0], std=0.5),))
    found = explain(rough, cart_trials(4, 4.0))
    assert any(w.startswith("The stated std of position, 0.5 m, is") for w in found.warnings)


def with_unit_factor(trials: list[Trial], factor: float) -> list[Trial]:
    """Trials whose positions are recorded in another unit than is declared."""
    return [replace(t, observed={"position": factor * t.observed["position"]}) for t in trials]


def test_positions_in_mm_declared_as_m_end_before_any_cause_is_fitted():
    trials, steps = with_unit_factor(cart_trials(), 1000.0), []
    with pytest.raises(InputError, match="all trials: position: found errors of about"):
        explain(MODEL, trials, progress=steps.append)
    assert "quadratic_drag" not in " ".join(steps)


def test_the_one_trial_in_another_unit_is_named():
    first, *others = cart_trials()
    with pytest.raises(InputError, match=r"trial r0: position: .* Check the unit"):
        explain(MODEL, [*with_unit_factor([first], 1000.0), *others])


@pytest.mark.parametrize(
    ("extended", "said"),
    [
        ({"path_rmse": 0.2, "x_rmse": 0.1}, True),
        ({"path_rmse": 0.1, "x_rmse": 0.9}, False),
        ({"path_rmse": float("nan"), "x_rmse": 0.9}, False),
    ],
)
def test_named_causes_that_leave_the_held_out_path_no_better_are_said_to_be_unconfirmed(
    extended, said
):
    base = {"path_rmse": 0.15, "x_rmse": 0.2}
    held = HeldOutErrors(("T",), base, extended, base, ("trajectories",) * 2, 5.0)
    text = unconfirmed_causes_sentence(held)
    assert bool(text) == said
    if said:
        assert "do not confirm the named causes: path_rmse 0.2 with them and 0.15 without" in text

"""Rigid lengths as one measurement of all the camera's errors, however keypoints are labelled."""

from __future__ import annotations

import inspect
from dataclasses import asdict, replace

import numpy as np
import pytest

from bluekoi.camera.rigid_distances import RigidDistances
from bluekoi.camera.rigid_length_windows import (
    MAX_LENGTH_WINDOWS,
    window_means,
    windows_from_columns,
    windows_to_columns,
)
from bluekoi.files import to_json_types
from bluekoi.fitting import FreeParameter, SharedMeasurement, TrialSeries
from bluekoi.fitting.side_measurements import side_measurement_terms
from bluekoi.integrate import compile_system, elementwise
from bluekoi.mismatch.rigid_lengths import effects_that_change_lengths, rigid_length_measurement
from bluekoi.model import two_plate_system
from bluekoi.observation import CameraErrorInputs

SYSTEM = two_plate_system()
CAMERA_ERRORS = ("scale_error", "lens_error", "uncorrected_refraction", "sinking")
VIEW_CONSTANTS = asdict(CameraErrorInputs()) | {
    "L_pool": 2.6,
    "W_pool": 1.6,
    "x_cam": 1.3,
    "y_cam": 0.8,
    "bend": -0.05,
    "x_lens": 1.3,
    "y_lens": 0.8,
    "Q_lens": 2.33,
    "ax_lens": 0.0,
    "ay_lens": 0.0,
    "ahead": 0.0,
    "length_unit": 1.0,
    "time_unit": 1.0,
}
LENGTHS_M = (0.12, 0.04, 0.16)
LABEL_STD_M, TRIAL_STD, NOISE_M = 0.0007, 0.001, 0.0006


def simulated_lengths(
    rng: np.random.Generator, trials: int = 16, frames: int = 150
) -> RigidDistances:
    """Right lengths along circles all over the pool, labelled to 0.7 mm, in trials whose scale
    varies by 0.1 %, with noise.
    """
    rows: dict[str, list[np.ndarray]] = {name: [] for name in RigidDistances.__dataclass_fields__}
    labels = rng.normal(0, LABEL_STD_M, 3)
    for trial in range(trials):
        t = np.arange(frames) / 30.0
        turned = rng.uniform(0, 6) + rng.choice([-1, 1]) * 0.7 * t
        middle = np.array([1.3, 0.8]) + rng.uniform(-0.4, 0.4, 2)
        place = middle + 0.45 * np.column_stack([np.sin(turned), -np.cos(turned)])
        along = np.column_stack([np.cos(turned), np.sin(turned)])
        scale, ahead = rng.normal(0, TRIAL_STD), np.zeros((frames, 2))
        for pair, length in enumerate(LENGTHS_M):
            front, back = place - ahead, place - ahead - length * along
            ahead = ahead + length * along
            noise = rng.normal(0, NOISE_M, frames)
            excess = labels[pair] + scale * length + noise
            for name, values in {
                "front_m": front, "back_m": back, "excess_m": excess, "time_s": t,
                "std_m": np.full(frames, NOISE_M), "known_m": np.full(frames, length),
                "trial": np.full(frames, float(trial)), "pair": np.full(frames, float(pair)),
                "bend_rad": np.zeros(frames),
            }.items():  # fmt: skip
                rows[name].append(values)
    return RigidDistances(**{name: np.concatenate(parts) for name, parts in rows.items()})


def lengths_with_error(
    distances: RigidDistances, error: str, values: dict[str, float]
) -> RigidDistances:
    """The lengths as a camera with an error sees them, by the effect's own displacement of ends."""
    effect = SYSTEM.effect(error)
    known = {p.argument_name: p.start if i >= effect.strengths else 0.0
             for i, p in enumerate(effect.parameters)}  # fmt: skip
    known |= VIEW_CONSTANTS | {"cpsi": 0.0, "spsi": 0.0} | values
    names = effect.hooks["observe"].__code__.co_varnames[
        : effect.hooks["observe"].__code__.co_argcount
    ]
    moved, session = [], distances.trial / distances.trial.max()
    for end in (distances.front_m, distances.back_m):
        rows = [effect.hooks["observe"](
                    *[{**known, "x": x, "y": y, "t": t, "session_place": o}[n] for n in names])[:2]
                for (x, y), t, o in zip(end, distances.time_s, session, strict=True)]  # fmt: skip
        moved.append(end + np.array(rows))
    before = np.linalg.norm(distances.front_m - distances.back_m, axis=1)
    grown = np.linalg.norm(moved[0] - moved[1], axis=1) - before
    return replace(distances, excess_m=distances.excess_m + grown)


def length_measurement_of(distances: RigidDistances, *, trials: int = 16) -> SharedMeasurement:
    numbers = np.unique(distances.trial)
    found = rigid_length_measurement(
        SYSTEM, VIEW_CONSTANTS, window_means(distances), trials=trials, depth_given=True,
        session_places=dict(zip(map(int, numbers), numbers / numbers.max(), strict=True)),
    )  # fmt: skip
    assert found is not None
    return found


def estimated_strengths(
    found: SharedMeasurement, error: str
) -> tuple[np.ndarray, np.ndarray, float]:
    """Strengths of one error alone by least squares, their deviations, and the misfit left."""
    start = np.array([0.0 if is_strength(n) else SYSTEM.parameters[SYSTEM.parameter_index[n]].start
                      for n in found.parameters])  # fmt: skip
    own = [i for i, n in enumerate(found.parameters)
           if n.startswith(error + ".") and is_strength(n)]  # fmt: skip
    first = found.errors(start)
    J = np.column_stack([found.errors(start + np.eye(len(start))[i]) - first for i in own])
    value = -np.linalg.lstsq(J, first, rcond=None)[0]
    left = first + J @ value
    return value, np.sqrt(np.diag(np.linalg.inv(J.T @ J))), float(left @ left)


def is_strength(name: str) -> bool:
    effect = SYSTEM.effect(name.partition(".")[0])
    return name.partition(".")[2] in [p.name for p in effect.parameters[: effect.strengths]]


def test_lengths_distinguish_a_growing_depth_error_from_a_constant_one() -> None:
    """The error grows from 0, so that the mean shift is half the last one."""
    growing = lengths_with_error(simulated_lengths(np.random.default_rng(6)),
                                "uncorrected_refraction", {"k": 0.01, "d": 1.0})  # fmt: skip
    found = length_measurement_of(growing)
    shift, trend = (found.parameters.index(f"uncorrected_refraction.{name}")
                    for name in ("inward_shift", "session_trend"))  # fmt: skip
    values = np.array([0.0 if is_strength(n) else SYSTEM.parameters[SYSTEM.parameter_index[n]].start
                       for n in found.parameters])  # fmt: skip
    values[shift] = 0.01

    def misfit(d: float) -> float:
        values[trend] = d
        return float(np.sum(found.errors(values) ** 2))

    assert misfit(1.0) < misfit(0.0) - 20.0
    assert misfit(1.0) < misfit(-1.0) - 50.0


@pytest.mark.parametrize(
    ("error", "values"),
    [("scale_error", {"k": 0.02}), ("uncorrected_refraction", {"k": 0.03}),
     ("lens_error", {"k": 0.01}), ("lens_error", {"p_x": 0.006, "p_y": -0.004}),
     ("sinking", {"g": 0.004})],
)  # fmt: skip
def test_lengths_measure_each_error_of_the_camera_within_their_deviation(
    error: str, values: dict[str, float]
) -> None:
    found = length_measurement_of(
        lengths_with_error(simulated_lengths(np.random.default_rng(5)), error, values)
    )
    strengths = SYSTEM.effect(error).parameters[: SYSTEM.effect(error).strengths]
    truth = np.array([values.get(p.argument_name, 0.0) for p in strengths])
    value, std, misfit = estimated_strengths(found, error)
    assert np.all(np.abs(value - truth) < 3.5 * std)
    assert np.max(np.abs(truth) / std) > 5
    alike = {"scale_error", "uncorrected_refraction"}  # the same but for the edges of the picture
    others = [
        estimated_strengths(found, e)[2]
        for e in CAMERA_ERRORS
        if e != error and not {e, error} <= alike
    ]
    assert misfit < min(others) - 10


def test_right_lengths_speak_for_no_error_and_their_misfit_is_chi_squared() -> None:
    misfits, sizes = [], []
    for seed in range(20):
        found = length_measurement_of(
            simulated_lengths(np.random.default_rng(100 + seed), trials=10)
        )
        start = np.array(
            [
                0.0 if is_strength(n) else SYSTEM.parameters[SYSTEM.parameter_index[n]].start
                for n in found.parameters
            ]
        )
        errors = found.errors(start)
        misfits.append(float(errors @ errors))
        sizes.append(len(errors))
    assert 0.5 < np.sum(misfits) / np.sum(sizes) < 1.5
    assert np.max(misfits) < 35


def test_a_label_that_is_off_is_not_taken_for_an_error_of_scale() -> None:
    """Six millimetres on one pair: with a scale of its own the pair would say 5 %."""
    right = simulated_lengths(np.random.default_rng(8))
    off = replace(right, excess_m=right.excess_m + np.where(right.pair == 0, 0.006, 0.0))
    value, std, _ = estimated_strengths(length_measurement_of(off), "scale_error")
    assert abs(value[0]) < 3.5 * std[0]


@pytest.mark.parametrize("error", [{"p_x": 0.00005, "p_y": -0.00005}, {"k": 0.0002}])
def test_exact_lengths_do_not_show_errors_that_a_careful_calibration_leaves(
    error: dict[str, float],
) -> None:
    """Keypoints that were fitted to the stated lengths scatter by a few micrometres."""
    right = simulated_lengths(np.random.default_rng(9))
    scatter = np.random.default_rng(10).normal(0, 5e-6, len(right.excess_m))
    exact = replace(right, excess_m=scatter, std_m=np.full(len(scatter), 5e-6))
    found = length_measurement_of(lengths_with_error(exact, "lens_error", error))
    value, std, _ = estimated_strengths(found, "lens_error")
    assert np.all(np.abs(value) < 2.0 * std)


def test_effects_whose_displacement_varies_over_the_picture_stretch_lengths() -> None:
    assert {e.name for e in effects_that_change_lengths(SYSTEM)} == set(CAMERA_ERRORS)


def test_few_lengths_are_no_measurement() -> None:
    few = simulated_lengths(np.random.default_rng(1), trials=1, frames=40)
    found = rigid_length_measurement(
        SYSTEM, VIEW_CONSTANTS, window_means(few), trials=1, depth_given=True
    )
    assert found is None


def test_windows_keep_mean_and_information_and_survive_json() -> None:
    right = simulated_lengths(np.random.default_rng(2))
    windows = window_means(right)
    again = windows_from_columns(to_json_types(windows_to_columns(windows)))
    assert len(windows.excess_m) == 16 * 3 * 10
    assert np.sum(windows.std_m**-2) == pytest.approx(np.sum(right.std_m**-2))
    assert windows.excess_m.mean() == pytest.approx(right.excess_m.mean())
    assert again.front_m == pytest.approx(windows.front_m, abs=1e-6)


def test_windows_of_many_trials_grow_longer() -> None:
    many = simulated_lengths(np.random.default_rng(2), trials=250)
    assert len(window_means(many).excess_m) <= MAX_LENGTH_WINDOWS


def test_a_shared_measurement_counts_once_and_has_the_slopes_of_its_errors() -> None:
    kernel = compile_system(two_plate_system())
    found = length_measurement_of(
        lengths_with_error(simulated_lengths(np.random.default_rng(5)), "scale_error", {"k": 0.02})
    )
    n, states = len(kernel.system.observations), len(kernel.system.all_states)
    series = [TrialSeries(name, "", "", np.zeros(1), np.zeros((1, len(kernel.system.inputs))),
                          np.zeros(len(kernel.system.constants)), np.zeros((1, n)), np.eye(n)[None],
                          np.zeros(states), np.eye(states), shared=found)
              for name in map(str, range(16))]  # fmt: skip
    point = kernel.system.parameter_vector({})
    free = [FreeParameter("scale_error.length_error"), FreeParameter("C_T")]
    H, g, value = side_measurement_terms(kernel, series, free, [point] * 16)
    step, moved = 1e-4, point.copy()
    moved[kernel.system.parameter_index[free[0].name]] += step
    _, _, after = side_measurement_terms(kernel, series, free, [moved] * 16)
    assert (after.sum() - value.sum()) / step == pytest.approx(
        g.sum(axis=0)[0] - 0.5 * step * H.sum(axis=0)[0, 0], rel=1e-4
    )
    best = g.sum(axis=0)[0] / H.sum(axis=0)[0, 0]
    assert best == pytest.approx(estimated_strengths(found, "scale_error")[0][0], rel=1e-3)
    assert not g[:, 1].any()


@pytest.mark.parametrize(
    "effect", effects_that_change_lengths(SYSTEM), ids=lambda effect: effect.name
)
def test_displacements_of_arrays_equal_those_of_each_place(effect) -> None:
    rng = np.random.default_rng(8)
    function = effect.hooks["observe"]
    names = list(inspect.signature(function).parameters)
    sizes = {p.argument_name: p.start for p in effect.parameters}
    values = [rng.uniform(0.1, 2.0, 40) * sizes.get(name, 1.0) for name in names]
    at_once = elementwise(function)(*values)
    one_by_one = np.array([function(*row) for row in zip(*values, strict=True)])
    for column, found in zip(one_by_one.T, at_once, strict=True):
        assert np.broadcast_to(found, 40) == pytest.approx(column, rel=1e-12, abs=1e-15)

"""Recordings of others through `bluekoi.explain`: figures of docs/recordings.md."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.signal import butter, filtfilt

from bluekoi.explain import (
    CauseSearchResult,
    Trial,
    explain,
    load_model,
    predict,
    predict_left_out,
    read_trials,
)

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"

pytestmark = pytest.mark.recordings


def search_recording(name: str, folder: Path, **options) -> CauseSearchResult:
    model = load_model(EXAMPLES / name / "model.py")
    return explain(model, read_trials(model, folder), **options)


def named_causes(found: CauseSearchResult) -> set[str]:
    return {c.name for c in found.named}


def low_pass(values: np.ndarray, hz: float) -> np.ndarray:
    return filtfilt(*butter(4, hz / 500.0), values)


def test_the_drive_is_held_back_by_dry_friction_and_an_offset(recordings):
    table = pd.read_csv(recordings / "emps" / "drive.csv")
    t, x, force = table.to_numpy().T
    model = load_model(EXAMPLES / "drive" / "model.py")
    found = explain(model, [Trial("drive", t, {"position": x}, {"motor": force})])
    assert named_causes(found) == {"coulomb_friction", "offset"}
    assert found.unexplained < 0.5
    number = {n.label: n.value for n in found.numbers}
    v = np.gradient(low_pass(x, 50.0), t)
    friction = number["coulomb_friction.F_c"] * v / np.hypot(v, number["coulomb_friction.v_s"])
    modelled = (number["M"] * np.gradient(v, t) + number["F_v"] * v + friction
                - number["offset.F_0"])  # fmt: skip
    error, whole = (low_pass(f, 20.0)[200:-200] for f in (force - modelled, force))
    assert np.linalg.norm(error) < 0.048 * np.linalg.norm(whole)


def test_the_pendulum_is_stopped_by_viscous_friction(recordings):
    found = search_recording("pendulum", recordings / "pendulum")
    assert named_causes(found) == {"viscous_friction", "rate_scale", "zero_error"}
    number = {n.label: n.value for n in found.numbers}
    assert number["rate_scale.k"] == pytest.approx(-0.044, abs=0.006)
    assert found.held_out.extended["angle_rmse"] < 0.0118  # published for viscous friction


def test_spindowns_are_damped_by_the_square_and_read_by_a_gyro_off_zero(recordings):
    found = search_recording("yaw_coastdown", recordings / "yaw_coastdown")
    assert named_causes(found) == {"quadratic_yaw_damping", "gyro_bias"}
    number = {n.label: n for n in found.numbers}
    bias = number["gyro_bias.b"]
    compass = [t.evidence["compass"][0] for t in found.prepared.trials]
    assert bias.value == pytest.approx(np.mean(compass), abs=2 * bias.std)
    assert found.held_out.extended["rate_rmse"] <= 0.0067


@pytest.mark.long
def test_a_ship_fitted_to_zigzags_turns_in_circles(recordings):
    found = search_recording("ship_zigzag", recordings / "ship_zigzag")
    assert named_causes(found) >= {"speed_loss", "slipstream"}
    assert found.held_out.extended["path_rmse"] < 0.17 < found.held_out.baseline["path_rmse"]
    predicted = predict(found, [ship_turn(1.0), ship_turn(-1.0)], known_s=5.0)
    for run in predicted.runs["extended", "start from the first seconds"]:
        assert np.isfinite(run.simulated).all()
        assert 2.0 < run.measures["advance_m"] / 7.0 < 5.0
        assert 2.0 < run.measures["tactical_diameter_m"] / 7.0 < 5.0


@pytest.mark.long
def test_the_tracked_point_of_a_robotic_fish_is_ahead_of_its_centre_of_mass(recordings):
    """The causes that every search named (docs/recordings.md)."""
    found = search_recording("robotic_fish", recordings / "robotic_fish")
    assert named_causes(found) >= {"keypoint_bias", "thrust_line_offset"}
    number = {n.label: n.value for n in found.numbers}
    assert number["keypoint_bias.bx"] == pytest.approx(0.0095, abs=0.002)
    assert found.held_out.extended["path_rmse"] < found.held_out.baseline["path_rmse"]


def ship_turn(side: float) -> Trial:
    """A ship of 7 m that is put into a turn of 10 m radius by 35 degrees of rudder."""
    t = np.arange(0.0, 120.0, 0.5)
    turned = np.maximum(t - 15.0, 0.0)
    speed = np.where(t < 15.0, 1.18, 0.6)
    psi = side * 0.06 * turned
    x, y = (np.cumsum(speed * f(psi)) * 0.5 for f in (np.cos, np.sin))
    rudder = np.radians(np.where(t < 10.0, 0.0, -35.0 * side))
    return Trial(f"circle {side:g}", t, {"x_seen": x, "y_seen": y, "heading": psi},
                 {"rudder": rudder})  # fmt: skip


def test_balls_are_held_back_by_air_and_seen_in_perspective(recordings):
    found = search_recording("ball_drops", recordings / "ball_drops")
    assert named_causes(found) == {"air_drag", "perspective"}
    number = {n.label: n.value for n in found.numbers}
    assert 0.25 < number["air_drag.C"] < 0.5
    runs = predict_left_out(found, known_s=2.0).runs["extended", "start from the first seconds"]
    square = {r.trial: r.errors["height_rmse"] ** 2 for r in runs}
    better = [square[f"{ball} 1"] < published for ball, published in PUBLISHED_M2.items()]
    assert sum(better) >= 7


PUBLISHED_M2 = {
    "Baseball": 0.300, "Blue Basketball": 0.620, "Green Basketball": 0.088, "Volleyball": 0.111,
    "Bowling Ball": 0.413, "Golf Ball": 0.009, "Tennis Ball": 0.091, "Whiffle Ball 1": 1.58,
    "Whiffle Ball 2": 1.175, "Yellow Whiffle Ball": 0.428, "Orange Whiffle Ball": 17.2,
}  # fmt: skip
"""Mean square errors (m2) over the frames after 2 s of each ball's first drop, of expressions found
in the frames until 2 s of that drop. Source: Sun, Liu, Wang and Sun, Symbolic Physics Learner, ICLR
(2023)."""

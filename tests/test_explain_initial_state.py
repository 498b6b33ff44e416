"""Initial states of trials from their first samples."""

from __future__ import annotations

import numpy as np
import pytest

from bluekoi.explain.initial_state import MAX_START_SAMPLES, initial_level_and_slope

STEP_S, NOISE = 0.02, 1e-3
TIMES = STEP_S * np.arange(50)
MOTOR_TIME_CONSTANT_S, MOTOR_START_RAD_S2 = 0.17, 500.0


def motor_angle(times: np.ndarray) -> np.ndarray:
    """Angle of a motor of first order at whose first sample a voltage is switched on."""
    tau = MOTOR_TIME_CONSTANT_S
    return MOTOR_START_RAD_S2 * tau * (times - tau * (1.0 - np.exp(-times / tau)))


@pytest.mark.parametrize(
    "motion",
    [lambda t: 0.3 + 2.0 * t, lambda t: 0.3 + 2.0 * t - 40.0 * t**2, motor_angle],
    ids=["line", "parabola", "motor that starts"],
)
def test_level_and_slope_lie_within_their_deviations(motion) -> None:
    """The motor bends by 5 rad within the samples of a line: the deviations contain that error."""
    rng, errors = np.random.default_rng(3), []
    level = motion(np.zeros(1))[0]
    slope = (motion(np.array([1e-6]))[0] - level) / 1e-6
    for _ in range(300):
        found = initial_level_and_slope(
            TIMES, motion(TIMES) + rng.normal(0, NOISE, len(TIMES)), NOISE
        )
        errors.append([(found.level[0] - level) / found.level[1],
                       (found.slope[0] - slope) / found.slope[1]])  # fmt: skip
    assert np.all(np.sqrt(np.mean(np.square(errors), axis=0)) < 1.4)


def test_samples_on_a_line_all_count() -> None:
    rng = np.random.default_rng(4)
    values = 1.0 + rng.normal(0, NOISE, len(TIMES))
    line = np.polynomial.polynomial.polyfit(
        TIMES[:MAX_START_SAMPLES], values[:MAX_START_SAMPLES], 1
    )
    found = initial_level_and_slope(TIMES, values, NOISE)
    assert (found.level[0], found.slope[0]) == pytest.approx(tuple(line))


def test_missing_samples_are_passed_over_and_three_give_a_line() -> None:
    values = np.where(np.arange(50) % 3 == 1, 2.0 + 5.0 * TIMES, np.nan)
    found = initial_level_and_slope(TIMES, values, NOISE)
    assert found.level[0] == pytest.approx(2.0)
    few = initial_level_and_slope(TIMES[:3], 2.0 + 5.0 * TIMES[:3], NOISE)
    assert few.slope[0] == pytest.approx(5.0)


def test_a_part_of_a_trial_in_which_hardly_anything_was_seen_has_a_start() -> None:
    nothing = initial_level_and_slope(TIMES, np.full(50, np.nan), NOISE)
    assert (nothing.level[0], nothing.slope[0]) == (0.0, 0.0)
    one = initial_level_and_slope(TIMES, np.where(np.arange(50) == 0, 3.0, np.nan), NOISE)
    assert one.level[0] == pytest.approx(3.0)
    assert np.isfinite([*one.level, *one.slope]).all()


def test_a_recording_in_another_unit_is_left_to_the_check_of_errors() -> None:
    """Noise of 1 mm that is taken for 1 m: an uncertainty as large would hide it."""
    values = 1000.0 * np.random.default_rng(5).normal(0, NOISE, len(TIMES))
    found = initial_level_and_slope(TIMES, values, NOISE)
    assert (found.level[1], found.slope[1]) == (0.0, 0.0)

"""The compiled integrator: its three ways agree, with each other and with a slow general method."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bluekoi.integrate import LANES, System, compile_system
from bluekoi.integrate.batch import simulate_batch, threaded_map
from bluekoi.integrate.branchless import branchless_power, exponential
from bluekoi.integrate.inlining import InlinedCode, inlined_expressions
from bluekoi.integrate.kernel_code_generation import kernel_source
from bluekoi.model import (
    PUBLISHED_FLAP_HZ,
    TABLE_1,
    constants_of_robot_trial,
    two_plate_system,
)
from paper_robot import PAPER_SETUP
from pendulum import PENDULUM

TIMES = np.arange(241) / 30


def simulate_first_lane(
    system: System,
    values: np.ndarray,
    inputs: np.ndarray,
    fixed: np.ndarray,
    *,
    start: Sequence[float],
    times: np.ndarray = TIMES,
    step_s: float = 1 / 60,
) -> np.ndarray:
    """States (frames, states) of the first of sixteen equal lanes."""
    state = np.zeros((1, len(system.all_states), LANES))
    state[0, : len(start)] = np.array(start)[:, None]
    _, states = simulate_batch(
        compile_system(system),
        state,
        np.repeat(values[None, :, None], LANES, axis=2),
        np.repeat(fixed[None, :, None], LANES, axis=2),
        times=times[None],
        inputs=inputs[None],
        keep_states=True,
        step_s=step_s,
    )
    assert np.ptp(states, axis=3).max() < 1e-14
    return states[0, :, :, 0]


def swinging_pendulum(values: np.ndarray, push: np.ndarray, step_s: float = 1 / 60) -> np.ndarray:
    return simulate_first_lane(
        PENDULUM, values, push[:, None], np.array([9.81]), start=(0.4, 0.0), step_s=step_s
    )


def exact_pendulum(c: float, k: float, push: np.ndarray) -> np.ndarray:
    def law(t: float, s: np.ndarray) -> list[float]:
        given = np.interp(t, TIMES, push) + 0.3 * math.sin(5.0 * t)
        return [s[1], -9.81 * math.sin(s[0]) - 2 * c * s[1] + given - k * s[1] ** 3]

    end = TIMES[-1]
    return solve_ivp(law, (0, end), [0.4, 0.0], method="DOP853", rtol=1e-10, atol=1e-12,
                     max_step=1 / 30).y[:, -1]  # fmt: skip


@pytest.mark.parametrize("k", [0.0, 0.2])
def test_any_system_with_inputs_that_run_and_forces_that_know_the_time(k: float) -> None:
    push = 0.5 * np.sin(3.0 * TIMES)
    found = swinging_pendulum(np.array([0.1, k]), push)[-1]
    assert found == pytest.approx(exact_pendulum(0.1, k, push), abs=2e-6)


def test_a_gap_in_one_trial_takes_small_steps_there_and_changes_no_other() -> None:
    push = np.full(len(TIMES), 0.3)
    late = np.where(TIMES > 4.0, TIMES + 0.5, TIMES)
    state = np.repeat(np.array([[0.4], [0.0]])[None], 2, axis=0) * np.ones(LANES)
    values = np.array([[[0.1], [0.2]]] * 2) * np.ones(LANES)
    both = simulate_batch(
        compile_system(PENDULUM), state, values, np.full((2, 1, LANES), 9.81),
        times=np.array([TIMES, late]), inputs=np.array([push, push])[:, :, None],
        keep_states=True,
    )[1]  # fmt: skip
    alone = swinging_pendulum(np.array([0.1, 0.2]), push)
    assert np.array_equal(both[0, :, :, 0], alone)
    fine = simulate_first_lane(
        PENDULUM,
        np.array([0.1, 0.2]),
        push[:, None],
        np.array([9.81]),
        start=(0.4, 0.0),
        times=late,
        step_s=1e-3,
    )
    assert both[1, -1, :, 0] == pytest.approx(fine[-1], abs=2e-6)


@pytest.mark.parametrize("frames_hz", [29.97, 59.94])
def test_film_rates_need_no_more_steps_than_round_ones(frames_hz: float) -> None:
    """Two steps a frame at 29.97/s, as at 30/s: the same error as steps of exactly that length."""
    times = np.arange(100) / frames_hz
    push = np.full(len(times), 0.3)[:, None]
    ends = [
        simulate_first_lane(
            PENDULUM,
            np.array([0.1, 0.2]),
            push,
            np.array([9.81]),
            start=(0.4, 0.0),
            times=times,
            step_s=step,
        )
        for step in (1 / 60, 0.5001 * 2 / 59.94)
    ]
    assert np.array_equal(*ends)


@pytest.mark.parametrize("k", [0.0, 0.2])
def test_order_of_convergence_is_four_with_effects_and_without(k: float) -> None:
    push = np.full(len(TIMES), 0.3)
    ends = [swinging_pendulum(np.array([0.1, k]), push, 1 / n)[-1] for n in (30, 60, 120, 960)]
    errors = [np.abs(end - ends[-1]).max() for end in ends[:3]]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all((orders > 3.7) & (orders < 4.6)), orders


def turn_commands(power: int) -> tuple[np.ndarray, np.ndarray]:
    """Head angle and flapping frequency over time: a turn to one side, then to the other."""
    inputs = np.column_stack([
        np.radians(40) * np.tanh(2 * (TIMES - 4.0)),
        PUBLISHED_FLAP_HZ[power] * (1 - 0.3 * (TIMES > 6.0)),
    ])  # fmt: skip
    return inputs, constants_of_robot_trial(PAPER_SETUP, 0.12)


def turning_robot(effects: dict[str, dict[str, float]], start: Sequence[float]) -> np.ndarray:
    inputs, fixed = turn_commands(75)
    values = two_plate_system().parameter_vector(TABLE_1[75], effects)
    return simulate_first_lane(two_plate_system(), values, inputs, fixed, start=start)


EFFECT_OF_NO_SIZE = {"tail_fin_lift": {"lift_area": 1e-300}}
"""An effect that is on and does nothing: sends the integrator its general way."""


def test_the_general_way_gives_what_the_fast_one_gives() -> None:
    start = (0.3, 0.4, 0.2, 0.1, 0.0, 0.0)
    fast, general = turning_robot({}, start), turning_robot(EFFECT_OF_NO_SIZE, start)
    assert general[:, :6] == pytest.approx(fast[:, :6], abs=1e-11)
    assert np.abs(fast[-1]).max() > 0.5


def test_the_general_way_gives_what_the_way_with_random_forces_gives() -> None:
    pushed = (0.3, 0.4, 0.2, 0.1, 0.0, 0.0, 5e-3, -4e-3, 3e-4)
    random = {"disturbance": {"present": 1.0, "tau_surge": 0.7, "tau_sway": 0.7, "tau_yaw": 0.7}}
    fast, general = turning_robot(random, pushed), turning_robot(random | EFFECT_OF_NO_SIZE, pushed)
    absent = two_plate_system().effect("tail_fin_lift").states  # followed by the general way alone
    both = [i for i, state in enumerate(two_plate_system().all_states) if state not in absent]
    assert general[:, both] == pytest.approx(fast[:, both], abs=1e-11)
    still = turning_robot({}, pushed[:6])
    assert np.abs(fast[-1, :6] - still[-1, :6]).max() > 1e-3
    assert fast[-1, 6] == pytest.approx(5e-3 * math.exp(-8 / 0.7), rel=1e-4)


def test_effects_that_change_the_command_reach_what_is_held() -> None:
    """A head that is set off by 5 degrees turns like one that was commanded so."""
    fixed, values = constants_of_robot_trial(PAPER_SETUP, 0.12), TABLE_1[75]
    inputs = np.tile([math.radians(30), 4.02], (241, 1))
    off = two_plate_system().parameter_vector(
        values, {"head_angle_offset": {"offset": math.radians(5)}}
    )
    set_off = simulate_first_lane(two_plate_system(), off, inputs, fixed, start=[0.0] * 6)
    inputs[:, 0] += math.radians(5)
    reported = simulate_first_lane(
        two_plate_system(),
        two_plate_system().parameter_vector(values),
        inputs,
        fixed,
        start=[0.0] * 6,
    )
    assert set_off[:, :6] == pytest.approx(reported[:, :6], abs=1e-10)


def test_accuracy_over_eight_seconds_of_a_schedule() -> None:
    """Below 0.1 mm and 0.05 degrees at 1/60 s, against the same at 1/1920 s."""
    inputs, fixed = turn_commands(100)
    values = two_plate_system().parameter_vector(TABLE_1[100])
    start = (0.3, 0.4, 0.2, 0.0, 0.0, 0.0)
    coarse, fine = (
        simulate_first_lane(two_plate_system(), values, inputs, fixed, start=start, step_s=s)
        for s in (1 / 60, 1 / 1920)
    )
    assert np.hypot(*(coarse - fine)[:, :2].T).max() < 1e-4
    assert np.abs(coarse - fine)[:, 2].max() < math.radians(0.05)


@pytest.mark.parametrize("general", [False, True])
def test_a_source_is_the_same_every_time_and_holds_what_does_not_move(general: bool) -> None:
    text = kernel_source(PENDULUM, general=general)
    assert text == kernel_source(PENDULUM, general=general)
    held = text.split("def hold")[1].split("def ")[0]
    assert "2.0 * row" in held
    assert "math.sin" not in held
    assert "math.sin" in text.replace(held, "")


def test_a_function_that_asks_for_what_nobody_gives_is_named() -> None:
    from dataclasses import replace

    from bluekoi.integrate import Stage

    def rates(rate: float, missing: float) -> tuple[float, float]:
        return rate, missing

    stages = tuple(
        Stage("rates", ("angle", "rate"), rates) if s.name == "rates" else s
        for s in PENDULUM.stages
    )
    with pytest.raises(TypeError, match="rates: no value 'missing'"):
        kernel_source(replace(PENDULUM, stages=stages), general=False)


def function_with_branch(x: float) -> float:
    return x if x > 0 else -x


def function_with_helper(x: float, zero: float) -> tuple[float, float]:
    twice = 2.0 * function_with_branch(x + 1.0)
    return twice + zero * x, math.pi * zero


def test_straight_lines_are_written_out_and_branches_called() -> None:
    lines = InlinedCode()
    values = inlined_expressions(function_with_helper, ["a", "0.0"], lines)
    assert list(lines.called.values()) == [function_with_branch]
    (name,) = lines.called
    assert lines.written == [
        "given_1 = a + 1.0", f"out_2 = {name}(given_1)", "twice_3 = 2.0 * out_2",
    ]  # fmt: skip
    assert values == ["twice_3", "0.0"]


def test_calls_shared_among_threads_keep_their_order_and_their_faults(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("BLUEKOI_THREADS", "3")
    assert threaded_map(lambda k: k * k, range(50)) == [k * k for k in range(50)]
    assert threaded_map(lambda k: threaded_map(lambda m: (k, m), range(3)), range(4))[3] == [
        (3, 0),
        (3, 1),
        (3, 2),
    ]

    def faulty(k: int) -> int:
        if k == 7:
            raise IndexError("seven")
        return k

    with pytest.raises(IndexError, match="seven"):
        threaded_map(faulty, range(20))
    assert threaded_map(lambda k: -k, range(5)) == [0, -1, -2, -3, -4]


def test_exponential_and_power_without_branches_are_as_exact_as_stated() -> None:
    small, large = np.linspace(-10, 10, 2001), np.linspace(-60, 60, 2001)
    off = [max(abs(exponential(float(x)) / math.exp(x) - 1) for x in xs) for xs in (small, large)]
    assert off[0] < 1e-11
    assert off[1] < 3e-6
    assert exponential(-1e9) == exponential(-60.0)
    raised = [(float(x), 10.0 / max(abs(math.log(x)), 2.0)) for x in np.geomspace(1e-11, 1e5, 400)]
    assert max(abs(branchless_power(x, p) / x**p - 1) for x, p in raised) < 1e-10
    assert max(abs(branchless_power(x, -p) * x**p - 1) for x, p in raised) < 1e-10

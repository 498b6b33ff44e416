"""Water that swings: without a name, yet modelled, and what is hidden beside it is found."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from measured import Measured, swung
from pipeline.files import plain
from pipeline.fitting import Free, Series
from pipeline.integrate import compiled
from pipeline.mismatch import Found, find_mismatch
from pipeline.mismatch.locate import Dependence
from pipeline.mismatch.rounds import promising
from pipeline.mismatch.search import Foretold, other_shapes, unlikelihood
from pipeline.mismatch.story import mismatch_json
from pipeline.mismatch.swinging import of_time, only_of_time, swings
from pipeline.model import hump, is_nameless, plates

SWING = {"sx": 0.03, "cx": -0.01, "W": 2.6}
PULSE = {"s": 0.12, "c": 0.04, "W": 2.2}
HUMP = {"h": 0.3, "c": 0.36, "w": 0.06}


def test_a_thrust_that_comes_and_goes_is_found_with_its_rate(demo: tuple[Measured, Found]) -> None:
    _, numbers, held = told_beside_the_fin(demo, "surging", PULSE)
    assert numbers["W"] == pytest.approx(PULSE["W"], abs=0.05)
    assert numbers["s"] == pytest.approx(PULSE["s"], abs=0.02)
    assert held["extended"]["path_rmse_m"] < 0.5 * held["baseline"]["path_rmse_m"]


def test_a_swing_is_found_with_its_rate_and_so_is_the_fin_beside_it(
    demo: tuple[Measured, Found],
) -> None:
    cause, numbers, held = told_beside_the_fin(demo, "sloshing", SWING)
    assert "swings to and fro" in cause["sentence"]
    assert "time_s" in cause["sentence"]
    assert cause["channels"] == ["surge", "sway"]
    assert numbers["W"] == pytest.approx(SWING["W"], abs=0.03)
    assert numbers["sx"] == pytest.approx(SWING["sx"], abs=0.004)
    assert numbers["cx"] == pytest.approx(SWING["cx"], abs=0.004)
    assert held["extended"]["path_rmse_m"] < 0.5 * held["baseline"]["path_rmse_m"]
    assert held["extended"]["path_rmse_m"] < 1.3 * held["noise_floor_path_rmse_m"]


def test_a_drag_that_rises_about_one_speed_is_found_with_its_speed(
    demo: tuple[Measured, Found],
) -> None:
    cause, numbers, held = told_beside_the_fin(demo, "hump", HUMP)
    assert "surge" in cause["channels"]
    assert numbers["c"] == pytest.approx(HUMP["c"], abs=0.02)
    assert held["extended"]["path_rmse_m"] < 0.5 * held["baseline"]["path_rmse_m"]
    assert held["extended"]["path_rmse_m"] < 1.3 * held["noise_floor_path_rmse_m"]


def test_a_thrust_that_falls_with_the_square_of_the_advance_has_its_name(
    demo: tuple[Measured, Found],
) -> None:
    """Its linear form gains nothing there: the coefficients take it up."""
    m, still = demo
    series = swung(m.series, still.extended, "thrust_loss_with_speed", {"k": 0.008, "w": 1.0})
    found = find_mismatch(m.study, series, m.steady, progress=lambda _: None)
    assert found.verdict == "physics"
    assert {"tail_fin_lift", "thrust_loss_with_speed"} <= set(found.choice.chosen.effects)
    assert found.extended.fit.by_label()["thrust_loss_with_speed.w"] > 0.5


def told_beside_the_fin(
    demo: tuple[Measured, Found], effect: str, hidden: dict[str, float]
) -> tuple[dict[str, Any], dict[str, float], dict[str, Any]]:
    """What is told of the demo with an effect without a name in it: that cause, its numbers, the
    held-out errors.
    """
    m, still = demo
    series = swung(m.series, still.extended, effect, hidden)
    found = find_mismatch(m.study, series, m.steady, progress=lambda _: None)
    told = plain(mismatch_json(found, m.study, series))
    assert told["verdict"] == "unexplained"
    assert "tail_fin_lift" in {c["name"] for c in told["causes"]}
    cause = next(c for c in told["causes"] if c["name"] == "unexplained")
    numbers = {k: v["value"] for k, v in cause["parameters"].items()}
    return cause, numbers, told["held_out"]


def test_shapes_are_tried_between_start_and_bounds_or_at_their_own_values_or_not() -> None:
    kernel = compiled(plates())
    onset = kernel.system.parameters[kernel.system.slot["stall.s0"]]
    assert other_shapes(kernel, "stall") == [
        {"stall.s0": pytest.approx((onset.start * bound) ** 0.5)}
        for bound in (onset.lower, onset.upper)
    ]
    assert other_shapes(kernel, "lift_lag") == [
        {"lift_lag.s": 1.3}, {"lift_lag.s": 10.0}, {"lift_lag.s": 1.3, "lift_lag.e": 2.0}
    ]  # fmt: skip
    humps = other_shapes(kernel, "hump")
    assert [shape["hump.c"] for shape in humps] == list(hump.SPEEDS)
    assert all(shape["hump.w"] == hump.NARROW for shape in humps)
    assert other_shapes(kernel, "thrust_loss_with_speed") == [
        {"thrust_loss_with_speed.w": 0.8}, {"thrust_loss_with_speed.q": 1.0}
    ]  # fmt: skip
    assert other_shapes(kernel, "trim_moment") == []


def test_another_form_of_a_law_is_less_plausible_than_the_start() -> None:
    kernel = compiled(plates())
    assert unlikelihood(kernel, {"thrust_loss_with_speed.w": 0.8}) == pytest.approx(2.0)
    assert unlikelihood(kernel, {"hump.c": 0.2, "hump.w": 0.05}) == 0.0


def test_a_swing_pushes_by_the_clock_however_fast_in_its_own_channels() -> None:
    t = np.linspace(0.0, 10.0, 101)
    push = np.column_stack([3 * np.sin(2.6 * t), np.sin(2.6 * t), 5 * np.sin(2.6 * t)])
    told = [Dependence(c, v, 0.01, (), 0.01) for c in range(3) for v in ("time_s", "speed_m_s")]
    none = np.zeros(1)
    one = Series("T1", "", "", t, none, none, none, none, none, none)
    free = [Free("sloshing.W")]
    found = {(d.channel, d.variable): d for d in of_time([one], [push], told, np.ones(3), free)}
    assert found[0, "time_s"].adds == pytest.approx(0.9)
    assert found[1, "time_s"].adds == pytest.approx(0.1)
    assert found[2, "time_s"].adds == found[0, "speed_m_s"].adds == 0.0
    assert found[0, "time_s"].trials == ("T1",)
    thrust = of_time([one], [push], told, np.ones(3), [Free("surging.W")])
    assert {(d.channel, d.variable) for d in thrust if d.adds > 0} == {(0, "time_s")}


def test_what_has_no_name_is_told_from_what_has() -> None:
    swing, term, named = (Free(n) for n in ("sloshing.W", "residual.b7", "pool_gyre.G"))
    assert [is_nameless(f.name) for f in (swing, term, named, Free("C_T"))] == [
        True, True, False, False,
    ]  # fmt: skip
    assert swings([named, swing])
    assert not swings([named, term])
    assert only_of_time([named, swing])
    assert not only_of_time([swing, term])


def test_what_a_step_foretells_nothing_of_is_not_refitted_but_the_best_two() -> None:
    """Beside a wrong model laws with a shape are, of any rank; one with own starts always."""
    kernel = compiled(plates())
    gains = {"uniform_current": 90.0, "coulomb_friction": 5.0, "trim_moment": 0.9, "stall": 1.2,
             "scale_error": 0.8, "lift_lag": 0.1, "time_offset": -9.0}  # fmt: skip
    told = {name: Foretold(gain, {}) for name, gain in gains.items()}
    assert promising(kernel, told, 6, 2.0) == [
        "uniform_current", "coulomb_friction", "stall", "time_offset"
    ]  # fmt: skip
    assert promising(kernel, told, 1, 2.2) == ["uniform_current", "time_offset"]
    assert promising(kernel, told, 1, 9.0) == ["uniform_current", "time_offset"]
    strong = {name: Foretold(100 * gain, {}) for name, gain in gains.items()}
    assert promising(kernel, strong, 1, 9.0) == [
        "uniform_current", "stall", "trim_moment", "lift_lag", "time_offset"
    ]  # fmt: skip
    weak = {name: Foretold(0.01 * gain, {}) for name, gain in gains.items()}
    assert promising(kernel, weak, 6, 2.0) == [
        "uniform_current", "coulomb_friction", "time_offset"
    ]  # fmt: skip

"""The joint fit on free trajectories, every trial from a start of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bluekoi.fitting import FreeParameter, TrialSeries, fit_trajectories
from bluekoi.fitting.gram import compute_column_products
from bluekoi.integrate import compile_system
from bluekoi.model import PUBLISHED_FLAP_HZ, constants_of_robot_trial, simulate, two_plate_system
from paper_robot import PAPER_SETUP
from simulated_campaigns import COEFFICIENTS

NAMES = ("C_T", "C_D0", "C_Da", "C_La", "C_Ma", "C_Md")
OBSERVATION_STDS = np.array([1e-3, 1e-3, 0.01, 0.1])
START_VALUES = np.array([0.01, -0.02, 0.03, 0.02, -0.01, 0.05])


def simulated_trial(number: int, rng: np.random.Generator, noise: float = 1.0) -> TrialSeries:
    power, angle = (50, 75, 100)[number % 3], np.radians((30.0, 20.0, -45.0)[number // 3])
    run = simulate(
        COEFFICIENTS,
        setup=PAPER_SETUP,
        head_length_m=0.12,
        head_angle_rad=angle,
        flap_hz=PUBLISHED_FLAP_HZ[power],
        duration_s=4.0,
        dt_s=1 / 30,
        start=tuple(START_VALUES),
    )
    n, count = len(run.time_s), len(two_plate_system().all_states)
    seen = np.column_stack([run.state[:, :2], run.heading_rad, np.full(n, angle)])
    seen[:, :3] += noise * OBSERVATION_STDS[:3] * rng.standard_normal((n, 3))
    spread = np.array([0.02, 0.02, 0.05, 0.05, 0.05, 0.3] + [1e-6] * (count - 6))
    return TrialSeries(
        name=f"T{number}",
        group=str(power),
        condition="",
        times=run.time_s,
        inputs=np.tile([angle, PUBLISHED_FLAP_HZ[power]], (n, 1)),
        constants=constants_of_robot_trial(PAPER_SETUP, 0.12),
        seen=seen,
        noise=np.tile(np.diag(OBSERVATION_STDS**2), (n, 1, 1)),
        mean=np.zeros(count),
        cov=np.diag(spread**2),
    )


def fit_trials(series: list[TrialSeries], **more):
    start = {n: COEFFICIENTS[n] * f for n, f in zip(NAMES, (1.2, 0.8, 1.3, 0.8, 1.3, 0.8),
                                                    strict=True)}  # fmt: skip
    return fit_trajectories(
        compile_system(two_plate_system()),
        series,
        two_plate_system().parameter_vector({}),
        [FreeParameter(n) for n in NAMES],
        start=start,
        **more,
    )


def test_exact_paths_give_back_coefficients_and_starts() -> None:
    series = [simulated_trial(i, np.random.default_rng(0), noise=0.0) for i in range(9)]
    wide = [replace(s, cov=s.cov * 1e4) for s in series]
    result = fit_trials(wide)
    assert result.fit.outcome == "converged"
    assert result.fit.values == pytest.approx([COEFFICIENTS[n] for n in NAMES], rel=1e-4)
    assert result.starts[:, :6] == pytest.approx(np.tile(START_VALUES, (9, 1)), abs=1e-4)


def test_stated_deviations_are_those_of_many_fits_to_white_noise() -> None:
    rng = np.random.default_rng(3)
    truth = np.array([COEFFICIENTS[n] for n in NAMES])
    pulls = []
    for _ in range(12):
        fit = fit_trials([simulated_trial(i, rng) for i in range(9)]).fit
        pulls.append((fit.values - truth) / np.sqrt(np.diag(fit.naive_cov)))
    assert 0.75 < np.sqrt(np.mean(np.square(pulls))) < 1.25


def shortened_trials(series: TrialSeries, frames: int) -> TrialSeries:
    gone = np.arange(frames)[:, None] % 7 == 3
    return replace(
        series,
        times=series.times[:frames],
        inputs=series.inputs[:frames],
        seen=np.where(gone, np.nan, series.seen[:frames]),
        noise=series.noise[:frames],
        cov=series.cov * 1e4,
    )


def test_trials_of_unequal_length_and_missing_frames_are_no_matter() -> None:
    series = [simulated_trial(i, np.random.default_rng(1), noise=0.0) for i in range(9)]
    cut = [shortened_trials(s, 80 + 4 * i) for i, s in enumerate(series)]
    assert fit_trials(cut).fit.values == pytest.approx([COEFFICIENTS[n] for n in NAMES], rel=1e-3)


def test_more_numbers_than_lanes_are_refused() -> None:
    series = [simulated_trial(0, np.random.default_rng(1))]
    free = [FreeParameter(p.name) for p in two_plate_system().parameters[:12]]
    with pytest.raises(ValueError, match="18 numbers a trial, at most 15"):
        fit_trajectories(
            compile_system(two_plate_system()),
            series,
            two_plate_system().parameter_vector({}),
            free,
        )


def test_products_are_those_of_matrices_and_leave_out_what_was_not_seen() -> None:
    rng = np.random.default_rng(7)
    observed, seen = rng.normal(size=(3, 90, 2, 16)), rng.normal(size=(3, 90, 2))
    weight = rng.uniform(0.5, 2.0, size=seen.shape)
    weight[1, 40:] = 0.0
    observed[1, 40:] = np.nan
    found = np.empty((3, 8, 8))
    compute_column_products(observed, seen, weight, (0, 3), found)
    columns = np.nan_to_num(observed - observed[..., :1])[..., :8]
    columns[..., 0] = np.nan_to_num(seen - observed[..., 0])
    J = (columns * weight[..., None]).reshape(3, -1, 8)
    assert found == pytest.approx(J.transpose(0, 2, 1) @ J, abs=1e-10)

"""Joint fits: ours beside scipy's least_squares over solve_ivp, 66 trials, and up to 1,000.

    python benchmarks/fit.py [--slow] [--seconds 2]

First six coefficients to 9 trials of 241 frames from a start 30 to 50 % off, on one core: scipy
with its own difference step, and with one that suits adaptive steps; ours on free trajectories
(`fit_trajectories`, starting states free) and by prediction errors (`fit_parameters_jointly`, what
`bluekoi run` uses). --slow frees the 54 starting states for scipy too (minutes). Then the joint fit
to 66 trials with starting states on two cores, and how time grows with trials.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from test_model import published_rates_in_world_axes

from bluekoi.fitting import (
    FreeParameter,
    ParameterFit,
    TrialSeries,
    fit_parameters_jointly,
    fit_trajectories,
)
from bluekoi.integrate import compile_system
from bluekoi.model import (
    HYDRODYNAMIC_COEFFICIENTS,
    PUBLISHED_FLAP_HZ,
    TABLE_1,
    constants_of_robot_trial,
    simulate,
    two_plate_system,
)
from bluekoi.tuning import downsampled
from bluekoi.tuning.joint_fit import START_NOISE
from paper_robot import PAPER_SETUP

TRUTH = dict(TABLE_1[75])
NAMES = tuple(p.name for p in HYDRODYNAMIC_COEFFICIENTS)
START = dict(zip(NAMES, np.array([1.3, 0.7, 1.5, 0.6, 1.4, 0.7]) * [TRUTH[n] for n in NAMES],
                 strict=True))  # fmt: skip
POSITION_STD, HEADING_STD = 1e-3, 0.01
ANGLES = (20.0, 30.0, -45.0)


def simulated_trial(number: int, rng: np.random.Generator, frames: int = 241) -> TrialSeries:
    """A simulated trial with white noise, from rest."""
    power, angle = (50, 75, 100)[number % 3], np.radians(ANGLES[number // 3 % 3])
    run = simulate(
        TRUTH,
        setup=PAPER_SETUP,
        head_length_m=0.12,
        head_angle_rad=angle,
        flap_hz=PUBLISHED_FLAP_HZ[power],
        duration_s=(frames - 1) / 30,
        dt_s=1 / 30,
    )
    seen = np.column_stack([run.state[:, :2], run.heading_rad, np.full(frames, angle)])
    std = np.array([POSITION_STD, POSITION_STD, HEADING_STD, 0.1])
    seen += std * [1, 1, 1, 0] * rng.standard_normal(seen.shape)
    count = len(two_plate_system().all_states)
    start_std = np.array([0.02, 0.02, 0.05, 0.05, 0.05, 0.3] + [1e-6] * (count - 6))
    return TrialSeries(
        name=f"T{number}",
        group=str(power),
        condition="",
        times=run.time_s,
        inputs=np.tile([angle, PUBLISHED_FLAP_HZ[power]], (frames, 1)),
        constants=constants_of_robot_trial(PAPER_SETUP, 0.12),
        seen=seen,
        noise=np.tile(np.diag(std**2), (frames, 1, 1)),
        mean=np.zeros(count),
        cov=np.diag(start_std**2),
    )


def largest_error_text(values: np.ndarray) -> str:
    """Largest distance from the truth, in words."""
    truth = np.array([TRUTH[n] for n in NAMES])
    return f"worst coefficient {100 * np.abs(values / truth - 1).max():.2f} % off"


def shortest_time(
    call: Callable[[], Any], seconds: float = 0.0, timer: Callable[[], float] = time.perf_counter
) -> tuple[float, Any]:
    """Shortest time of the calls that fit into so many seconds, and what came out."""
    best, end = np.inf, time.perf_counter() + seconds
    while best == np.inf or time.perf_counter() < end:
        start = timer()
        result = call()
        best = min(best, timer() - start)
    return best, result


def fit_by_scipy(series: Sequence[TrialSeries], *, free_starts: bool, **options: Any) -> np.ndarray:
    """least_squares over solve_ivp, as one writes it from the manuals."""
    scale = np.array([START[n] for n in NAMES])
    sigma = np.array([POSITION_STD, POSITION_STD, HEADING_STD])

    def errors(unknown: np.ndarray) -> np.ndarray:
        values = dict(zip(NAMES, unknown[:6] * scale, strict=True))
        out = []
        for i, s in enumerate(series):
            phi, hz = s.inputs[0]
            start = unknown[6 + 6 * i : 12 + 6 * i] if free_starts else np.zeros(6)
            start = start - [0, 0, phi, 0, 0, 0]
            run = solve_ivp(
                published_rates_in_world_axes,
                (0, s.times[-1]),
                start,
                args=(values, phi, hz),
                t_eval=s.times,
                rtol=1e-6,
            )
            seen = run.y[:3].T + np.array([0, 0, phi])
            out.append((seen - s.seen[:, :3]) / sigma)
        return np.concatenate(out).ravel()

    unknown = np.ones(6) if not free_starts else np.concatenate([np.ones(6), np.zeros(54)])
    return least_squares(errors, unknown, **options).x[:6] * scale


def compare_on_nine_trials(seconds: float, *, slow: bool) -> None:
    """Print the comparison on nine trials."""
    os.environ["BLUEKOI_THREADS"] = "1"
    rng = np.random.default_rng(1)
    series = [simulated_trial(i, rng) for i in range(9)]
    kernel, base = compile_system(two_plate_system()), two_plate_system().parameter_vector({})
    free = [FreeParameter(n) for n in NAMES]
    known = [replace(s, cov=s.cov * 1e-12) for s in series]
    ways: dict[str, Callable[[], np.ndarray]] = {
        "ours, trajectories, starts known": lambda: fit_trajectories(
            kernel, known, base, free, start=START, open_states=0,
            shares=(0.25, 1.0)).fit.values,
        "ours, trajectories, 54 start states free": lambda: fit_trajectories(
            kernel, series, base, free, start=START).fit.values,
        "ours, prediction errors, starts free": lambda: fit_parameters_jointly(
            kernel, series, base, free, START_NOISE, start=START).values,
        "ours, the same at ten observations a second": lambda: fit_parameters_jointly(
            kernel, downsampled(series), base, free, START_NOISE, start=START).values,
    }  # fmt: skip
    print("six coefficients to 9 trials of 241 frames, one core, processor time")
    times = {}
    for name, way in ways.items():
        way()
        times[name], values = shortest_time(way, seconds, time.process_time)
        print(f"  {name:46s}{times[name]:9.4f} s   {largest_error_text(values)}")
    wanted = times["ours, trajectories, starts known"]
    for name, options in {"scipy, its own difference step": {},
                          "scipy, difference step 1e-4": {"diff_step": 1e-4}}.items():  # fmt: skip
        taken, values = shortest_time(
            lambda o=options: fit_by_scipy(series, free_starts=False, **o), timer=time.process_time
        )
        print(
            f"  {name:46s}{taken:9.2f} s   {largest_error_text(values)}   "
            f"{taken / wanted:.0f} times ours"
        )
    if slow:
        name = "scipy, 54 start states free"
        taken, values = shortest_time(
            lambda: fit_by_scipy(series, free_starts=True, diff_step=1e-4), timer=time.process_time
        )
        ratio = taken / times["ours, trajectories, 54 start states free"]
        print(f"  {name:46s}{taken:9.1f} s   {largest_error_text(values)}   {ratio:.0f} times ours")


def time_many_trials(seconds: float) -> None:
    """Print times of the joint fit by prediction errors on two cores, 66 to 1,000 trials."""
    os.environ["BLUEKOI_THREADS"] = "2"
    rng = np.random.default_rng(2)
    kernel, base = compile_system(two_plate_system()), two_plate_system().parameter_vector({})
    free = [FreeParameter(n) for n in NAMES]
    print("\njoint fits with starting states, 150 frames a trial, two cores")
    for count in (66, 132, 264, 528, 1000):
        series = [simulated_trial(i, rng, 151) for i in range(count)]
        few = downsampled(series)
        ways: dict[str, Callable[[], ParameterFit]] = {
            "prediction errors": lambda f=few: fit_parameters_jointly(
                kernel, f, base, free, START_NOISE, start=START
            ),
            "trajectories": lambda s=series: (
                fit_trajectories(kernel, s, base, free, start=START).fit
            ),
        }
        for name, way in ways.items():
            taken, _ = shortest_time(way, seconds if count < 200 else 0)
            work, found = shortest_time(way, timer=time.process_time)
            each = 1e3 * work / count / (found.iterations + 1)
            print(f"  {count:5d} trials, {name:18s}{taken:8.3f} s, {found.iterations:3d} rounds, "
                  f"{each:.3f} ms a trial and round; {found.outcome}")  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=1.0)
    parser.add_argument("--slow", action="store_true")
    given = parser.parse_args()
    compare_on_nine_trials(given.seconds, slow=given.slow)
    time_many_trials(given.seconds)


if __name__ == "__main__":
    main()

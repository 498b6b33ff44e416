"""Simulations per second beside solve_ivp and hand-written C compiled on the spot (needs gcc).

    python benchmarks/integration.py [--seconds 3] [--fresh]

One simulation is 8 s of the paper's model from rest with the head turned, seen 30 times a second.
C is integration.c: one simulation at a time, and 16 at a time with the compiler's own choice of
vector width and with the widest; each ratio is to the fastest C. Rounds alternate between the
candidates and the best round of each counts, so that other work on the machine hurts all alike.
With --fresh the first call with an empty cache and the first of a later process are timed too.
"""

from __future__ import annotations

import argparse
import ctypes
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from test_model import published_rates

from bluekoi.integrate import LANES, System, compile_system
from bluekoi.integrate.batch import simulate_batch
from bluekoi.model import (
    PUBLISHED_FLAP_HZ,
    TABLE_1,
    constants_of_robot_trial,
    two_plate_system,
)
from paper_robot import PAPER_SETUP

HERE = Path(__file__).resolve().parent
FRAMES, RATE = 241, 30.0
BLOCK_COUNT = 16
POWER, ANGLE = 75, np.radians(35.0)
C_VERSIONS = {
    "C, one at a time": ("scalar", ["-O3"]),
    "C, 16 lanes": ("lanes", ["-Ofast"]),
    "C, 16 lanes, widest vectors": ("lanes", ["-Ofast", "-mprefer-vector-width=512"]),
}
EFFECTS_OF_NO_SIZE = {
    "tail_fin_lift": {"lift_area": 1e-300},
    "viscous_drag": {"coefficient": 1e-300},
}
"""Two effects of no size, which send every stage its general way."""
COEFFICIENT_ORDER = ("C_T", "C_D0", "C_Da", "C_La", "C_Ma", "C_Md")

Run = Callable[[float], np.ndarray]
"""Longest step [s] -> end of the first path: x, y, core heading."""


def kernel_run(system: System, blocks: int = BLOCK_COUNT, **effects: dict[str, float]) -> Run:
    """All blocks in one call, from this system's kernel."""
    values = np.tile(
        system.parameter_vector(TABLE_1[POWER], effects)[None, :, None],
        (blocks, 1, LANES),
    )
    fixed = np.tile(constants_of_robot_trial(PAPER_SETUP, 0.12)[None, :, None], (blocks, 1, LANES))
    state = np.zeros((blocks, len(system.all_states), LANES))
    times = np.tile(np.arange(FRAMES) / RATE, (blocks, 1))
    inputs = np.tile([ANGLE, PUBLISHED_FLAP_HZ[POWER]], (blocks, FRAMES, 1))
    kernel = compile_system(system)

    def run(step_s: float) -> np.ndarray:
        observed, _ = simulate_batch(
            kernel, state, values, fixed, times=times, inputs=inputs, step_s=step_s
        )
        return observed[0, -1, :3, 0]

    run(1 / 60)  # compiled now
    return run


def published_system() -> System:
    """The paper's model with no effect in it at all."""
    return replace(two_plate_system(), name="bare", effects=())


def compile_c_version(folder: Path, name: str) -> Run:
    """The C version, compiled here and now."""
    function, flags = C_VERSIONS[name]
    library = folder / (name.replace(" ", "_").replace(",", "") + ".so")
    gcc = shutil.which("gcc") or sys.exit("gcc is needed for this benchmark")
    subprocess.run(
        [gcc, *flags, "-march=native", "-shared", "-fPIC", "-o", str(library),
         str(HERE / "integration.c"), "-lmvec", "-lm"], check=True,
    )  # fmt: skip
    call = getattr(ctypes.CDLL(str(library)), function)
    array = np.ctypeslib.ndpointer(np.float64, flags="C")
    call.argtypes = [ctypes.c_long] * 3 + [ctypes.c_double, array, array]
    robot = PAPER_SETUP.robot
    one = np.array(
        [
            1000.0,
            robot.head_area_m2(0.12),
            robot.aerodynamic_arm_m(0.12),
            robot.mass_kg,
            robot.yaw_inertia_kg_m2,
            ANGLE,
            PUBLISHED_FLAP_HZ[POWER],
            *(TABLE_1[POWER][k] for k in COEFFICIENT_ORDER),
        ]
    )
    wide = function == "lanes"
    count = BLOCK_COUNT if wide else BLOCK_COUNT * LANES
    given = np.tile(one[None, :, None], (count, 1, LANES)) if wide else np.tile(one, (count, 1))
    paths = np.zeros((count, FRAMES, 3, LANES) if wide else (count, FRAMES, 3))

    def run(step_s: float) -> np.ndarray:
        substeps = round(1 / RATE / step_s)
        call(count, FRAMES, substeps, 1 / RATE / substeps, given, paths)
        return paths[0, -1, :, 0] if wide else paths[0, -1]

    return run


def scipy_solution(rtol: float, method: str) -> np.ndarray:
    """End of the path by scipy, from equations written independently of the model."""
    found = solve_ivp(published_rates, (0, (FRAMES - 1) / RATE), [0, 0, -ANGLE, 0, 0, 0],
                      args=(POWER, ANGLE), method=method, rtol=rtol, atol=1e-3 * rtol,
                      t_eval=np.arange(FRAMES) / RATE)  # fmt: skip
    end = found.y[:3, -1]
    return np.array([end[0], end[1], end[2] + ANGLE])


def best_times(
    runs: dict[str, Run],
    step_s: float,
    seconds: float,
    timer: Callable[[], float] = time.perf_counter,
) -> dict[str, float]:
    """Shortest time [s] of each, rounds in turn."""
    best = dict.fromkeys(runs, np.inf)
    end = time.perf_counter() + seconds * len(runs)
    while time.perf_counter() < end:
        for name, run in runs.items():
            start = timer()
            run(step_s)
            best[name] = min(best[name], timer() - start)
    return best


def end_errors(end: np.ndarray, truth: np.ndarray) -> str:
    """Distance in mm and heading in degrees."""
    return (
        f"{1e3 * np.hypot(*(end - truth)[:2]):9.1e} mm {abs(np.degrees(end - truth)[2]):9.1e} deg"
    )


def print_speeds(runs: dict[str, Run], seconds: float) -> None:
    """Print simulations per second at two steps, and each one's ratio to the fastest C."""
    truth = scipy_solution(1e-12, "DOP853")
    simulations = BLOCK_COUNT * LANES
    for step_s in (1 / 60, 1 / 240):
        best = best_times(runs, step_s, seconds)
        fastest = min(t for name, t in best.items() if name.startswith("C"))
        usual = best["C, 16 lanes"]
        print(f"\nstep 1/{1 / step_s:.0f} s{'':28s}per second   to C   to widest C    error at 8 s")
        for name, taken in best.items():
            print(
                f"{name:40s}{simulations / taken:10.0f} {usual / taken:6.2f} {fastest / taken:9.2f}"
                f"       {end_errors(runs[name](step_s), truth)}"
            )
    start = time.perf_counter()
    end = scipy_solution(1e-6, "RK45")
    taken = time.perf_counter() - start
    best_ours = best_times({"ours": runs["ours, every effect off"]}, 1 / 60, seconds)["ours"]
    print(f"\nsolve_ivp RK45, rtol 1e-6{1 / taken:25.1f}{'':24s}{end_errors(end, truth)}")
    print(f"ours at 1/60 s is {taken * simulations / best_ours:.0f} times as fast, on one core")


def print_thread_gain(run: Run, seconds: float) -> None:
    """Print what a second thread brings, calls with one and with two in turn."""

    def with_threads(count: str) -> Run:
        def call(step_s: float) -> np.ndarray:
            os.environ["BLUEKOI_THREADS"] = count
            return run(step_s)

        return call

    for step_s in (1 / 60, 1 / 240):
        runs = {n: with_threads(n) for n in ("1", "2")}
        wall, work = (
            best_times(runs, step_s, seconds, timer)
            for timer in (time.perf_counter, time.process_time)
        )
        print(
            f"step 1/{1 / step_s:.0f} s: two cores {wall['1'] / wall['2']:.2f} times one; "
            f"their processor time {100 * (work['2'] / work['1'] - 1):+.0f} %"
        )
    os.environ["BLUEKOI_THREADS"] = "1"


def print_first_call_times() -> None:
    """Print the time to the first simulation with an empty cache, and in a later process."""
    line = (
        "from bluekoi.model import simulate, TABLE_1; from paper_robot import PAPER_SETUP;"
        "simulate(TABLE_1[75], setup=PAPER_SETUP, head_length_m=0.12, head_angle_rad=0.5,"
        " flap_hz=4.0, duration_s=8.0)"
    )
    with tempfile.TemporaryDirectory() as cache:
        path = os.pathsep.join([str(HERE.parent / "tests"), str(HERE.parent / "pipeline")])
        places = os.environ | {"BLUEKOI_CACHE": cache, "PYTHONPATH": path}
        for what in ("first call, nothing compiled", "first call of a later process"):
            start = time.perf_counter()
            subprocess.run([sys.executable, "-c", line], check=True, env=places)
            print(f"{what}: {time.perf_counter() - start:.2f} s, start of Python included")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=2.0, help="for each candidate and step")
    parser.add_argument("--fresh", action="store_true")
    given = parser.parse_args()
    os.environ["BLUEKOI_THREADS"] = "1"
    with tempfile.TemporaryDirectory() as folder:
        runs: dict[str, Run] = {name: compile_c_version(Path(folder), name) for name in C_VERSIONS}
        runs |= {
            "ours, bare model": kernel_run(published_system()),
            "ours, every effect off": kernel_run(two_plate_system()),
        }
        runs |= {
            "ours, effects that do nothing on": kernel_run(two_plate_system(), **EFFECTS_OF_NO_SIZE)
        }
        print_speeds(runs, given.seconds)
        print_thread_gain(kernel_run(two_plate_system(), blocks=4 * BLOCK_COUNT), given.seconds)
    if given.fresh:
        print_first_call_times()


if __name__ == "__main__":
    main()

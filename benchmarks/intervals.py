"""How often the 95 % intervals of the joint fit hold the truth, coefficient by coefficient.

    python benchmarks/intervals.py [--campaigns 200] [--seed 20240601] [--processes 2]
                                   [--out FILE.npz] [--kept FILE.npz ...]

Each campaign is 18 trials (three powers, straight and turns to both sides, two heads) simulated
from Table I at 75 % with disturbed water, a servo that is off by 0.3 degrees from trial to trial,
lasting and white tracking errors and the tail beat's recoil; poses are smoothed and fitted like
any study. Beside the interval from the disagreement of the trials stand the jackknife with the
normal quantile and the naive covariance, which is why that is not used, and the disagreement of the
trials as if their errors were white (the servo's is not). Exits with 1 where a share lies outside
92 to 98 %. --out keeps the fits; --kept judges kept fits again, of several files together.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from bluekoi.fitting import (
    NormalEquationsByTrial,
    TrialRandomEffect,
    cluster_covariance,
    cov_jackknife,
)
from bluekoi.integrate import LANES, compile_system
from bluekoi.model import two_plate_system
from bluekoi.tuning import downsampled, fit_all_trials
from bluekoi.tuning.joint_fit import servo_error_information
from simulated_campaigns import COEFFICIENTS, ErrorModel, simulate_campaigns, trial_plans

NAMES = tuple(COEFFICIENTS)
TRUTH = np.array([COEFFICIENTS[name] for name in NAMES])
COVERAGE_RANGE = (0.92, 0.98)
SEED = 20240601
FIT_PARTS = ("values", "hessian", "gradient", "cross", "fisher", "score")


def fit_batch(job: tuple[int, int, int]) -> list[tuple[np.ndarray, ...]]:
    """Each campaign's joint fit, its parts as in `FIT_PARTS`."""
    seed, number, count = job
    rng = np.random.default_rng([seed, number])
    out = []
    for series in simulate_campaigns(trial_plans(), ErrorModel(), rng, count=count):
        few = downsampled(series)
        tuned = fit_all_trials(few)
        fit = tuned.fit
        own = servo_error_information(
            compile_system(two_plate_system()), few, fit, tuned.base, noise=tuned.noise
        )
        out.append((fit.values, fit.normal.hessian, fit.normal.gradient,
                    own.cross, own.fisher, own.score))  # fmt: skip
    return out


def fit_campaigns(count: int, seed: int, processes: int) -> list[tuple[np.ndarray, ...]]:
    """All campaigns, in batches of sixteen."""
    jobs = [(seed, i, min(LANES, count - i * LANES)) for i in range(-(-count // LANES))]
    if processes < 2:
        return [one for job in jobs for one in fit_batch(job)]
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        return [one for part in pool.map(fit_batch, jobs) for one in part]


def read_kept_fits(path: Path) -> list[tuple[np.ndarray, ...]]:
    """Fits as `--out` wrote them."""
    with np.load(path) as file:
        return list(zip(*(file[part] for part in FIT_PARTS), strict=True))


def interval_half_widths(
    normal: NormalEquationsByTrial, own: TrialRandomEffect
) -> dict[str, np.ndarray]:
    """Half widths of the 95 % intervals by each way to get them."""
    naive = np.linalg.inv(normal.hessian.sum(axis=0))
    return {
        "trials disagree": cluster_covariance(normal, None, own).half_widths(),
        "the same, white": cluster_covariance(normal).half_widths(),
        "jackknife, normal": 1.96 * np.sqrt(np.diag(cov_jackknife(normal))),
        "naive": 1.96 * np.sqrt(np.diag(naive)),
    }


def print_coverage(found: Sequence[tuple[np.ndarray, ...]]) -> bool:
    """Print shares and widths; whether the intervals in use are within the bar."""
    values = np.array([f[0] for f in found])
    ways = [
        interval_half_widths(
            NormalEquationsByTrial(f[1], f[2], np.zeros(len(f[1]))), TrialRandomEffect(*f[3:])
        )
        for f in found
    ]
    error = values - TRUTH
    spread = error.std(axis=0, ddof=1)
    servo_rad = np.sqrt(np.mean([TrialRandomEffect(*f[3:]).variance(f[1]) for f in found]))
    print(f"error of the head angle from trial to trial: found {servo_rad:.2g} rad, true 0.005")
    print(f"{len(found)} campaigns{'':22s}" + "".join(f"{name:>10s}" for name in NAMES))
    print(f"{'true value':35s}" + "".join(f"{v:10.4g}" for v in TRUTH))
    print(f"{'standard deviation found':35s}" + "".join(f"{v:10.2g}" for v in spread))
    print(f"{'bias over that':35s}" + "".join(f"{v:10.2f}" for v in error.mean(axis=0) / spread))
    good = True
    for way in ways[0]:
        half = np.array([w[way] for w in ways])
        share = (np.abs(error) <= half).mean(axis=0)
        print(f"{way + ', truth inside':35s}" + "".join(f"{100 * s:9.1f}%" for s in share))
        middle = np.median(half, axis=0) / spread
        print(f"{way + ', half width / deviation':35s}" + "".join(f"{m:10.2f}" for m in middle))
        print(f"{'   mean of the six':35s}{100 * share.mean():9.1f}%")
        if way == "trials disagree":
            good = bool(np.all((share >= COVERAGE_RANGE[0]) & (share <= COVERAGE_RANGE[1])))
    return good


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=200)
    parser.add_argument("--seed", type=int, default=SEED, help="other campaigns")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--out", type=Path, help="keep the fits here")
    parser.add_argument("--kept", type=Path, nargs="*", help="judge these fits, make no others")
    given = parser.parse_args()
    if given.kept:
        found = [one for path in given.kept for one in read_kept_fits(path)]
    else:
        found = fit_campaigns(given.campaigns, given.seed, given.processes)
    if given.out:
        np.savez(given.out, **{p: np.array([f[i] for f in found]) for i, p in enumerate(FIT_PARTS)})
    sys.exit(0 if print_coverage(found) else 1)


if __name__ == "__main__":
    main()

"""The published case as a study of its own: nine radii and three speeds, one coefficient set, and
which single added effect removes most of what is left, over a range of geometries.

    python benchmarks/published_case.py [--geometries 8] [--seed 1]

Prints a line an effect: root mean square misfit (%) of the nine radii, middle, lowest and highest
over the geometries, that of the three speeds, and in how many geometries it fits all twelve best.
See docs/paper.md.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from published_radii import (
    candidate_effects,
    fit_one_coefficient_set,
    plausible_geometries,
    published_radii_and_speeds,
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--geometries", type=int, default=8)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    rng = np.random.default_rng(given.seed)
    robots = plausible_geometries(given.geometries, rng)
    names = ("", *candidate_effects())
    misfit = np.zeros((len(names), len(robots), 2))
    for k, setup in enumerate(robots):
        seen = published_radii_and_speeds(setup)
        for i, name in enumerate(names):
            found = fit_one_coefficient_set(seen, setup, name)
            misfit[i, k] = found.misfit_pct, found.speed_misfit_pct
    whole = np.sqrt(misfit**2 @ np.array([9 / 12, 3 / 12]))
    best = [names[i] for i in whole.argmin(axis=0)]
    print(f"{'':26s}  radii, %: middle, lowest, highest; speeds, %; all, %; best in")
    for i in np.argsort(np.median(whole, axis=1)):
        radii, speeds = misfit[i].T
        print(f"{names[i] or 'one set, nothing added':26s}{np.median(radii):8.1f}{min(radii):8.1f}"
              f"{max(radii):8.1f}{np.median(speeds):8.1f}{np.median(whole[i]):8.1f}"
              f"{best.count(names[i]):5d} of {len(robots)}")  # fmt: skip


if __name__ == "__main__":
    main()

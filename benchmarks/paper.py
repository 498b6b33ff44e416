"""The published case as a study of its own: nine radii and three speeds, one coefficient set, and
which single added effect removes most of what is left, over a range of geometries.

    python benchmarks/paper.py [--geometries 12] [--seed 1]

Prints a line an effect: root mean square misfit of the nine radii (%), middle, lowest and highest
over the geometries, beside that of one coefficient set alone. See docs/paper.md.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from nine_numbers import candidates, fitted, geometries, radii_and_speeds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--geometries", type=int, default=12)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    rng = np.random.default_rng(given.seed)
    robots = geometries(given.geometries, rng)
    misfits: dict[str, list[float]] = {name: [] for name in ("", *candidates())}
    for setup in robots:
        seen = radii_and_speeds(setup)
        for name, row in misfits.items():
            row.append(fitted(seen, setup, name).misfit_pct)
    table = np.array(list(misfits.values()))
    best = [list(misfits)[1 + int(np.argmin(column[1:]))] for column in table.T]
    print(f"{'':26s} misfit of nine radii, %: middle, lowest, highest; best in")
    for name, row in sorted(misfits.items(), key=lambda item: np.median(item[1])):
        print(f"{name or 'one set, nothing added':26s}{np.median(row):8.1f}{min(row):8.1f}"
              f"{max(row):8.1f}{best.count(name):8d} of {len(robots)}")  # fmt: skip


if __name__ == "__main__":
    main()

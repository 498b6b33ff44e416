"""Command line: `python -m validation.generators.quasi_steady --seed 1 --count 40 DIR`."""

import argparse
import sys
import time
from pathlib import Path

from validation.generators.quasi_steady.studies import generate


def main() -> None:
    """Write the studies and name each on standard error."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("directory", type=Path)
    args = parser.parse_args()
    for index in range(args.first, args.first + args.count):
        began = time.process_time()
        truth = generate(args.seed, index, args.directory)
        names = [(c["name"], c["form"], c["sigma"]) for c in truth["causes"]]
        if truth["unlisted"]:
            names.append(("unlisted", truth["unlisted"]["form"], truth["unlisted"]["sigma"]))
        spent = time.process_time() - began
        sys.stderr.write(f"{truth['study']} {truth['group']} {spent:.1f} s {names}\n")


if __name__ == "__main__":
    main()

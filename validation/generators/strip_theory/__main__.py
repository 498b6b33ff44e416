"""Command line: `python -m validation.generators.strip_theory --seed S --count N --first K DIR`."""

import argparse
import sys
import time
from pathlib import Path

from validation.generators.strip_theory.studies import generate


def main() -> None:
    """Write the studies asked for and a line about each on standard error (no truth in it)."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("directory", type=Path)
    asked = parser.parse_args()
    for index in range(asked.first, asked.first + asked.count):
        start = time.process_time()
        truth = generate(asked.seed, index, asked.directory)
        sys.stderr.write(f"{truth['study']} {time.process_time() - start:.1f} s\n")


if __name__ == "__main__":
    main()

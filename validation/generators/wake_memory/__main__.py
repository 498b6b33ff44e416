"""Command line: `python -m validation.generators.wake_memory --seed S --count N --first K DIR`."""

import argparse
from pathlib import Path

from .studies import generate


def main() -> None:
    """Write studies `first` to `first + count - 1` of the seed below a directory."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("directory", type=Path)
    options = parser.parse_args()
    for index in range(options.first, options.first + options.count):
        generate(options.seed, index, options.directory)


if __name__ == "__main__":
    main()

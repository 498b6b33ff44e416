"""Command line: python -m validation.generators.manoeuvring --seed S --count N --first K DIR."""

import argparse
import logging
from pathlib import Path

from validation.generators.manoeuvring.studies import generate


def main() -> None:
    """Write `count` studies from index `first`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, required=True, help="seed of the series")
    parser.add_argument("--count", type=int, default=40, help="number of studies")
    parser.add_argument("--first", type=int, default=0, help="index of the first study")
    parser.add_argument("directory", type=Path, help="folder that receives studies/ and truth/")
    a = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    for index in range(a.first, a.first + a.count):
        reported = generate(a.seed, index, a.directory)
        hidden = [f"{c['name']}:{c['form']} {c['sigma']:.1f}" for c in reported["causes"]]
        extra = reported["unlisted"]
        hidden += [f"{extra['form']} {extra['sigma']:.1f}"] if extra else []
        logging.info("%s %s %s", reported["study"], reported["group"], ", ".join(hidden))


if __name__ == "__main__":
    main()

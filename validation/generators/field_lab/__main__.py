"""Command line: ``python -m validation.generators.field_lab --seed S --count N --first K DIR``."""

import argparse
import logging
import time
from pathlib import Path

from .studies import generate


def main() -> None:
    """Write the studies asked for; studies whose truth exists are skipped."""
    parser = argparse.ArgumentParser(prog="field_lab", description=__doc__)
    parser.add_argument("--seed", type=int, default=1, help="seed of the series")
    parser.add_argument("--count", type=int, default=40, help="number of studies")
    parser.add_argument("--first", type=int, default=0, help="index of the first study")
    parser.add_argument("directory", type=Path, help="receives studies/ and truth/")
    args = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    for index in range(args.first, args.first + args.count):
        begun = time.process_time()
        t = generate(args.seed, index, args.directory)
        seen = {c["name"]: c["sigma"] for c in t["causes"]}
        if t["unlisted"]:
            seen[t["unlisted"]["form"]] = t["unlisted"]["sigma"]
        spent = time.process_time() - begun
        logging.info("%s %s %d %s %.1f s", t["study"], t["group"], t["trials"], seen, spent)


if __name__ == "__main__":
    main()

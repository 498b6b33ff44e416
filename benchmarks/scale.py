"""Campaigns of keypoint files of growing size through the workflow: Snakemake's own share of the
processor time, and time and memory a trial, which must not grow with the number of trials.

    python benchmarks/scale.py [--trials 66 1000] [--goal steady.csv] [--cores 2] [--folder DIR]

Without --goal the whole way to report.html; the fits and the search then grow with the trials.
"""

from __future__ import annotations

import argparse
import csv
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from studies import small_study  # noqa: E402

TICK = os.sysconf("SC_CLK_TCK")


def campaign(folder: Path, trials: int) -> Path:
    """A study of so many trials: three simulated ones over and over, each with files of its own."""
    base = small_study(folder / "base")
    study = folder / f"study{trials}"
    study.mkdir()
    shutil.copy(base / "study.yaml", study)
    with (base / "trials.csv").open(newline="") as lines:
        rows = list(csv.DictReader(lines))
    made = []
    for i in range(trials):
        row = dict(rows[i % len(rows)])
        name = f"N{i:04d}"
        for column in ("source", "motor_log"):
            if not row.get(column):
                continue
            target = study / Path(row[column]).parent / f"{name}.csv"
            target.parent.mkdir(exist_ok=True)
            shutil.copy(base / row[column], target)
            row[column] = str(target.relative_to(study))
        made.append(row | {"trial_id": name})
    with (study / "trials.csv").open("w", newline="") as out:
        writer = csv.DictWriter(out, rows[0])
        writer.writeheader()
        writer.writerows(made)
    return study


def own_seconds(pid: int) -> tuple[float, float]:
    """Processor time of one process without its children, s, and its memory, MB."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        status = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return 0.0, 0.0
    peak = next((line for line in status.splitlines() if line.startswith("VmHWM")), "VmHWM: 0 kB")
    return (int(fields[11]) + int(fields[12])) / TICK, int(peak.split()[1]) / 1024


def run(study: Path, results: Path, goal: str | None, cores: int) -> dict[str, float]:
    """Seconds of wall, of the processor in all and in Snakemake alone, and its memory."""
    goals = [str(results / goal)] if goal else []
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "Snakefile"), *goals]
    command += ["--workflow-profile", str(ROOT / "config/profiles/default"), "--cores", str(cores)]
    command += ["--config", f"study={study}", f"results={results}"]
    start, own, peak = time.monotonic(), 0.0, 0.0
    process = subprocess.Popen(command, cwd=study.parent, stderr=subprocess.DEVNULL)
    while True:
        pid, status, usage = os.wait4(process.pid, os.WNOHANG)
        if pid:
            break
        used, memory = own_seconds(process.pid)
        own, peak = max(own, used), max(peak, memory)
        time.sleep(0.2)
    if os.waitstatus_to_exitcode(status):
        sys.exit(f"the run of {study} failed")
    total = usage.ru_utime + usage.ru_stime
    return {"wall": time.monotonic() - start, "all": total, "own": own, "memory": peak}


def stages(results: Path) -> dict[str, tuple[float, float]]:
    """Median wall seconds and greatest memory, MB, of the stages that run once a trial."""
    found = {}
    for folder in sorted((results / "benchmarks").iterdir()):
        if folder.is_dir() and folder.name != "figures":
            rows = [_row(path) for path in folder.glob("*.tsv")]
            memory = [float(row["max_rss"]) for row in rows if row["max_rss"] not in ("NA", "-")]
            seconds = statistics.median(float(row["s"]) for row in rows)
            found[folder.name] = (seconds, max(memory, default=float("nan")))
    return found


def _row(path: Path) -> dict[str, str]:
    with path.open(newline="") as lines:
        return next(csv.DictReader(lines, delimiter="\t"))


def show(trials: int, used: dict[str, float], found: dict[str, tuple[float, float]]) -> None:
    each = ", ".join(f"{n} {s:.2f} s {mb:.0f} MB" for n, (s, mb) in found.items())
    print(
        f"{trials} trials: {used['wall']:.0f} s, processor {used['all'] / trials:.2f} s a trial, "
        f"Snakemake alone {used['own']:.1f} s = {100 * used['own'] / used['all']:.1f} % and "
        f"{used['memory']:.0f} MB; {each}",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, nargs="+", default=[66, 1000])
    parser.add_argument("--goal", help="a file of the results to stop at")
    parser.add_argument("--cores", type=int, default=2)
    parser.add_argument("--folder", type=Path)
    options = parser.parse_args()
    if options.folder:
        options.folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=options.folder) as name:
        for trials in options.trials:
            folder = Path(name) / str(trials)
            folder.mkdir()
            study = campaign(folder, trials)
            used = run(study, folder / "results", options.goal, options.cores)
            show(trials, used, stages(folder / "results"))


if __name__ == "__main__":
    main()

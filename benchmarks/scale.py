"""Campaigns of growing size through the workflow: Snakemake's own share of the processor time, and
time and memory a trial, which must not grow with the number of trials.

    python benchmarks/scale.py [--trials 66 1000] [--films] [--goal steady.csv] [--folder DIR]

Without --goal the whole way to report.html; the fits and the search then grow with the trials.
"""

from __future__ import annotations

import argparse
import csv
import math
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))  # validation/

from bluekoi.synthetic.picture_conditions import PictureConditions  # noqa: E402
from bluekoi.synthetic.study_rendering import render_trial, write_study_files  # noqa: E402
from bluekoi.synthetic.synthetic_study_design import picture_conditions_design  # noqa: E402
from validation.generators.concealed.studies import generate  # noqa: E402

CLOCK_TICKS_PER_S = os.sysconf("SC_CLK_TCK")
FIN_STUDY_SEED = (811, 0)
"""Seed and number of a study of the generator."""


def filmed_study(folder: Path) -> Path:
    """Three rendered trials of three to four seconds at 1080p: straight, a turn to either side."""
    design = picture_conditions_design(PictureConditions())
    write_study_files(design, folder, source="videos/{}.mp4", fps=None)
    for plan in design.plans:
        render_trial(design, plan.trial_id, folder, folder.with_name("truth"), threads=1)
    return folder


def make_campaign(folder: Path, trials: int, *, films: bool = False) -> Path:
    """A study of so many trials, each of its own: keypoints of the project's generator, or films.

    Films are further names of the same three, so that the disk does not fill.
    """
    study = folder / f"study{trials}"
    if study.is_dir():
        return study
    if not films:
        return simulated_study(folder, study, trials)
    base = filmed_study(folder / "base")
    study.mkdir()
    shutil.copy(base / "study.yaml", study)
    rows = read_rows(base / "trials.csv")
    made = [
        row_of_copied_trial(base, study, rows[i % len(rows)], f"N{i:04d}") for i in range(trials)
    ]
    write_rows(study / "trials.csv", made)
    return study


def simulated_study(folder: Path, study: Path, trials: int) -> Path:
    """A study of the project's own generator, of a robot with a fin that the model lacks."""
    truth = generate(*FIN_STUDY_SEED, folder, trials=3 * math.ceil(trials / 3))
    (folder / "studies" / truth["study"]).rename(study)
    write_rows(study / "trials.csv", read_rows(study / "trials.csv")[:trials])
    return study


def read_rows(path: Path) -> list[dict[str, str]]:
    """Rows of a table by column."""
    with path.open(newline="") as lines:
        return list(csv.DictReader(lines))


def write_rows(path: Path, rows: list[dict[str, str]]) -> None:
    """A table of rows that have the same columns."""
    with path.open("w", newline="") as out:
        writer = csv.DictWriter(out, rows[0])
        writer.writeheader()
        writer.writerows(rows)


def row_of_copied_trial(base: Path, study: Path, row: dict[str, str], name: str) -> dict[str, str]:
    """Row of a trial `name` that has the files of `row`."""
    files = {}
    for column in ("source", "motor_log"):
        if given := row.get(column):
            target = study / Path(given).parent / f"{name}{Path(given).suffix}"
            target.parent.mkdir(exist_ok=True)
            put = os.link if target.suffix == ".mp4" else shutil.copy
            put(base / given, target)
            files[column] = str(target.relative_to(study))
    return row | files | {"trial_id": name}


@dataclass(frozen=True)
class ResourceUse:
    """Processor seconds of a Snakemake run: its own process alone, and all with its jobs; wall
    seconds; greatest memory of its own process, MB.
    """

    own: float = 0.0
    all: float = 0.0
    wall: float = 0.0
    memory: float = 0.0


def resource_use(pid: int, before: ResourceUse) -> ResourceUse:
    """What a process and the jobs it has waited for have used; `before` once it has ended.

    Processor time, so that other work on the machine does not count.
    """
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        status = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return before
    peak = next((line for line in status.splitlines() if line.startswith("VmHWM")), None)
    if peak is None:
        return before
    own, jobs = (sum(int(n) for n in fields[i : i + 2]) / CLOCK_TICKS_PER_S for i in (11, 13))
    return ResourceUse(own, own + jobs, before.wall, int(peak.split()[1]) / 1024)


def run_study(study: Path, results: Path, goal: str | None, cores: int) -> ResourceUse:
    """The study run to `goal`; resources used are printed each minute, for runs of hours."""
    goals = [str(results / goal)] if goal else []
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "Snakefile"), *goals]
    command += ["--workflow-profile", str(ROOT / "config/profiles/default"), "--cores", str(cores)]
    command += ["--config", f"study={study}", f"results={results}"]
    start, used, reported = time.monotonic(), ResourceUse(), 0.0
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    env = os.environ | {"PYTHONPATH": str(ROOT / "pipeline")}
    with (results.parent / "snakemake.log").open("a") as log:
        process = subprocess.Popen(command, cwd=study.parent, stderr=log, env=env)
        while process.poll() is None:
            used = resource_use(process.pid, used)
            used = replace(used, wall=time.monotonic() - start)
            if used.wall > reported + 60:
                reported = used.wall
                jobs = sum(1 for _ in (results / "benchmarks").rglob("*.tsv"))
                print(f"  {used.wall:.0f} s: {jobs} jobs; {snakemake_share_text(used)}", flush=True)
            time.sleep(0.1)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = replace(used, all=after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    if process.returncode:
        sys.exit(f"the run of {study} failed; see {log.name}")
    return used


def snakemake_share_text(used: ResourceUse) -> str:
    """Snakemake's own share in words."""
    part = 100 * used.own / max(used.all, CLOCK_TICKS_PER_S**-1)
    return (
        f"processor {used.all:.0f} s, Snakemake alone {used.own:.1f} s = {part:.1f} % "
        f"and {used.memory:.0f} MB"
    )


def snakemake_rule_times_and_memory(results: Path) -> list[tuple[str, int, float, float]]:
    """Each rule's name, number of jobs, median processor seconds and greatest memory, MB."""
    rows: dict[str, list[dict[str, str]]] = {}
    for path in sorted((results / "benchmarks").rglob("*.tsv")):
        name = path.relative_to(results / "benchmarks").parts[0].removesuffix(".tsv")
        rows.setdefault(name, []).append(_read_benchmark_row(path))
    return [
        (
            name,
            len(of),
            statistics.median(_known_numbers(of, "cpu_time")),
            max(_known_numbers(of, "max_rss")),
        )
        for name, of in rows.items()
    ]


def _known_numbers(rows: list[dict[str, str]], column: str) -> list[float]:
    """Numbers of a column; psutil has none of a job that ended within its first look."""
    return [float(row[column]) for row in rows if row[column] not in ("NA", "-")] or [math.nan]


def _read_benchmark_row(path: Path) -> dict[str, str]:
    with path.open(newline="") as lines:
        return next(csv.DictReader(lines, delimiter="\t"))


def print_resources(
    trials: int, used: ResourceUse, found: list[tuple[str, int, float, float]]
) -> None:
    print(
        f"{trials} trials: {used.wall:.0f} s; {used.all / trials:.2f} s a trial; "
        f"{snakemake_share_text(used)}"
    )
    for name, jobs, seconds, memory in found:
        print(f"  {name:10s} {jobs:5d} jobs, {seconds:7.2f} s, {memory:5.0f} MB", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, nargs="+", default=[66, 1000])
    parser.add_argument("--goal", help="a file of the results to stop at")
    parser.add_argument("--films", action="store_true", help="rendered videos, not keypoints")
    parser.add_argument("--cores", type=int, default=2)
    parser.add_argument("--folder", type=Path, help="keeps studies and results, and goes on there")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        for trials in options.trials:
            folder = (options.folder or Path(name)).resolve() / str(trials)
            folder.mkdir(parents=True, exist_ok=True)
            study = make_campaign(folder, trials, films=options.films)
            used = run_study(study, folder / "results", options.goal, options.cores)
            print_resources(trials, used, snakemake_rule_times_and_memory(folder / "results"))


if __name__ == "__main__":
    main()

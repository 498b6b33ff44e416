"""Results of validation runs as data, and the page docs/evidence.md made of them.

A run of one finder on the studies of one generator is one file, `validation/results/NAME.json`:

    {"finder": "...", "commit": "...", "date": "2026-11-23", "generator": "kirchhoff",
     "development": false,
     "studies": [{"study": "000", "group": "null", "fin": true, "trials": 24,
                  "truth": ["tail_fin_lift"], "named": {"tail_fin_lift": 0.99}, "strict": true,
                  "floor_m": 0.001, "baseline_m": 0.012, "extended_m": 0.0011,
                  "cpu_s": 9.1, "failure": ""}]}

finder: name of the version that was run. generator: package in validation/generators. development:
whether studies of that generator were inspected while the finder was developed. slope: that of the
stated probabilities (`bluekoi.engine.calibration`; where it is missing they are those of the
posterior, slope 1). group: kind of study (`null`: nothing is hidden but perhaps a fin). truth:
names of the hidden causes; `unexplained` stands for a force that is not on the list. named:
cause -> stated probability. Path errors are those on held-out trials.
"""

from __future__ import annotations

import hashlib
import itertools
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bluekoi.engine.calibration import LOG_ODDS_CALIBRATION_SLOPE

from .scoring import PROBABILITY_BIN_EDGES, UNEXPLAINED, ScoredStudy, clopper_pearson

ROOT = Path(__file__).resolve().parents[1]
RESULTS_FOLDER = ROOT / "validation/results"
EVIDENCE_PAGE = ROOT / "docs/evidence.md"
CALIBRATION_PLOT = ROOT / "docs/evidence/calibration.svg"
BEGIN_MARKER, END_MARKER = "<!-- results: begin -->", "<!-- results: end -->"
DEVELOPMENT_GENERATORS = ("quasi_steady", "strip_theory", "kirchhoff", "manoeuvring", "wake_memory",
               "field_lab", "tow_tank", "coupled_bodies", "potential_flow",
               "towing_basin", "flume_team", "glass_tank", "basin_trials",
               "race_track", "pond_fleet", "leading_plate", "campus_pool", "harbour_dock",
               "tidal_lock")  # fmt: skip
"""Generators whose studies were inspected while the finder was developed."""
OWN_GENERATORS = ("concealed", "concealed_footage")
"""Our own generator, from keypoints and from footage."""
REQUIRED_KEYS = ("finder", "commit", "generator", "studies")
REQUIRED_STUDY_KEYS = ("study", "group", "fin", "trials", "truth", "named", "strict")
MAX_NOISE_FLOOR_RATIO = 1.3
"""A held-out path error within this factor of the noise floor counts as explained."""


@dataclass(frozen=True)
class Run:
    """One finder on one generator; studies as in the module's docstring."""

    finder: str
    commit: str
    date: str
    generator: str
    development: bool
    studies: Sequence[Mapping[str, Any]]
    slope: float = 1.0

    @property
    def rank(self) -> tuple[int, str]:
        """Order in tables: generators not used in development first, our own last."""
        return (2 if self.generator in OWN_GENERATORS else int(self.development), self.generator)


def record(
    studies: Sequence[ScoredStudy], *, finder: str, commit: str, date: str
) -> dict[str, dict[str, Any]]:
    """Content of a result file for each generator of scored studies, by generator."""
    names = sorted({s.generator for s in studies})
    return {
        name: {
            "finder": finder, "commit": commit, "date": date, "generator": name,
            "development": name in DEVELOPMENT_GENERATORS, "slope": LOG_ODDS_CALIBRATION_SLOPE,
            "studies": [_study_record(s) for s in studies if s.generator == name],
        }
        for name in names
    }  # fmt: skip


def _study_record(s: ScoredStudy) -> dict[str, Any]:
    errors = {key: s.held_out.get(key) or {} for key in ("baseline", "extended")}
    return {
        "study": s.study, "group": s.group, "fin": s.fin, "trials": s.trials,
        "truth": list(s.true), "named": {n: round(float(p), 3) for n, p in s.said.items()},
        "strict": s.strict,
        "baseline_m": errors["baseline"].get("path_rmse_m"),
        "extended_m": errors["extended"].get("path_rmse_m"),
        "floor_m": s.held_out.get("noise_floor_path_rmse_m"),
        "cpu_s": round(s.cpu_s, 1), "failure": s.failure,
    }  # fmt: skip


def write_results(
    content: Mapping[str, Mapping[str, Any]], folder: Path = RESULTS_FOLDER
) -> list[Path]:
    """Write one file for each generator, `FINDER-GENERATOR.json`; a study takes one line."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for generator, run in content.items():
        head = {key: value for key, value in run.items() if key != "studies"}
        rows = ",\n  ".join(json.dumps(row) for row in run["studies"])
        paths.append(folder / f"{run['finder']}-{generator}.json")
        paths[-1].write_text(f'{json.dumps(head)[:-1]}, "studies": [\n  {rows}\n]}}\n')
    return paths


def load_runs(folder: Path = RESULTS_FOLDER) -> list[Run]:
    """All runs of a folder in the order of the tables.

    Raises: ValueError with the file and the missing keys.
    """
    return sorted(
        (_parse_run(path) for path in sorted(folder.glob("*.json"))), key=lambda r: r.rank
    )


def _parse_run(path: Path) -> Run:
    content = json.loads(path.read_text(encoding="utf-8"))
    missing = [key for key in REQUIRED_KEYS if key not in content]
    missing += sorted({f"studies[].{key}" for row in content.get("studies", ())
                       for key in REQUIRED_STUDY_KEYS if key not in row})  # fmt: skip
    if missing:
        raise ValueError(f"{path}: missing {', '.join(missing)}; see validation/report.py")
    development = bool(content.get("development", content["generator"] in DEVELOPMENT_GENERATORS))
    return Run(content["finder"], content["commit"], content.get("date", ""),
               content["generator"], development, tuple(content["studies"]),
               float(content.get("slope", 1.0)))  # fmt: skip


def updated_page(text: str, runs: Sequence[Run]) -> str:
    """The page with the part between its markers made from `runs`."""
    before, rest = text.split(BEGIN_MARKER)
    after = rest.split(END_MARKER)[1]
    return f"{before}{BEGIN_MARKER}\n{result_tables(runs)}\n{END_MARKER}{after}"


def result_tables(runs: Sequence[Run]) -> str:
    """Tables as Markdown: the current finder in full, the others in one row each."""
    if not runs:
        return "\nNo run is recorded.\n"
    name = current_finder(runs)
    lines = [
        *_finder_tables([r for r in runs if r.finder == name]),
        *_finder_comparison(runs, name),
        *_wrong_verdicts(runs),
    ]
    return "\n".join(lines)


def current_finder(runs: Sequence[Run]) -> str:
    """Name of the finder that was run last."""
    return max(runs, key=lambda run: (run.date, run.finder)).finder


def _finder_tables(runs: Sequence[Run]) -> Iterator[str]:
    commits = ", ".join(sorted({f"`{run.commit}`" for run in runs}))
    dates = ", ".join(sorted({run.date[:10] for run in runs if run.date}))
    yield (
        f"\nVersion `{runs[0].finder}` of the finder (commit {commits}"
        f"{f', run on {dates}' if dates else ''}).\n"
    )
    yield "### By generator\n"
    yield from _table_heading("generator")
    parts = {"**unknown generators**": [r for r in runs if r.rank[0] == 0],
             "**known generators, new studies**": [r for r in runs if r.rank[0] == 1],
             "**own generator**": [r for r in runs if r.rank[0] == 2]}  # fmt: skip
    for title, part in parts.items():
        if not part:
            continue
        yield _score_row(title, _all_studies(part))
        yield from (_score_row(f"`{run.generator}`", run.studies) for run in part)
    judged = _all_studies([r for r in runs if r.rank[0] == 0]) or _all_studies(runs)
    which = "unknown generators" if parts[next(iter(parts))] else "all generators"
    yield f"\n### By kind of study\n\nStudies of {which}.\n"
    yield "| studies | number | strict | all causes named |\n|---|---|---|---|"
    for title, test in _score_rows_by_kind(judged).items():
        some = [s for s in judged if test(s)]
        if some:
            cells = (_share_cell(some, _is_strictly_right), _share_cell(some, all_causes_named))
            yield f"| {title} | {len(some)} | {' | '.join(cells)} |"
    yield f"\n### Calibration\n\nProbabilities of named causes, {which}.\n"
    yield "| stated probability | mean | true | share, 95 % interval |\n|---|---|---|---|"
    for one in reliability_bins(judged):
        low, high = one["interval_95"]
        yield (
            f"| {one['from']:.1f} to {one['to']:.1f} | {one['mean']:.2f} "
            f"| {one['true']} of {one['count']} "
            f"| {_percent_cell(one['true'] / one['count'], low, high)} |"
        )
    yield f"\n![Calibration]({CALIBRATION_PLOT.relative_to(EVIDENCE_PAGE.parent)})\n"
    yield (
        "*Share of named causes that were true, over their stated probability, with 95 % intervals "
        "and the number of causes. On the line, probabilities are right.*\n"
    )
    yield f"\n{_error_rows(judged)}\n"


def _finder_comparison(runs: Sequence[Run], name: str) -> Iterator[str]:
    """A row for each finder on the generators that all of them were run on."""
    finders = sorted({r.finder for r in runs}, key=lambda f: (f != name, f))
    if len(finders) < 2:
        return
    shared = set.intersection(*({r.generator for r in runs if r.finder == f} for f in finders))
    if not shared:
        return
    yield "\n### Other finders\n"
    yield f"On the same generators: {', '.join(f'`{g}`' for g in sorted(shared))}.\n"
    yield from _table_heading("finder")
    for f in finders:
        mine = [r for r in runs if r.finder == f and r.generator in shared]
        yield _score_row(f"`{f}`", _all_studies(mine))
    yield ""


def _wrong_verdicts(runs: Sequence[Run]) -> Iterator[str]:
    """A row for each wrong verdict of any recorded version, the latest version first."""
    yield "\n### Wrong verdicts\n"
    yield "Hidden and named causes of every study with a wrong verdict, by version of the finder.\n"
    yield "| version | study | hidden | named (probability) |\n|---|---|---|---|"
    for run in sorted(runs, key=lambda r: (r.date, r.finder), reverse=True):
        for s in run.studies:
            if not _is_strictly_right(s):
                named = ", ".join(f"`{n}` {p:.2f}" for n, p in s["named"].items()) or "none"
                hidden = ", ".join(f"`{n}`" for n in s["truth"]) or "none"
                name = s["study"].removeprefix(f"{run.generator}-")
                yield f"| `{run.finder}` | {run.generator} {name} | {hidden} | {named} |"
    yield ""


def _score_rows_by_kind(
    studies: Sequence[Mapping[str, Any]],
) -> dict[str, Callable[[Mapping[str, Any]], bool]]:
    groups = sorted({s["group"] for s in studies})
    return {
        "with a fin": lambda s: s["fin"],
        "without a fin": lambda s: not s["fin"],
        "more than nine trials": lambda s: s["trials"] > 9,
        "nine trials or fewer": lambda s: s["trials"] <= 9,
        **{f"kind `{g}`": lambda s, g=g: s["group"] == g for g in groups},
    }


def _all_studies(runs: Sequence[Run]) -> list[Mapping[str, Any]]:
    return [study for run in runs for study in run.studies]


def _is_strictly_right(study: Mapping[str, Any]) -> bool:
    return bool(study["strict"])


def all_causes_named(study: Mapping[str, Any]) -> bool:
    """Whether every hidden cause is named."""
    return not study.get("failure") and set(study["truth"]) <= set(study["named"])


def wrongly_named_causes(study: Mapping[str, Any]) -> list[str]:
    """Named causes that are not hidden; `unexplained` apart, which claims no cause."""
    return [n for n in study["named"] if n not in study["truth"] and n != UNEXPLAINED]


def _table_heading(first: str) -> Iterator[str]:
    names = ("studies", "strict", "all causes named", "nulls", "a false name", "unlisted forces")
    yield f"| {first} | {' | '.join(names)} |"
    yield "|---" * (len(names) + 1) + "|"


def _score_row(title: str, studies: Sequence[Mapping[str, Any]]) -> str:
    nulls = [s for s in studies if s["group"] == "null"]
    unlisted = [s for s in studies if UNEXPLAINED in s["truth"]]
    cells = (
        _share_cell(studies, _is_strictly_right),
        _share_cell(studies, all_causes_named),
        _share_cell(nulls, _is_strictly_right),
        _share_cell(studies, lambda s: bool(wrongly_named_causes(s))),
        _share_cell(unlisted, all_causes_named),
    )
    return f"| {title} | {len(studies)} | {' | '.join(cells)} |"


def _share_cell(
    studies: Sequence[Mapping[str, Any]], test: Callable[[Mapping[str, Any]], bool]
) -> str:
    if not studies:
        return ""
    hits, count = sum(map(test, studies)), len(studies)
    low, high = clopper_pearson(hits, count)
    return f"{hits} of {count}: {_percent_cell(hits / count, low, high)}"


def _percent_cell(value: float, low: float, high: float) -> str:
    return f"{100 * value:.0f} % ({100 * low:.0f} to {100 * high:.0f})"


def reliability_bins(studies: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Bins of width 0.1 of the probabilities of named causes: how many were true."""
    pairs = [(min(p, 1.0), name in s["truth"]) for s in studies for name, p in s["named"].items()]
    out = []
    for low, high in itertools.pairwise(PROBABILITY_BIN_EDGES):
        inside = [(p, true) for p, true in pairs if low <= p < high or p == high == 1.0]
        if inside:
            hits, count = sum(true for _, true in inside), len(inside)
            out.append({"from": float(low), "to": float(high), "true": hits, "count": count,
                        "mean": float(np.mean([p for p, _ in inside])),
                        "interval_95": clopper_pearson(hits, count)})  # fmt: skip
    return out


def _error_rows(studies: Sequence[Mapping[str, Any]]) -> str:
    known = [s for s in studies if s.get("extended_m") and s.get("floor_m")]
    times = [s["cpu_s"] for s in studies if s.get("cpu_s")]
    lines = []
    if known:
        floors = [s["extended_m"] / s["floor_m"] for s in known]
        before = [s["baseline_m"] * 1000 for s in known if s.get("baseline_m")]
        after = [s["extended_m"] * 1000 for s in known]
        within = sum(f <= MAX_NOISE_FLOOR_RATIO for f in floors)
        lines.append(
            f"The median path error on held-out trials is {np.median(before):.1f} mm without and "
            f"{np.median(after):.1f} mm with the named causes. With them, it is at most "
            f"{MAX_NOISE_FLOOR_RATIO} times the noise floor in {within} of {len(known)} studies."
        )
    if times:
        lines.append(
            f"The median processor time of the finder is {np.median(times):.0f} s, the longest "
            f"{max(times):.0f} s."
        )
    failed = [s["study"] for s in studies if s.get("failure")]
    lines.append(f"The finder failed in {len(failed)} of {len(studies)} studies.")
    return "\n".join(lines)


def draw_calibration_plot(runs: Sequence[Run], path: Path = CALIBRATION_PLOT) -> None:
    """The calibration plot of the latest finder: share of true causes over stated probability."""
    from .calibration_plot import calibration_plot  # noqa: PLC0415  matplotlib is slow to load

    mine = [run for run in runs if run.finder == current_finder(runs)]
    sets = {
        "unknown generators": [r for r in mine if r.rank[0] == 0],
        "known generators": [r for r in mine if r.rank[0] == 1],
        "own generator": [r for r in mine if r.rank[0] == 2],
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    bins = {k: reliability_bins(_all_studies(v)) for k, v in sets.items() if v}
    calibration_plot(bins, path, description=results_hash(runs))


def results_hash(runs: Sequence[Run]) -> str:
    """Short hash of all results, kept in the plot to show which ones it was drawn from."""
    rows = [[r.finder, r.generator, r.date, [dict(s) for s in r.studies]] for r in runs]
    return hashlib.sha256(json.dumps(rows, sort_keys=True).encode()).hexdigest()[:16]


def update_evidence_page() -> None:
    """Make the generated part of docs/evidence.md and its plot again."""
    runs = load_runs()
    EVIDENCE_PAGE.write_text(
        updated_page(EVIDENCE_PAGE.read_text(encoding="utf-8"), runs), encoding="utf-8"
    )
    if runs:
        draw_calibration_plot(runs)

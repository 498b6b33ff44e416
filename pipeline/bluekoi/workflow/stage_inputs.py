"""Results of the stages on the whole study that were made from other inputs than the present ones.

Snakemake notices changed settings and code by its own records, which lie outside the results and
stay behind when these are copied or moved. `status/stages/inputs.json`, in the results, goes with
them.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ..errors import InputError
from ..files import read_json, write_json
from ..stages.freshness import short_hash
from ..stages.result_paths import ResultPaths, remove_files
from .figure_sources import figure_fingerprint, figure_names, figure_title_and_caption
from .plan import RunPlan


def stage_input_hashes(plan: RunPlan) -> dict[str, str]:
    """Hash of what each stage on the whole study depends on, beside the results before it."""
    code, fits = plan.code_fingerprint, plan.fit_fingerprint()
    hashes = {
        "keypoint_errors": short_hash(code("keypoint_errors"), plan.geometry_fingerprint()),
        "geometry": short_hash(code("geometry"), plan.geometry_fingerprint()),
        "steady": short_hash(code("steady"), plan.all_trial_ids),
        "tuning": short_hash(code("tuning"), fits),
        "mismatch": short_hash(code("mismatch"), fits),
        "report": code("report"),
        "outcome": code("outcome"),
    }
    return hashes | {
        f"figures/{name}": short_hash(figure_fingerprint(name), figure_title_and_caption(name))
        for name in figure_names()
    }


def outdated_stages(plan: RunPlan, hashes: Mapping[str, str]) -> list[str]:
    """Stages whose results are there, made from other inputs or by a version that kept no record.

    A figure's name follows a slash.
    """
    try:
        made_from = read_json(_stage_input_hashes_file(plan))
    except InputError:
        made_from = {}
    return [
        stage for stage, now in hashes.items()
        if made_from.get(stage) != now
        and any(p.is_file() for p in _result_files_of_stage(plan.results, stage))
    ]  # fmt: skip


def remove_outdated_results(plan: RunPlan) -> None:
    """Remove the results of outdated stages, so that they are made again; record the inputs."""
    hashes = stage_input_hashes(plan)
    for stage in outdated_stages(plan, hashes):
        remove_files(_result_files_of_stage(plan.results, stage))
    write_json(_stage_input_hashes_file(plan), hashes)


def remove_results_of_other_trials(plan: RunPlan) -> None:
    """Remove what earlier runs made of trials that the study no longer has."""
    layout, known = ResultPaths(plan.results), set(plan.all_trial_ids)
    for example in layout.trial_files("*"):
        stale = [p for p in example.parent.glob(example.name) if p.name.split(".")[0] not in known]
        remove_files(stale)


def _stage_input_hashes_file(plan: RunPlan) -> Path:
    return plan.results / "status" / "stages" / "inputs.json"


def _result_files_of_stage(results: Path, stage: str) -> list[Path]:
    layout = ResultPaths(results)
    own = {
        "keypoint_errors": [layout.keypoint_errors],
        "geometry": [layout.geometry],
        "steady": [layout.steady],
        "tuning": layout.tuning_files,
        "mismatch": layout.mismatch_files,
        "report": [layout.report],
        "outcome": [layout.outcome],
    }
    return list(own.get(stage) or [results / f"{stage}{s}" for s in (".png", ".pdf", ".csv")])

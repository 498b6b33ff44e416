"""A concealed study on disk, and its truth."""

from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import yaml

from bluekoi.files import write_text
from bluekoi.synthetic.encode import GOPRO_FRAME_RATE_HZ, write_video
from bluekoi.synthetic.footage import render_frames
from bluekoi.synthetic.motor_log import motor_angles, write_motor_log
from bluekoi.synthetic.study_rendering import study_yaml_content, write_study_files
from bluekoi.synthetic.synthetic_study_design import StudyDesign
from bluekoi.synthetic.trial import trial_rng
from validation.generators.concealed.effects import PHYSICS
from validation.generators.concealed.faults import with_wrong_statement
from validation.generators.concealed.recipe import (
    CLEAR,
    ChosenEffect,
    Recipe,
    effect_by_name,
    with_effect,
)
from validation.generators.concealed.strength import strength_for_path_error
from validation.generators.concealed.swimmer.inputs import HiddenLaws
from validation.generators.concealed.trials import (
    SimulatedTrial,
    design_while_filmed,
    observed_pixels,
    simulate_trial,
    study_design,
)
from validation.generators.concealed.truth import path_truth
from validation.tracking_noise import TrackingNoise, dlc_text, tracked_keypoints

__all__ = ["write_concealed_study"]

POINT_NOISE_M = 0.00085
"""Noise of one tracked point in the pool plane at factor 1: 0.32 px each way, 1.88 mm a pixel."""


def _laws_with_effects(
    recipe: Recipe, design: StudyDesign
) -> tuple[HiddenLaws, list[dict[str, Any]]]:
    """Laws with every chosen effect at its strength, and what is true of each effect."""
    laws, reported = recipe.laws, []
    if recipe.has_fin:
        reported.append(_fin_truth(recipe))
    if recipe.chosen:
        plain = [simulate_trial(recipe, design, recipe.laws, plan) for plan in design.plans]
        trials = [(one.command, float(one.trial.time_s[-1])) for one in plain]
    noise = POINT_NOISE_M * recipe.noise
    for chosen in recipe.chosen:
        strength, error = strength_for_path_error(
            recipe, recipe.laws, chosen, trials, noise_m=noise
        )
        laws = with_effect(laws, chosen, strength)
        reported.append(_effect_truth(chosen, laws, strength, error / noise))
    return laws, reported


def _effect_truth(
    chosen: ChosenEffect, laws: HiddenLaws, strength: float, ratio: float
) -> dict[str, Any]:
    effect, form = effect_by_name(chosen.name), chosen.form
    values = laws._asdict()
    same = {k: values[number] * factor for k, (number, factor) in (form.reported_as or {}).items()}
    return {
        "name": chosen.name if chosen.name in PHYSICS else "unexplained",
        "effect": chosen.name,
        "law": form.law,
        "channels": list(effect.channels),
        "variables": list(effect.variables),
        "strength": strength,
        "wanted_ratio": chosen.ratio,
        "ratio": ratio,
        "parameters": same,
    }


def _fin_truth(recipe: Recipe) -> dict[str, Any]:
    """What is true of the fin of a robot that swims straight; it counts as left out as well."""
    fin, laws = PHYSICS["tail_fin_lift"], recipe.laws
    point = laws.fin_spread_m == 0.0
    return {
        "name": "tail_fin_lift",
        "effect": "tail_fin_lift",
        "law": "one point" if point else "strips",
        "channels": list(fin.channels),
        "variables": list(fin.variables),
        "strength": laws.fin_m2,
        "parameters": {"S": laws.fin_m2, "a": laws.fin_arm_m} if point else {},
    }


def _fault_truth(recipe: Recipe) -> list[dict[str, Any]]:
    if recipe.fault is None:
        return []
    name, size = recipe.fault
    same = {"scale_error": "k", "clock_error": "k", "time_offset": "d"}
    parameters = {same[name]: size} if name in same else {}
    return [{"name": name, "effect": name, "law": "as it arises", "channels": [], "variables": [],
             "strength": size, "parameters": parameters}]  # fmt: skip


def _stated_frame_rate(recipe: Recipe) -> float:
    wrong = recipe.fault[1] if recipe.fault and recipe.fault[0] == "clock_error" else 0.0
    return float(GOPRO_FRAME_RATE_HZ) * (1 + wrong)


def _write_tables(recipe: Recipe, design: StudyDesign, folder: Path) -> None:
    rate = _stated_frame_rate(recipe)
    wrong = rate != float(GOPRO_FRAME_RATE_HZ)
    source = "videos/{}.mp4" if recipe.footage else "keypoints/{}.csv"
    fps = None if recipe.footage and not wrong else rate
    write_study_files(design, folder, source=source, fps=fps)
    fault, size = recipe.fault or ("", 0.0)
    contents = with_wrong_statement(study_yaml_content(design), fault, size)
    write_text(folder / "study.yaml", yaml.safe_dump(contents, sort_keys=False))


def _write_keypoints(
    recipe: Recipe, design: StudyDesign, one: SimulatedTrial, laws: HiddenLaws, path: Path
) -> None:
    usual, rng = TrackingNoise(), trial_rng(design, one.trial.plan.trial_id, "tracking")
    noise = replace(
        usual, white_px=usual.white_px * recipe.noise, slow_px=usual.slow_px * recipe.noise
    )
    pixels = observed_pixels(recipe, design, one, laws)
    seen, likelihood = tracked_keypoints(pixels, noise, rng, step_s=1 / float(GOPRO_FRAME_RATE_HZ))
    write_text(path, dlc_text(seen, likelihood))


def _write_footage(recipe: Recipe, design: StudyDesign, one: SimulatedTrial, path: Path) -> None:
    state = design_while_filmed(recipe, design, one.trial)
    path.parent.mkdir(parents=True, exist_ok=True)
    c = state.conditions
    write_video(path, render_frames(state, one.trial), size_px=c.size_px, mbit_s=c.mbit_s)


def write_concealed_study(recipe: Recipe, folder: Path) -> dict[str, Any]:
    """The truth of a recipe's study, which is written to `folder`."""
    design = study_design(recipe)
    laws, causes = _laws_with_effects(recipe, design)
    _write_tables(recipe, design, folder)
    trials = [simulate_trial(recipe, design, laws, plan) for plan in design.plans]
    for one in trials:
        name = one.trial.plan.trial_id
        if recipe.footage:
            _write_footage(recipe, design, one, folder / "videos" / f"{name}.mp4")
        else:
            _write_keypoints(recipe, design, one, laws, folder / "keypoints" / f"{name}.csv")
        rng = trial_rng(design, name, "motor")
        duration = float(one.trial.time_s[-1])
        write_motor_log(folder / "motor" / f"{name}.csv", motor_angles(one.motor, duration, rng))
    causes += _fault_truth(recipe)
    paths = {one.trial.plan.trial_id: path_truth(one) for one in trials}
    return _study_truth(recipe, laws, causes, paths)


def _visibility_level(recipe: Recipe, causes: list[dict[str, Any]]) -> str:
    """Clear or faint, by the error that the weakest effect leaves; as dealt for faults."""
    ratios = [c["ratio"] for c in causes if "ratio" in c]
    if not ratios:
        return recipe.level
    return "clear" if min(ratios) >= 0.5 * CLEAR else "faint"


def _study_truth(
    recipe: Recipe, laws: HiddenLaws, causes: list[dict[str, Any]], paths: dict[str, Any]
) -> dict[str, Any]:
    return {
        "kind": recipe.kind,
        "level": _visibility_level(recipe, causes),
        "has_fin": recipe.has_fin,
        "trials": recipe.trials,
        "footage": recipe.footage,
        "noise_m": POINT_NOISE_M * recipe.noise,
        "water_rms_m_s": recipe.water_rms_m_s,
        "robot": asdict(recipe.robot),
        "body": recipe.body._asdict(),
        "laws": laws._asdict(),
        "causes": causes,
        "paths": paths,
    }

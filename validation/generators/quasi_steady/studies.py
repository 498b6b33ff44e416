"""Composition of the studies: which causes, how strong, and the truth that goes with them."""

import json
import shutil
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from validation.generators.quasi_steady import effects as fx
from validation.generators.quasi_steady.detector import detectability, neutral_fin_area
from validation.generators.quasi_steady.trials import Lab, draw_lab, place_all_trials
from validation.generators.quasi_steady.writing import write_study

GENERATOR_NAME = "quasi_steady"
GROUPS_BY_SLOT = (
    ["null"] * 8 + ["clear"] * 8 + ["faint"] * 6 + ["pair"] * 6 + ["measurement"] * 6
    + ["unlisted"] * 6
)  # fmt: skip
TARGET_SIGMA_RANGES = {
    "clear": (20, 45),
    "faint": (8, 14),
    "pair": (14, 35),
    "measurement": (12, 40),
    "unlisted": (14, 40),
}
AIMED_SIGMA_RANGES = {
    "clear": (23, 41),
    "faint": (9, 13),
    "pair": (17, 31),
    "measurement": (15, 36),
    "unlisted": (17, 36),
}
VERDICTS = {"null": "none", "measurement": "measurement", "unlisted": "unexplained"}
SLOT_PERMUTATION = np.random.default_rng(20240517).permutation(40)


def study_slot(index: int) -> tuple[str, bool, bool]:
    """Group, fin and whether the study has only 9 trials, of an index."""
    place = int(SLOT_PERMUTATION[index % 40])
    return GROUPS_BY_SLOT[place], place % 2 == 0, place % 4 == (1 if place < 20 else 2)


def causes_from_deck(seed: int, index: int) -> list[str]:
    """Causes to try in this study, first choice first; every 40 studies go through all causes.

    The list that a group draws from is dealt in an order that depends on seed and block alone.
    """
    block, place = index // 40, int(SLOT_PERMUTATION[index % 40])
    group = GROUPS_BY_SLOT[place]
    rng = np.random.default_rng([seed, block, 7])
    physics, errors = list(rng.permutation(fx.PHYSICS)), list(rng.permutation(fx.MEASUREMENTS))
    rest = np.random.default_rng([seed, block, place, 8])
    if group == "unlisted":
        return ["unlisted"]
    if group == "measurement":
        first = (place - 28 + 6 * block) % len(errors)
        return errors[first:] + errors[:first]
    turn = {"clear": place - 8, "faint": place - 8, "pair": 14 + 2 * (place - 22)}[group]
    chosen = [physics[(turn + i) % len(physics)] for i in range(2 if group == "pair" else 1)]
    return chosen + [c for c in rest.permutation(fx.PHYSICS) if c not in chosen]


def draw_stable_fin(rng: np.random.Generator, lab: Lab) -> fx.Effect:
    """A tail fin from marginally to strongly stable: 1.05 to 2.5 times the neutral area."""
    forms = fx.CAUSES["tail_fin_lift"]
    effect = fx.draw_effect(forms[rng.integers(len(forms))], rng)
    return replace(effect, k=neutral_fin_area(lab, effect) * float(np.exp(rng.uniform(0.05, 0.92))))


def solve_strengths(
    rng: np.random.Generator, lab: Lab, hidden: list[fx.Effect], group: str, fin: list[fx.Effect]
) -> tuple[Lab, list[fx.Effect], np.ndarray] | None:
    """Lab, effects (fin first), sigmas, with hidden strengths solved; None if out of reach."""
    aims = rng.uniform(*AIMED_SIGMA_RANGES[group], len(hidden)) if hidden else np.zeros(0)
    low, high = TARGET_SIGMA_RANGES.get(group, (0, np.inf))
    lab = place_all_trials(rng, lab, [*fin, *hidden])
    for _ in range(7):
        sigmas = detectability(lab, [*fin, *hidden])
        own = sigmas[len(fin) :]
        if np.all((own >= low) & (own <= high)):
            return (lab, [*fin, *hidden], sigmas) if not fin or sigmas[0] >= 15 else None
        factors = np.clip(aims / np.maximum(own, 1e-3), 0.1, 5.0)
        new = [fx.with_strength(e, abs(e.k) * f) for e, f in zip(hidden, factors, strict=True)]
        if all(a.k == b.k for a, b in zip(new, hidden, strict=True)):
            return None
        hidden = new
        lab = place_all_trials(rng, lab, [*fin, *hidden])
    return None


def candidate_cause_sets(seed: int, index: int, group: str) -> list[list[str]]:
    """Sets of causes to try in turn."""
    if group == "null":
        return [[]] * 6
    order = causes_from_deck(seed, index)
    if group != "pair":
        return [[c] for c in order for _ in range(4 if len(order) > 1 else 8)]
    wanted, spare = order[:2], order[2:]
    return [wanted, wanted, *([wanted[i % 2], c] for i, c in enumerate(spare))]


def pick_form(seed: int, index: int, cause: str, attempt: int) -> fx.Form:
    """Form of a cause; unlisted forms are dealt in turn."""
    forms = fx.CAUSES[cause]
    if cause == "unlisted":
        turn = int(SLOT_PERMUTATION[index % 40]) - 34 + 6 * (index // 40) + 2 * seed
        return forms[(turn + attempt) % len(forms)]
    return forms[np.random.default_rng([seed, index, attempt, 9]).integers(len(forms))]


def build_study(seed: int, index: int) -> tuple[Lab, list[fx.Effect], np.ndarray, str]:
    """Lab, effects, sigmas and lens of a study."""
    group, with_fin, few = study_slot(index)
    for attempt, causes in enumerate(candidate_cause_sets(seed, index, group)):
        rng = np.random.default_rng([seed, index, attempt])
        lens = str(rng.choice(["pinhole", "fisheye", "plain"], p=[0.62, 0.3, 0.08]))
        if group == "measurement" and lens == "plain":
            lens = "pinhole"
        two = "thrust_area" in causes or rng.uniform() < 0.8
        count = 9 if few else 24
        lab = draw_lab(rng, count, two_heads=two, long="wake_reentry" in causes, lens=lens)
        fin = [draw_stable_fin(rng, lab)] if with_fin else []
        hidden = [fx.draw_effect(pick_form(seed, index, c, attempt), rng) for c in causes]
        if any(e.form.name == "index" for e in hidden):  # near the surface no one could see it
            lab = replace(lab, depth=round(float(rng.uniform(0.2, 0.26)), 3))
        done = solve_strengths(rng, lab, hidden, group, fin)
        if done is not None:
            return *done, lens
    raise RuntimeError(f"no effect of study {index} reaches its strength")


def truth_json(
    seed: int, index: int, lab: Lab, effects: Sequence[fx.Effect], sigmas: np.ndarray
) -> dict:
    """The truth file's content."""
    group, with_fin, _ = study_slot(index)
    causes, unlisted = [], None
    for e, sigma in zip(effects, sigmas, strict=True):
        entry = {
            "form": e.form.name,
            "sigma": round(float(sigma), 2),
            "parameters": fx.parameters_json(e),
        }
        if e.form.cause == "unlisted":
            channels, variable = UNLISTED[e.form.variant]
            unlisted = {"channels": channels, "variable": variable, **entry}
        else:
            causes.append({"name": e.form.cause, "kind": e.form.kind, **entry})
    verdict = VERDICTS.get(group, "physics")
    if group == "null" and with_fin:
        verdict = "physics"
    robot = {k: float(v) for k, v in lab.robot._asdict().items()}
    conditions = [
        {"trial_id": t.name, "power_pct": t.power,
         "head_angle_deg": float(np.degrees(t.head_angle)),
         "head_length_m": t.head, "seconds": t.seconds, "start": list(t.start),
         "servo_error_deg": float(np.degrees(t.servo_error)), "flap_error": t.flap_error}
        for t in lab.trials
    ]  # fmt: skip
    return {
        "study": f"{GENERATOR_NAME}-{seed}-{index:03d}", "generator": GENERATOR_NAME, "seed": seed,
        "index": index, "group": group,
        "fin": with_fin, "trials": len(lab.trials), "verdict": verdict, "causes": causes,
        "unlisted": unlisted, "noise": asdict(lab.noise), "robot": robot,
        "conditions": {"fps": lab.fps, "camera": lab.camera.model, "trials": conditions},
    }  # fmt: skip


UNLISTED = [
    (["yaw"], "heading_rad"), (["yaw"], "heading_rad"), (["yaw"], "x_m"), (["yaw"], "time_s"),
    (["surge"], "time_s"), (["surge"], "speed_m_s"), (["surge", "sway"], "position_m"),
    (["sway"], "heading_rad"), (["yaw"], "speed_m_s"),
]  # fmt: skip


def generate(seed: int, index: int, directory: Path) -> dict:
    """Write study `index` of `seed` below `directory` and return its truth."""
    name = f"{GENERATOR_NAME}-{seed}-{index:03d}"
    directory = Path(directory)
    truth_path = directory / "truth" / f"{name}.json"
    if truth_path.exists():
        return json.loads(truth_path.read_text())
    lab, effects, sigmas, lens = build_study(seed, index)
    rng = np.random.default_rng([seed, index, 10**6])
    causes = {e.form.cause for e in effects}
    layout = {
        "motor": bool(rng.uniform() < 0.8) or "time_offset" in causes,
        "fill": str(rng.choice(["hold", "zero", "empty"])),
        "multi": bool(rng.uniform() < 0.15),
        "renamed": bool(rng.uniform() < 0.2),
        "homography": lens == "plain" and bool(rng.uniform() < 0.6),
    }
    draft = directory / "studies" / f".{name}.draft"
    shutil.rmtree(draft, ignore_errors=True)
    write_study(rng, draft, lab, effects, layout)
    final = directory / "studies" / name
    shutil.rmtree(final, ignore_errors=True)
    draft.rename(final)
    truth = truth_json(seed, index, lab, effects, sigmas)
    truth["conditions"]["layout"] = layout
    truth_path.parent.mkdir(parents=True, exist_ok=True)
    part = truth_path.with_suffix(".part")
    part.write_text(json.dumps(truth, indent=1))
    part.rename(truth_path)
    return truth

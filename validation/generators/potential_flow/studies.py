"""One study: robot, trials, hidden content with its strength, files and truth."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from . import writing
from .catalogue import MEASUREMENT, UNLISTED_NAME
from .craft import COEFFICIENTS, draw_robot
from .drive import draw_frequency_drift
from .eddies import draw_water_motion
from .filming import draw_film, exposure_times, keypoint_pixels, stated_setup
from .fisher import StudyRun, detectability_sigmas
from .form import OPTICAL_STAGES, Form, HiddenForm, draw_hidden
from .impulse import STEP_S, StudyWorld, set_strengths, simulate_motion
from .lanes import draw_trials
from .placing import MAX_DURATION_S, MIN_DURATION_S, time_inside_pool, with_start_poses
from .plan import StudyKind, draw_forms, forms_of, study_kind
from .stability import draw_fin, straight_growth_rate
from .tracker import draw_potentiometer, tracked_keypoints

MAX_ATTEMPTS = 60
FAINT, CLEAR = 10.0, 60.0
"""Range of the sigma of hidden strengths."""
SIMULATED_S = MAX_DURATION_S + 1.0
"""Motion is kept for so long, s, so that logs and late videos have an end."""


class UnsuitableDrawError(Exception):
    """These draws give no study: too faint within the range of strengths, or out of the pool."""


@dataclass(frozen=True)
class StudyContent:
    """A study ready to be written."""

    run: StudyRun
    sigma: np.ndarray
    """Of each law of the world, then of the fault."""
    fin: bool
    """Whether the first law is the robot's fin."""


def generate(
    seed: int, index: int, folder: Path, *, forms: Sequence[Form] | None = None
) -> dict[str, Any]:
    """Write study `index` of a series below `folder` and return its truth.

    folder/studies/NAME holds the study, folder/truth/NAME.json the truth. forms: hide these.
    """
    what = study_kind(seed, index)
    name = f"potential_flow-{seed}-{index:03d}"
    for attempt in range(MAX_ATTEMPTS):
        rng = np.random.default_rng([seed, index, attempt, 20117])
        chosen = draw_forms(rng, seed, what) if forms is None else list(forms)
        try:
            content = compose_study(rng, what, chosen)
        except UnsuitableDrawError:
            continue
        break
    else:
        raise UnsuitableDrawError(f"{name}: nothing fits in {MAX_ATTEMPTS} attempts")
    write_files(rng, content, folder / "studies" / name)
    truth = {"study": name, "generator": "potential_flow", "seed": seed, "index": index}
    truth |= truth_json(content, "chosen" if forms is not None else what.name)
    (folder / "truth").mkdir(parents=True, exist_ok=True)
    text = json.dumps(truth, indent=1) + "\n"
    (folder / "truth" / f"{name}.json").write_text(text, encoding="utf-8")
    return truth


def compose_study(rng: np.random.Generator, what: StudyKind, forms: Sequence[Form]) -> StudyContent:
    """Robot, trials and hidden content of one study.

    Raises: Unfit.
    """
    hidden = [draw_hidden(rng, form) for form in forms]
    fin = what.fin and all(form.cause != "tail_fin_lift" for form in forms)
    run, wanted = _setup(rng, what, fin, hidden)
    loose = set(range(len(run.world.laws)))
    targets = np.exp(rng.uniform(np.log(14), np.log(48), len(hidden)))
    run = _solve_strengths(run, rng, wanted, targets, loose - ({0} if fin else set()))
    return StudyContent(*run, fin)


def _setup(
    rng: np.random.Generator, what: StudyKind, fin: bool, hidden: list[HiddenForm]
) -> tuple[StudyRun, np.ndarray]:
    craft, few = draw_robot(rng), what.few
    if any(h.form.cause == "uncorrected_refraction" for h in hidden):
        craft = replace(craft, depth=round(rng.uniform(0.09, 0.16), 3))
    pool = tuple(np.round((rng.uniform(3.4, 5.0), rng.uniform(2.2, 3.0), rng.uniform(0.3, 0.6)), 2))
    laws = []
    if fin:
        shapes = forms_of("tail_fin_lift")
        laws = [draw_fin(rng, craft, shapes[int(rng.integers(len(shapes)))], 5.8)]
        if laws[0] is None:
            raise UnsuitableDrawError("no fin of this form makes the robot stable")
    laws += [h for h in hidden if h.form.stage not in OPTICAL_STAGES]
    fault = next((h for h in hidden if h.form.stage in OPTICAL_STAGES), None)
    water = draw_water_motion(rng)
    lanes = draw_trials(rng, craft, water, few)
    steps = STEP_S * (np.arange(int(SIMULATED_S / STEP_S) + 40) + 0.5)
    craft = replace(craft, background=float(rng.uniform(0.001, 0.006)))
    world = StudyWorld(
        craft, water, pool, tuple(laws), draw_frequency_drift(rng, steps, len(lanes))
    )
    motor = any(h.form.stage == "motor" for h in hidden)
    logged = bool(rng.random() > (0.6 if motor else 0.12))
    fps = float(rng.choice([30.0, 29.97003, 60.0, 59.94006]))
    lanes = set_strengths(lanes, [h.strength for h in laws])
    film = draw_film(rng, pool, craft.depth)
    run = StudyRun(world, lanes, film, fps, np.zeros(len(lanes), dtype=int), logged, fault)
    return run, rng.uniform(5.0, MAX_DURATION_S, len(lanes))


def _cut_to_pool(run: StudyRun, wanted: np.ndarray) -> StudyRun:
    """The run with the frames of each trial that show the robot within the pool.

    Raises: Unfit where a trial is shorter than SHORTEST.
    """
    seconds = np.minimum(
        time_inside_pool(simulate_motion(run.world, run.lanes, MAX_DURATION_S), run.world.pool),
        wanted,
    )
    if seconds.min() < MIN_DURATION_S:
        raise UnsuitableDrawError("a trial leaves the pool")
    nominal = np.arange(int(MAX_DURATION_S * run.fps)) / run.fps
    frames = [
        int(np.count_nonzero(exposure_times(run.fault, run.lanes, k, nominal, len(wanted)) <= s))
        for k, s in enumerate(seconds)
    ]
    return replace(run, frames=np.array(frames))


def _place_again(run: StudyRun, rng: np.random.Generator, wanted: np.ndarray) -> StudyRun:
    """The framed run; trials are placed again, up to four times, where one is too short."""
    for _ in range(4):
        try:
            return _cut_to_pool(
                replace(run, lanes=with_start_poses(rng, run.world, run.lanes, wanted)), wanted
            )
        except UnsuitableDrawError:
            continue
    raise UnsuitableDrawError("trials leave the pool")


def _run_strengths(run: StudyRun) -> np.ndarray:
    own = [h.strength for h in run.world.laws]
    return np.array(own + ([run.fault.strength] if run.fault else []))


def _with_strengths(run: StudyRun, strengths: np.ndarray) -> StudyRun:
    laws = tuple(replace(h, strength=float(k))
                 for h, k in zip(run.world.laws, strengths, strict=False))  # fmt: skip
    fault = replace(run.fault, strength=float(strengths[-1])) if run.fault else None
    lanes = set_strengths(run.lanes, [h.strength for h in laws])
    return replace(run, world=replace(run.world, laws=laws), fault=fault, lanes=lanes)


def _solve_strengths(
    run: StudyRun, rng: np.random.Generator, wanted, targets: np.ndarray, loose: set[int]
) -> tuple[StudyRun, np.ndarray]:
    """The run with strengths at which sigma is near `targets`, and the sigmas."""
    rows = sorted(loose) + ([len(run.world.laws)] if run.fault else [])
    forms = [h.form for h in run.world.laws] + ([run.fault.form] if run.fault else [])
    low, high = (np.array([getattr(f, end) for f in forms]) for end in ("low", "high"))
    below, above = np.zeros(len(forms)), np.full(len(forms), np.inf)
    for step in range(9):
        try:
            run = _cut_to_pool(run, wanted) if step else _place_again(run, rng, wanted)
        except UnsuitableDrawError:
            run = _place_again(run, rng, wanted)
        found = detectability_sigmas(run)
        if all(FAINT * 1.05 < found[i] < CLEAR * 0.95 for i in rows):
            return run, found
        k = _run_strengths(run)
        faint = np.zeros(len(forms), dtype=bool)
        change = np.ones(len(forms))
        change[rows] = np.clip(targets / np.maximum(found[rows], 1e-3), 0.05, 6.0)
        faint[rows] = change[rows] > 1
        below[faint], above[~faint] = k[faint], k[~faint]
        new = np.clip(k * change, low, high)
        between = (below > 0) & np.isfinite(above) & ((new <= below) | (new >= above))
        new[between] = np.sqrt(below * above)[between]
        fixed = np.setdiff1d(np.arange(len(forms)), rows)
        new[fixed] = k[fixed]
        if any(new[i] == k[i] and not FAINT < found[i] < CLEAR for i in rows):
            raise UnsuitableDrawError("too faint or too clear at any strength of the range")
        run = _with_strengths(run, new)
    raise UnsuitableDrawError("strengths do not settle")


def write_files(rng: np.random.Generator, content: StudyContent, folder: Path) -> None:
    """All files of the study."""
    run = content.run
    for part in ("keypoints", *(["motor"] if run.logged else [])):
        (folder / part).mkdir(parents=True, exist_ok=True)
    motion = simulate_motion(run.world, run.lanes, SIMULATED_S)
    said = stated_setup(run.world, run.film, run.fault)
    clicked = said.corners + writing.CORNER_STD_PX * rng.normal(size=(4, 2))
    writing.write_study_yaml(folder / "study.yaml", run.world.craft, said, clicked)
    hertz = writing.reported_flap_hz(rng, run, motion)
    writing.write_trials(folder / "trials.csv", run.lanes, run.fps, hertz, run.logged)
    sensor = draw_potentiometer(rng)
    for k, frames in enumerate(run.frames):
        name = f"P{k + 1:02d}.csv"
        t = np.arange(frames) / run.fps
        px = keypoint_pixels(run.world, run.film, motion, run.lanes, trial=k, t=t, fault=run.fault)
        found = tracked_keypoints(rng, run.film.tracker, px, run.fps)
        outside = np.any((px < 0) | (px > np.array(run.film.camera.size) - 1), axis=-1)
        found[outside, :2], found[outside, 2] = np.nan, 0.01
        writing.write_keypoints(folder / "keypoints" / name, found)
        if run.logged:
            true = exposure_times(run.fault, run.lanes, k, t, len(run.frames))
            phase = writing.shaft_phase(rng, motion, k, float(true[-1]) + 0.3)
            writing.write_motor_log(rng, folder / "motor" / name, sensor, phase)


def truth_json(content: StudyContent, group: str) -> dict[str, Any]:
    """The truth: what is hidden, how strong, and what an ideal detector sees of it."""
    run, craft = content.run, content.run.world.craft
    laws = [*run.world.laws, *([run.fault] if run.fault else [])]
    pairs = list(zip(laws, content.sigma, strict=True))
    others = [_cause_json(h, s) for h, s in pairs if h.form.cause == UNLISTED_NAME]
    fins = run.world.laws[:1] if content.fin else ()
    return {
        "group": group, "fin": content.fin, "trials": len(run.lanes),
        "causes": [_cause_json(h, s) for h, s in pairs if h.form.cause != UNLISTED_NAME],
        "unlisted": others[0] if others else None,
        "coefficients": {name: craft.coefficients[name] for name in COEFFICIENTS},
        "background_added_mass_share": craft.background,
        "stability_per_s": float(straight_growth_rate(craft, list(fins), 5.8)[0]),
        "motor_logs": run.logged,
    }  # fmt: skip


def _cause_json(law: HiddenForm, sigma: float) -> dict[str, Any]:
    form = law.form
    entry = {"form": form.name, "strength": law.strength, "unit": form.unit,
             "parameters": law.parameters, "sigma": round(float(sigma), 1)}  # fmt: skip
    if form.cause == UNLISTED_NAME:
        return entry | {"channel": form.channels[0], "variable": form.variable}
    causes = {f.cause for f in MEASUREMENT}
    kind_of = "measurement" if form.cause in causes else "physics"
    return {"name": form.cause, "kind": kind_of, "channels": list(form.channels)} | entry

"""Making a study: robot, plan and hidden causes of a wanted sigma; its files and its truth."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .camera import Camera, corner_pixels
from .catalogue import GROUPS, bounds, draw_cause, draw_names
from .design import Impossible, Study, draw_fin, draw_study, first_states
from .dynamics import stability
from .files import truth_of, write_study, write_truth
from .form import DT, Array, Cause, Marks, act, give_rows, strengths_of
from .placing import place
from .strength import Outcome, horizon, reach
from .weather import Calm, Weather

GENERATOR = "glass_tank"
MAX_ATTEMPTS = 60
TRIES_OF_CAUSES = 3
"""Robots and forms that are tried before other causes are drawn."""


def _place_all(rng: np.random.Generator, study: Study) -> Array:
    """First states from which the paths without hidden causes stay in the pool.

    Also finds the typical angle of attack in turns.
    """
    robot, trials = study.robot, study.trials
    first = first_states(rng, study)
    states = study.simulated(first, horizon(study), Calm(robot.trials)).states
    middle = states[len(states) // 2]
    head = middle[2] - trials.phi
    alpha = np.abs(np.angle(np.exp(1j * head) / (middle[3] + 1j * middle[4])))
    robot.turning_alpha = float(np.clip(np.median(alpha[trials.phi != 0]), 0.06, 0.8))
    every = range(robot.trials)
    place(rng, robot, study.plan, states, which=every, first=first, to_walls=study.to_walls)
    return first


def _draw_hidden(rng: np.random.Generator, study: Study, name: str) -> Cause:
    """A hidden cause with its first strength; only a deep swimmer shows a wrong index."""
    robot = study.robot
    cause = draw_cause(rng, robot, name)
    if cause.form == "wrong_index":
        robot.keypoint_depth = round(float(rng.uniform(0.5, 0.75)) * robot.pool_depth, 3)
    low, high = bounds(robot, cause)
    size = np.exp(rng.uniform(0.2, 0.55) * np.log(high / low)) * low
    sign = rng.choice([-1, 1]) if cause.family.signed_in(cause.form) else 1
    cause.strength = float(size * sign)
    return cause


def _true_lens(study: Study) -> Camera:
    """The camera that takes the pictures; it differs from the stated one if that is wrong."""
    marks = Marks(study.size_stated, study.camera)
    act("lens", marks, study.causes, strengths_of(study.causes))
    return marks.camera


def make_study(
    rng: np.random.Generator, names: list[str], *, fin: bool, trials: int, logged: bool
) -> tuple[Study, Outcome]:
    """A study that hides causes of these names.

    Raises: Impossible where the draw gives none.
    """
    study = draw_study(rng, names, trials, logged=logged)
    if fin:
        study.causes = [draw_fin(rng, study.robot, study.coefficients)]
    first = _place_all(rng, study)
    hidden = [_draw_hidden(rng, study, name) for name in names]
    study.causes = study.causes + hidden
    first = np.concatenate([first[:6], np.zeros((give_rows(study.causes), trials))])
    steps = int(np.ceil(1.4 * study.plan.wanted.max() / DT)) + 150
    study.weather = Weather(rng, study.robot, study.noise, steps)
    outcome = reach(rng, study, hidden, first)
    marks = corner_pixels(_true_lens(study), study.robot.pool, study.mark_height)
    study.marks = marks + study.noise["corner_px"] * study.corner_error
    return study, outcome


def _draw_group(rng: np.random.Generator) -> str:
    """Group of a study."""
    luck = rng.random()
    tops = np.cumsum(list(GROUPS.values()))
    return next(g for g, top in zip(GROUPS, tops, strict=True) if luck < top + 1e-12)


def generate(seed: int, index: int, folder: Path) -> dict[str, Any]:
    """Write study `index` of the series `seed` into FOLDER/studies and its truth into FOLDER/truth.

    If a draw cannot be made detectable within the plausible range, two other robots and forms are
    tried, then other causes. The truth is returned.
    Raises: RuntimeError where no draw is detectable.
    """
    rng = np.random.default_rng([int(seed), int(index), 0x67A55])
    group = _draw_group(rng)
    fin = bool(rng.random() < 0.5)
    trials = 9 if rng.random() < 1 / 3 else int(rng.integers(10, 25))
    logged = bool(rng.random() < 1 / 3)
    for attempt in range(MAX_ATTEMPTS):
        if attempt % TRIES_OF_CAUSES == 0:
            names = draw_names(rng, group)
        try:
            study, outcome = make_study(rng, names, fin=fin, trials=trials, logged=logged)
        except Impossible:
            continue
        name = f"{GENERATOR}-{seed}-{index:03d}"
        own_folder = Path(folder) / "studies" / name
        write_study(rng, study, outcome.motion, outcome.durations, own_folder)
        growth = stability(study.robot, study.parameters, study.causes)
        truth = {"study": name, "generator": GENERATOR, "seed": seed, "index": index,
                 "group": group, "fin": fin,
                 **truth_of(study, outcome.sigma, growth)}  # fmt: skip
        write_truth(Path(folder) / "truth" / f"{name}.json", truth)
        return truth
    raise RuntimeError(f"study {index} of series {seed}: no draw could be made detectable")

"""A study before its files are written: robot, plan, camera, noise, and the causes hidden in it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .camera import Camera, draw_camera
from .catalogue import FAMILIES, FIN, bounds
from .dynamics import Disturbances, Motion, Setting, simulate, stability
from .form import Array, Cause, Trials, give_rows, strengths_of
from .robots import FRAME_RATES, Plan, Robot, draw_plan, draw_robot
from .weather import Calm, Weather, draw_noise

WATER_INDEX = 1.333


class Impossible(Exception):
    """A draw that cannot become a study; another one is made."""


@dataclass
class Study:
    """All that is drawn for a study.

    coefficients: six, in the paper's order. mark_height, shallow: height of the marks above the
    water and a second depth of the labels, m. corner_error: of the marks, in standard deviations.
    label_factor: relative size of the errors of the labels. first_phase: of the flapping,
    revolutions. true_flap: Hz. dead_zone: what the motor log has where the sensor is blind.
    to_walls: start near the walls. size_stated (m), index_stated: as in study.yaml. marks: px.
    """

    robot: Robot
    coefficients: list[float]
    plan: Plan
    noise: dict[str, Any]
    fps: float
    mark_height: float
    camera: Camera
    label_factor: Array
    first_phase: Array
    true_flap: Array
    logged: bool
    renamed: bool
    empty_cells: bool
    dead_zone: str
    dead_zone_deg: float
    to_walls: bool
    corner_error: Array
    shallow: float
    size_stated: Array
    index_stated: float = WATER_INDEX
    causes: list[Cause] = field(default_factory=list)
    weather: Weather | Calm = field(default_factory=lambda: Calm(0))
    marks: Array = field(default_factory=lambda: np.zeros((4, 2)))

    @property
    def trials(self) -> Trials:
        """Constants of the trials."""
        return self.plan.trials

    @property
    def parameters(self) -> list[float]:
        """The six coefficients, then the strengths of the causes."""
        return self.coefficients + strengths_of(self.causes)

    def simulated(self, first: Array, steps: int, weather: Disturbances) -> Motion:
        """Motion of all trials with the causes of the study."""
        setting = Setting(self.robot, self.trials, self.causes)
        return simulate(first, steps, setting, self.parameters, weather)


def draw_study(rng: np.random.Generator, names: list[str], trials: int, *, logged: bool) -> Study:
    """Robot, pool, camera, plan and noise of a study that is to hide these causes."""
    fps = float(rng.choice(FRAME_RATES))
    deep = bool({"uncorrected_refraction", "sinking"} & set(names))
    robot, coefficients = draw_robot(rng, trials, deep=deep)
    heads_vary = "thrust_area" in names or rng.random() < 0.6
    plan = draw_plan(rng, robot, heads_vary=heads_vary)
    noise = draw_noise(rng, robot)
    mark_height = round(float(rng.choice([0.0, rng.uniform(0.02, 0.15)])), 3)
    fisheye = False if "lens_error" in names else None
    flap = plan.trials.flap
    return Study(
        robot, coefficients, plan, noise, fps, mark_height,
        camera=draw_camera(rng, robot.pool, mark_height, fisheye=fisheye),
        # the tail tip is the hardest to find
        label_factor=rng.uniform([0.8, 0.8, 0.8, 0.9, 1.3], [1.2, 1.2, 1.2, 1.4, 2.2]),
        first_phase=rng.random(trials),
        true_flap=flap.copy() if logged else flap * (1 + 0.003 * rng.standard_normal(trials)),
        logged=logged,
        renamed=bool(rng.random() < 0.25),
        empty_cells=bool(rng.random() < 0.4),
        dead_zone=str(rng.choice(["hold", "zero", "empty"])),
        dead_zone_deg=round(rng.uniform(8, 25), 1),
        to_walls="wall_effect" in names,
        corner_error=rng.standard_normal((4, 2)),
        shallow=round(float(rng.uniform(0.02, 0.1) * robot.pool_depth), 3),
        size_stated=np.array(robot.pool),
    )  # fmt: skip


def draw_fin(rng: np.random.Generator, robot: Robot, coefficients: list[float]) -> Cause:
    """A tail fin whose strength makes straight swimming marginally to strongly stable."""
    family = FAMILIES[FIN]
    form = str(rng.choice(family.forms))
    fin = Cause(family, form, family.draw(rng, robot, form))
    target = -np.exp(rng.uniform(np.log(0.05), np.log(1.6))) * robot.top_speed / robot.body_length
    strengths = np.geomspace(*bounds(robot, fin), 70)
    growth = np.array([stability(robot, [*coefficients, k], [fin]) for k in strengths])
    below = np.flatnonzero(growth <= target)
    fin.strength = float(strengths[below[0] if len(below) else int(np.argmin(growth))])
    if growth.min() > 0:
        raise Impossible("no fin stabilises this robot")
    return fin


def first_states(rng: np.random.Generator, study: Study) -> Array:
    """Nearly at rest in the middle of the pool, any heading, (6 + memory, trials)."""
    robot, n = study.robot, study.robot.trials
    first = np.zeros((6 + give_rows(study.causes), n))
    study.trials.heading = rng.uniform(-np.pi, np.pi, n)
    first[0], first[1], first[2] = robot.pool[0] / 2, robot.pool[1] / 2, study.trials.heading
    first[3:5] = rng.normal(0, 0.004 * robot.body_length, (2, n))
    first[5] = rng.normal(0, 0.008, n)
    return first

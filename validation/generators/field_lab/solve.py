"""Strengths of the hidden effects from the sigma that the group asks for."""

import numpy as np

from . import camera as cam
from . import detector, plan
from . import effects as eff
from . import world as wd

FIN_CAUSE = "tail_fin_lift"


def with_new_start_poses(
    rng: np.random.Generator, world: wd.StudyWorld, least_s: float
) -> wd.StudyWorld:
    """``world`` with new start poses for trials that would last less than ``least_s`` seconds."""
    out = []
    for trial in world.trials:
        short = len(wd.trial_path(world, trial)) < 1000 * min(least_s, trial.duration_s)
        out.append(plan.with_start_pose(rng, world, trial) if short else trial)
    return wd.replace(world, trials=tuple(out))


def with_scaled_strength(world: wd.StudyWorld, name: str, factor: float) -> wd.StudyWorld:
    """``world`` with one strength times ``factor``, within its bounds."""
    e = world.by_name()[name]
    low, high = e.form.strength[2:]
    size = float(np.clip(abs(e.strength) * factor, low, high))
    return wd.with_strength(world, name, float(np.sign(e.strength)) * size)


def solve_strengths(
    rng: np.random.Generator, world: wd.StudyWorld, group: str
) -> tuple[wd.StudyWorld, dict[str, float]] | None:
    """World whose effects reach the sigmas of ``group``; None where the bounds forbid it.

    Secant steps in logarithms; a fin below 15 sigma is enlarged.
    """
    low, high = plan.TARGET_SIGMAS.get(group, (0, 0))
    names = [e.name for e in world.effects if e.name != FIN_CAUSE]
    want = {
        n: float(rng.uniform(low + 0.1 * (high - low), high - 0.2 * (high - low))) for n in names
    }
    slope, last = dict.fromkeys(names, 1.0), {}
    for _ in range(10):
        world = with_new_start_poses(rng, world, 2.8)
        sigma = detector.detectability_sigmas(world)
        fine = all(low <= sigma[n] <= high for n in names)
        weak_fin = FIN_CAUSE in sigma and sigma[FIN_CAUSE] < 15
        if fine and not weak_fin:
            return world, sigma
        if weak_fin:
            world = with_scaled_strength(world, FIN_CAUSE, 1.35)
        for n in names:
            now = np.log(abs(world.by_name()[n].strength)), np.log(max(sigma[n], 1e-3))
            if n in last and abs(now[0] - last[n][0]) > 1e-3:
                slope[n] = float(np.clip((now[1] - last[n][1]) / (now[0] - last[n][0]), 0.6, 4.0))
            last[n] = now
            factor = np.exp(np.clip((np.log(want[n]) - now[1]) / slope[n], -2.3, 2.3))
            world = with_scaled_strength(world, n, float(factor))
    return None


def concealed_study(
    rng: np.random.Generator, s: plan.StudySlot, names: tuple[str, ...]
) -> tuple[wd.StudyWorld, dict, dict[str, float]]:
    """World, file layout and sigmas; the next cause is tried where one cannot be seen."""
    need = {"null": 0, "pair": 2}.get(s.group, 1)
    for attempt in range(12):
        picked = names[attempt : attempt + need]
        world, layout = plan.draw_study(rng, s, picked)
        effects = [plan.draw_form(rng, n) for n in picked]
        effects = [wd.replace(e, strength=first_strength(e)) for e in effects]
        if s.fin:
            fin = plan.draw_form(rng, FIN_CAUSE)
            world = wd.replace(world, effects=(plan.with_stable_fin(rng, world, fin),))
        world = wd.replace(
            world, trials=tuple(plan.with_start_pose(rng, world, t) for t in world.trials)
        )
        world = wd.replace(world, effects=(*world.effects, *effects))
        solved = solve_strengths(rng, world, s.group)
        if (
            solved is not None
            and trials_are_long_enough(solved[0])
            and corners_fit_stated_lens(solved[0])
        ):
            return solved[0], layout, solved[1]
    raise RuntimeError("no cause reaches the sigma of its group")


def first_strength(e: eff.Effect) -> float:
    """First strength: a third of the way between the bounds, in logarithms."""
    low, high = e.form.strength[2:]
    return float(np.sign(e.strength) * low * (high / low) ** 0.35)


def trials_are_long_enough(world: wd.StudyWorld) -> bool:
    """Whether all trials last 2.4 s or more and nothing swims above 0.9 m/s."""
    for trial in world.trials:
        s = wd.trial_path(world, trial)
        if len(s) < 2400 or np.hypot(s[:, 3], s[:, 4]).max() > 0.9:
            return False
    return True


def corners_fit_stated_lens(world: wd.StudyWorld) -> bool:
    """Whether the stated pool corners fit the stated lens to 10 px rms; worse would be noticed."""
    c, _, _, (length, width, px) = wd.stated_optics(world, wd.corner_pixels(world))
    miss = cam.project_air(c, cam.pool_corners(length, width, world.corner_height)) - px
    return float(np.sqrt((miss**2).sum(1).mean())) < 10

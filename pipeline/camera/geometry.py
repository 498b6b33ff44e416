"""What geometry error is left: rigid keypoint distances mapped over the pool name it.

Needs no ground truth: the head's and the core's lengths are known and must come out the same
everywhere. Which error bends them is told by the pattern over the pool.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float, Positions
from ..faults import Fault
from ..study import Robot
from .distance_map import DistanceMap, distance_map
from .distances import (
    Distances,
    Geometry,
    camera_patterns,
    keypoint_patterns,
    rigid_distances,
    without_error,
)
from .pool import PoolCamera
from .suspects import SUSPECTS, SYSTEMATIC, Estimate, Suspect, estimate

FALSE_ALARM = 0.001
RIVAL_MARGIN = 6.0
FOLLOWED = 4
"""Steps by which a large error of the lens is followed; the gain is that of the one before last."""


@dataclass(frozen=True)
class GeometryCheck:
    """What the rigid distances say: outcome `nothing`, or the name of the error that explains them.

    best: the estimate behind it; rivals: names that explain them as well; estimates: all, best
    first; mean_excess, mean_excess_std: overall relative error of length, trials as clusters.
    """

    outcome: str
    sentence: str
    best: Estimate | None
    rivals: tuple[str, ...]
    estimates: tuple[Estimate, ...]
    mean_excess: float
    mean_excess_std: float
    map: DistanceMap


def check_geometry(
    camera: PoolCamera,
    trials: Sequence[Positions],
    *,
    depth_m: float,
    head_lengths_m: Sequence[float],
    robot: Robot,
) -> GeometryCheck:
    """Outcome of the rigid distances of one campaign, mapped with `camera` at `depth_m`.

    Each suspect's pattern d(distance)/d(parameter) is fitted alone by weighted least squares with
    a prior of plausible width; it is named when its F test, with trials as independent clusters,
    would pass by chance once in 1000 over all suspects, and when it changes lengths by more than a
    detector's own lasting errors may. Nothing less than that is reported. A suspect that would
    have to be implausibly large (a focal length off by a third) is named only where no other is
    sure; a lens is first followed beyond small errors.

    Raises: Fault where no rigid pair is ever seen.
    """
    distances = rigid_distances(trials, head_lengths_m, robot)
    return check_distances(Geometry(camera, depth_m), distances)


def check_distances(
    geometry: Geometry,
    distances: Distances,
    *,
    what: str = "rigid lengths come out",
    least: float = SYSTEMATIC,
    given: Sequence[str] = (),
) -> GeometryCheck:
    """`check_geometry` of distances. what: how its sentence begins; least: as of `Estimate`; given:
    suspects that give way to a wrong scale where that explains the distances as well.

    Suspects that change none of the distances are left out.
    """
    patterns = {**camera_patterns(geometry, distances), **keypoint_patterns(distances)}
    patterns = {name: pattern for name, pattern in patterns.items() if pattern.any()}
    fits = [
        _followed(estimate(suspect, patterns, distances, least), geometry, distances)
        for suspect in SUSPECTS
        if set(suspect.parameters) <= set(patterns)
    ]
    fits.sort(key=lambda fit: -fit.gain)
    mean, std = _overall(distances)
    certain = [fit for fit in fits if fit.seen and fit.p_value < FALSE_ALARM / len(fits)]
    certain = [fit for fit in certain if fit.plausible] or certain
    best = certain[0] if certain else None
    rivals: tuple[str, ...] = ()
    if best is not None:
        first = best
        near = [f for f in fits if f.gain > first.gain - RIVAL_MARGIN
                and (f.plausible or not first.plausible)]  # fmt: skip
        if best.suspect.name in given:
            best = next((f for f in near if f.suspect.name == "scale_error"), best)
        rivals = tuple(_name(fit) for fit in near if fit is not best)
    return GeometryCheck(
        outcome=best.suspect.name if best else "nothing",
        sentence=_sentence(what, best, rivals, (mean, std, least)),
        best=best,
        rivals=rivals,
        estimates=tuple(fits),
        mean_excess=mean,
        mean_excess_std=std,
        map=distance_map(
            geometry.camera, distances, _predicted(best, patterns, len(distances.excess_m))
        ),
    )


def _followed(first: Estimate, geometry: Geometry, distances: Distances) -> Estimate:
    """The estimate of a wrong lens by Gauss and Newton's steps, where the first step is
    implausibly large: patterns of first order are those of small errors.
    """
    if first.plausible or first.suspect.name != "lens_error":
        return first
    found, names = first, first.suspect.parameters
    for _ in range(FOLLOWED):
        errors = dict(zip(names, found.values, strict=True))
        try:
            there, rest = without_error(geometry, distances, errors)
            patterns = camera_patterns(there, rest)
        except Fault:  # the corners fit no pose under such a lens
            return first
        design = np.column_stack([patterns[name] for name in names])
        whole = replace(rest, excess_m=rest.excess_m + design @ np.array(found.values))
        gain = float(np.sum((distances.excess_m**2 - rest.excess_m**2) / distances.std_m**2))
        found = replace(estimate(first.suspect, patterns, whole, first.least), gain=gain)
    return found if found.gain > first.gain else first


def estimate_depth(
    camera: PoolCamera,
    trials: Sequence[Positions],
    *,
    depth_m: float,
    head_lengths_m: Sequence[float],
    robot: Robot,
) -> tuple[float, float]:
    """Depth of the keypoints, m, and its std, for trials mapped with `camera` at a guess `depth_m`.

    The depth at which the rigid distances come out right, everything else being right: 1 mm of
    depth is worth about 0.04 % of length from 2 m up, so it needs lengths and pool known well.
    """
    distances = rigid_distances(trials, head_lengths_m, robot)
    suspect = Suspect("keypoint_depth", ("depth_m",), (1.0,), ("m",), "the keypoints lie deeper by")
    patterns = camera_patterns(Geometry(camera, depth_m), distances)
    found = estimate(suspect, patterns, distances)
    return depth_m + found.values[0], found.stds[0]


def _overall(distances: Distances) -> tuple[float, float]:
    """Weighted mean of the relative excess and its std, trials as clusters."""
    relative = distances.excess_m / distances.known_m
    weight = (distances.known_m / distances.std_m) ** 2
    mean = float(np.average(relative, weights=weight))
    labels = np.unique(distances.trial)
    pulls = [np.sum((weight * (relative - mean))[distances.trial == trial]) for trial in labels]
    return mean, float(np.sqrt(np.sum(np.square(pulls)))) / float(np.sum(weight))


def _predicted(best: Estimate | None, patterns: dict[str, Float], size: int) -> Float:
    if best is None:
        return np.zeros(size)
    terms = zip(best.suspect.parameters, best.values, strict=True)
    return np.sum([patterns[name] * value for name, value in terms], axis=0)


def _name(fit: Estimate) -> str:
    part = fit.suspect.parameters[0].removesuffix("_m")
    return f"keypoint_bias of {part}" if fit.suspect.name == "keypoint_bias" else fit.suspect.name


def _sentence(
    what: str, best: Estimate | None, rivals: tuple[str, ...], excess: tuple[float, float, float]
) -> str:
    mean, std, least = excess
    length = f"{what} {100 * mean:+.2f} +- {100 * std:.2f} % over the pool"
    if best is None and abs(mean) > max(2 * least, 4 * std):
        return f"{length}; too few trials to say why"
    if best is None:
        return f"{length}; no geometry error shows"
    also = f"; as well explained by {', '.join(rivals)}" if rivals else ""
    return f"{length}; {best.text}{also}"

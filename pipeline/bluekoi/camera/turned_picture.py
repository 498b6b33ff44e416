"""Whether the keypoints of one trial are of a picture turned by 180 degrees.

Where the camera looks down obliquely, or its lens distorts, the picture shows a length larger in
one place than in the place opposite to it. Keypoints of a turned picture are mapped as if they were
at the opposite place. With d the length of a rigid part seen in a frame, L that of most trials, and
d (1 + p) the length that the turned points would have, the points are as they should be where
d = L on average (b = 0), and turned where d = L (1 - p) (b = 1):

    d / L - 1 = -b p + e,   e ~ N(0, s^2) in each frame + N(0, tau^2) in each trial
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import hypot, log
from typing import Any

import numpy as np
from scipy.special import ndtri

from ..data import Float, Keypoints, is_confident
from ..data.majority_deviation import majority_centre_and_scatter
from ..study import Trial
from .pool_projection import PoolCamera, map_to_pool
from .rigid_distances import robust_std_and_inliers

COMPARED_RIGID_LENGTHS = {"head": ("head_tip", "hinge"), "core": ("hinge", "tail_base")}
"""Rigid lengths that are compared, and the keypoints at their ends."""
TURNED_PICTURE_FALSE_ALARM_PROBABILITY = 0.001
"""Probability with which a study of right pictures has a warning."""
MIN_FRAMES = 10
MIN_TRIALS = 3
"""Trials of one length without which no length is that of most trials."""


def half_turn_regression_sums(
    camera: PoolCamera, found: Keypoints, depth_m: float
) -> dict[str, dict[str, float]]:
    """Sums over the frames of a trial, by rigid part of `COMPARED_RIGID_LENGTHS`, as
    status/ID.json holds them: median `length_m`, `rms` and, with weights 1 / noise^2 of d, the sums
    of p^2, p and p d.
    """
    turned_px = np.array(camera.size_px, dtype=float) - 1.0 - found.xy_px
    places = {}
    for key, pixels in (("given", found.xy_px), ("turned", turned_px)):
        flat = map_to_pool(camera, pixels.reshape(-1, 2), depth_m)
        places[key] = flat.reshape(found.xy_px.shape)
    record = {}
    for name, ends in COMPARED_RIGID_LENGTHS.items():
        if not set(ends) <= set(found.names):
            continue
        front, back = (found.names.index(end) for end in ends)
        given, turned = (
            np.linalg.norm(xy[:, front] - xy[:, back], axis=1) for xy in places.values()
        )
        sure = is_confident(found.likelihood[:, [front, back]]).all(axis=1)
        good = sure & np.isfinite(given) & np.isfinite(turned) & (given > 0)
        if good.sum() >= MIN_FRAMES:
            std, near = robust_std_and_inliers(given, good)
            good &= near
            record[name] = _turned_regression_sums(given[good], turned[good], std)
    return record


def _turned_regression_sums(given_m: Float, turned_m: Float, std_m: float) -> dict[str, float]:
    change = turned_m / given_m - 1.0
    return {
        "length_m": float(np.median(given_m)),
        "pp": float(np.sum(change**2) / std_m**2),
        "p": float(np.sum(change) / std_m**2),
        "pd": float(np.sum(change * given_m) / std_m**2),
        "rms": float(np.sqrt(np.mean(change**2))),
    }


def turned_picture_warnings(
    trials: Mapping[str, Trial], statuses: Mapping[str, Mapping[str, Any]]
) -> Iterator[str]:
    """A sentence for each trial whose lengths show a turned picture, by
    `half_turn_regression_sums`.

    Odds of a turned over a right picture (b = 1 over b = 0) exceed the number of trials over
    `TURNED_PICTURE_FALSE_ALARM_PROBABILITY`, so that a study of right pictures has a warning with
    at most this probability, whatever its camera. b = 1 must agree with the lengths as well: others
    that are wrong by more than a turned picture can explain have another cause.
    """
    seen = {
        name: record
        for name, status in statuses.items()
        if status.get("ok") and name in trials and (record := status.get("turned_picture"))
    }
    least = log(max(len(seen), 1) / TURNED_PICTURE_FALSE_ALARM_PROBABILITY)
    for name, fit in _turned_fit_by_trial(trials, seen).items():
        if fit.log_odds > least and fit.agrees_with_turned_picture:
            yield (
                f"Trial {name}: {trials[name].source}: found rigid lengths of the robot that "
                f"differ from the other trials' (by {100 * fit.rms:.1f} % rms) as if the picture "
                "were turned by 180 degrees; expected the same lengths. A turned picture puts the "
                "robot at the opposite place of the pool. If it is turned, turn its keypoints "
                "back (x = width - 1 - x, y = height - 1 - y, in pixels). If it is not, look "
                "whether the camera was moved before this trial; otherwise leave the trial out."
            )


@dataclass(frozen=True)
class _TurnedFit:
    """b of one trial, its standard error, and the rms of p."""

    turned: float
    std: float
    rms: float

    @property
    def log_odds(self) -> float:
        return (2.0 * self.turned - 1.0) / (2.0 * self.std**2)

    @property
    def agrees_with_turned_picture(self) -> bool:
        sigmas = float(ndtri(1.0 - TURNED_PICTURE_FALSE_ALARM_PROBABILITY / 2.0))
        return abs(self.turned - 1.0) <= sigmas * self.std


def _turned_fit_by_trial(
    trials: Mapping[str, Trial], seen: Mapping[str, Mapping[str, Any]]
) -> dict[str, _TurnedFit]:
    """Fit of b for each trial for which most trials give a length to compare with."""
    groups: dict[tuple[str, float], dict[str, Mapping[str, float]]] = {}
    for name, record in seen.items():
        for part, sums in record.items():
            key = part, trials[name].head_length_m if part == "head" else 0.0
            groups.setdefault(key, {})[name] = sums
    fits: dict[str, list[tuple[float, float, float, float]]] = {}
    for members in groups.values():
        if len(members) < MIN_TRIALS:
            continue
        lengths = np.array([sums["length_m"] for sums in members.values()])
        usual, scatter = majority_centre_and_scatter(lengths)
        for name, sums in members.items():
            cross = usual * (usual * sums["p"] - sums["pd"])
            fits.setdefault(name, []).append(
                (cross, usual**2 * sums["pp"], scatter / usual, sums["rms"])
            )
    return {name: fit for name, rows in fits.items() if (fit := _turned_fit_over_lengths(rows))}


def _turned_fit_over_lengths(rows: list[tuple[float, float, float, float]]) -> _TurnedFit | None:
    """Fit over the lengths of a trial; the scatter between trials is common to them."""
    cross, information = sum(row[0] for row in rows), sum(row[1] for row in rows)
    rms = max(row[3] for row in rows)
    if information <= 0 or rms <= 0:
        return None
    scatter = max(row[2] for row in rows)
    return _TurnedFit(cross / information, hypot(information**-0.5, scatter / rms), rms)

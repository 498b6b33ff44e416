"""Strengths of hidden causes that the ideal detector sees with a wanted sigma."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .catalogue import bounds
from .design import WATER_INDEX, Impossible, Study
from .detector import STEP, judge
from .dynamics import Motion
from .form import DT, Array, Cause, strengths_of
from .laws_camera import SCALED
from .observe import frame_times
from .placing import place, time_inside

SHORTEST = 6.0
"""Duration of the shortest recording, s."""
WEAKEST, STRONGEST = 8.0, 40.0
"""Range of sigma."""
ROUNDS, MOVES = 12, 6


@dataclass(frozen=True)
class Outcome:
    """Motion, durations of the recordings (s, by the study's clock), and sigma of every cause."""

    motion: Motion
    durations: Array
    sigma: Array


@dataclass
class _Target:
    """Wanted sigma of a hidden cause.

    bracket: logarithms of a strength that is too small, and of one that is too large, each with
    that of the ratio of its sigma to the wanted one.
    """

    cause: Cause
    sigma: float
    bracket: list[tuple[float, float] | None] = field(default_factory=lambda: [None, None])

    def next_size(self, size: float, sigma: float) -> float:
        """Next strength to try: in proportion, or between too small and too large ones."""
        wanted = self.sigma
        self.bracket[int(sigma > wanted)] = (np.log(size), np.log(sigma / wanted))
        low, high = self.bracket
        if low is None or high is None or low[0] >= high[0]:
            return size * np.clip(wanted / sigma, 0.15, 6.0)
        share = np.clip(-low[1] / (high[1] - low[1]), 0.25, 0.75)
        return np.exp(low[0] + (high[0] - low[0]) * share)


def horizon(study: Study) -> int:
    """Steps to simulate so that every wanted frame is covered."""
    strengths, wanted = strengths_of(study.causes), study.plan.wanted
    last = max(
        float(frame_times(np.array([t]), np.array([i]), study.causes, strengths)[0])
        for i, t in enumerate(wanted)
    )
    return int(np.ceil((max(last, wanted.max()) + 0.5) / DT))


def _durations(study: Study, states: Array) -> Array:
    """How long each recording lasts (s, by the study's clock): as wanted or up to a wall."""
    inside = time_inside(study.robot, study.plan, states)
    wanted, strengths = study.plan.wanted, strengths_of(study.causes)
    stated = np.arange(0, wanted.max() + STEP, 0.05)
    durations = np.empty(study.robot.trials)
    for i in range(study.robot.trials):
        t = frame_times(stated, np.full(len(stated), i), study.causes, strengths)
        filmed = (t < min(inside[i], (len(states) - 2) * DT)) & (stated <= wanted[i])
        durations[i] = stated[-1] if filmed.all() else stated[int(np.argmin(filmed)) - 1]
    return np.where(inside < 1, 0.0, durations)


def _restate(study: Study) -> None:
    """Set what the experimenters state, given the strengths: pool size, index and depth."""
    study.size_stated, study.index_stated = np.array(study.robot.pool), WATER_INDEX
    for cause in study.causes:
        if cause.family.name == "scale_error":
            ways = np.array(SCALED[cause.form])
            study.size_stated = study.size_stated * (1 + cause.strength * ways)
        if cause.family.name == "uncorrected_refraction":
            if cause.form == "wrong_index":
                study.index_stated = WATER_INDEX - cause.strength
            else:
                study.robot.keypoint_depth = study.shallow


def _plausible(study: Study, states: Array, durations: Array) -> bool:
    """Whether speeds are between 0.2 and 3 body lengths per second."""
    for i, duration in enumerate(durations):
        late = slice(int(0.3 * duration / DT), int(duration / DT))
        speed = np.hypot(states[late, 3, i], states[late, 4, i]) / study.robot.body_length
        if not (speed.mean() > 0.2 and speed.max() < 3 and np.isfinite(speed).all()):
            return False
    return True


def _adjusted(study: Study, target: _Target, sigma: float, turn: int) -> bool | None:
    """Change the strength of a cause towards its wanted sigma.

    True at the upper limit of the strength, where the wanted sigma becomes the one found; False if
    the strength was changed; None if it may stay.
    """
    cause, wanted = target.cause, target.sigma
    if cause.family.seen and sigma >= WEAKEST:
        return None
    if 0.85 < sigma / wanted < 1.18 or (turn > 4 and WEAKEST <= sigma <= STRONGEST):
        return None
    low, high = bounds(study.robot, cause)
    size = abs(cause.strength)
    if size > 0.999 * high and sigma < wanted:
        if sigma < WEAKEST:
            raise Impossible("too weak even at the largest plausible strength")
        target.sigma = sigma
        return True
    if size < 1.001 * low and sigma > wanted:
        raise Impossible("too strong even at the smallest strength")
    new = np.clip(target.next_size(size, sigma), low, high)
    cause.strength = float(np.sign(cause.strength) * new)
    return False


def _settled(study: Study, targets: list[_Target], sigma: Array, turn: int) -> bool:
    """Change the strengths that need it; whether they are settled and within the range of sigma.

    The last cause that did not stay as it was decides.
    """
    settled = True
    for target, value in zip(targets, sigma, strict=True):
        verdict = _adjusted(study, target, value, turn)
        settled = settled if verdict is None else verdict
    tops = [np.inf if target.cause.family.seen else STRONGEST for target in targets]
    inside = (WEAKEST <= s <= top for s, top in zip(sigma, tops, strict=True))
    return settled and all(inside)


def _check(study: Study, outcome: Outcome) -> None:
    """Raises: Impossible where the fin cannot be seen or speeds are not plausible."""
    if min(outcome.sigma, default=WEAKEST) < WEAKEST:
        raise Impossible("the fin cannot be seen")
    if not _plausible(study, outcome.motion.states, outcome.durations):
        raise Impossible("speeds are not plausible")


def _place_anew(
    rng: np.random.Generator, study: Study, states: Array, *, short: Array, first: Array
) -> None:
    """Shorten trials that hit a wall early and give them new starting places."""
    wanted = study.plan.wanted
    wanted[short] = np.maximum(wanted[short] * 0.9, SHORTEST + 1)
    place(
        rng, study.robot, study.plan, states,
        which=short, first=first, to_walls=study.to_walls,
    )  # fmt: skip


def reach(rng: np.random.Generator, study: Study, hidden: list[Cause], first: Array) -> Outcome:
    """Bring the hidden causes, the last of the study's, to wanted values of sigma.

    Secant steps on the logarithm of the strength, within the plausible range. A cause that the
    labels show directly (servo_lag) keeps its drawn strength: a lag of any practical size stands
    far more than 40 sigma above zero.
    """
    targets = [_Target(cause, rng.uniform(1.15 * WEAKEST, 0.9 * STRONGEST)) for cause in hidden]
    steps, moves, others = horizon(study), 0, len(study.causes) - len(hidden)
    for turn in range(ROUNDS):
        _restate(study)
        steps = max(steps, horizon(study))
        motion = study.simulated(first, steps, study.weather)
        if not np.isfinite(motion.states).all():
            raise Impossible("the motion is not finite")
        durations = _durations(study, motion.states)
        short = np.flatnonzero(durations < SHORTEST)
        if len(short):
            moves += 1
            if moves > MOVES:
                raise Impossible("a trial cannot stay in the pool")
            _place_anew(rng, study, motion.states, short=short, first=first)
            continue
        outcome = Outcome(motion, durations, judge(study, motion, durations)[0])
        if _settled(study, targets, outcome.sigma[others:], turn):
            _check(study, outcome)
            return outcome
    raise Impossible("the strengths do not settle")

"""Detection of a bending body on FastTrack's film of 14 fish, a line a fish.

    python benchmarks/fish_film.py FOLDER [--fish 0 1 2] [--together] [--enlarge 2] [--bright]

FOLDER holds `fish.mp4` and `tracking.txt` (FastTrackOrg/FastTrack). Each fish is detected alone,
all others painted over; with `--together` in the whole film, from its first position. `--enlarge`
resizes the pictures, `--bright` inverts them.
Printed a fish: frames that FastTrack knows; share of them found (head within a quarter of the
length); share of the found ones in which every keypoint inside the picture has a likelihood of at
least 0.6; wrong frames with a likelihood of the head of 0.6 and of 0.9 or more; 95th percentile of
the head's distance among the found, in lengths; share of the frames with a point above 0.5.
Exits with 1 where a bar is missed.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np

from bluekoi.data import Frame, Keypoints
from bluekoi.keypoints import silhouette
from bluekoi.study import StudySettings, Trial

COLUMNS = ["xHead", "yHead", "xBody", "yBody", "xTail", "yTail"]
FISH_COUNT, FISH_PX, TAIL_SHARE, HEAD_SHARE, COM_SHARE = 14, 41.0, 0.25, 0.225, 0.3375
"""Length of a fish; its tail; hinge and centre of mass behind the nose, as shares of its length."""
FRAMES_PER_SECOND = 50.0
WRONG_DISTANCE_LENGTHS = 0.25
FOUND_BAR, LIKELY_BAR = 0.97, 0.9


@dataclass(frozen=True)
class Score:
    """One fish, frames that the reference knows. off: (frames,) lengths, NaN not found.

    likelihood, inside: (frames, keypoints), the latter whether it lies in the picture.
    """

    off: np.ndarray
    likelihood: np.ndarray
    inside: np.ndarray

    @property
    def found(self) -> np.ndarray:
        """Frames (frames,) in which the head is where the reference has it."""
        return self.off < WRONG_DISTANCE_LENGTHS

    @property
    def likely_share(self) -> float:
        """Share of the found frames with every keypoint likely that lies in the picture."""
        return float(np.mean(((self.likelihood >= 0.6) | ~self.inside)[self.found].all(axis=1)))

    def wrong(self, likelihood: float) -> int:
        """Frames with the head elsewhere and a likelihood of at least so much."""
        return int(np.sum(~self.found & (self.likelihood[:, :2].max(axis=1) >= likelihood)))


def real_fish(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Pictures (frames, height, width) and places (fish, frames, 3, 2) px, NaN where not known."""
    film = cv2.VideoCapture(str(folder / "fish.mp4"))
    pictures = []
    while (read := film.read())[0]:
        pictures.append(read[1][..., 1])
    rows = np.genfromtxt(folder / "tracking.txt", names=True)
    places = np.full((FISH_COUNT, len(pictures), 3, 2), np.nan)
    values = np.column_stack([rows[name] for name in COLUMNS]).reshape(-1, 3, 2)
    places[rows["id"].astype(int), rows["imageNumber"].astype(int)] = values
    return np.array(pictures), places


def distance_from_body(shape: tuple[int, int], body: np.ndarray) -> np.ndarray:
    """Distance (height, width) px from a body's head, middle and tail, its tail carried on."""
    v, u = np.indices(shape)
    line = np.concatenate([body, [2 * body[2] - body[1]]])
    nearest = np.full(shape, np.inf)
    for a, b in pairwise(line):
        along = ((u - a[0]) * (b - a)[0] + (v - a[1]) * (b - a)[1]) / max((b - a) @ (b - a), 1e-6)
        along = np.clip(along, 0, 1)
        away = np.hypot(u - a[0] - along * (b - a)[0], v - a[1] - along * (b - a)[1])
        nearest = np.minimum(nearest, away)
    return nearest


def film_of_one_fish(pictures: np.ndarray, places: np.ndarray, which: int) -> list[Frame]:
    """The film with all other fish painted over."""
    rng = np.random.default_rng(which)
    empty = np.median(pictures[::4], axis=0)
    frames, shape = np.arange(len(pictures)), pictures.shape[1:]
    full = places.copy()
    for index in np.ndindex(FISH_COUNT, 3, 2):
        values = full[index[0], :, index[1], index[2]]
        seen = np.isfinite(values)
        values[~seen] = np.interp(frames[~seen], frames[seen], values[seen])
    film = []
    for i, picture in enumerate(pictures):
        own = distance_from_body(shape, full[which, i])
        other = np.full(shape, np.inf)
        for body in np.delete(full[:, i], which, axis=0):
            if np.hypot(*(body[1] - full[which, i, 1])) < 120:
                other = np.minimum(other, distance_from_body(shape, body))
        dark = cv2.dilate((empty - picture > 25).astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
        gone = (dark & (own > 28)) | ((other < 16) & (other < own) & (own > 3))
        painted = np.where(gone, empty + rng.normal(0, 4.5, shape), picture)
        film.append(make_frame(i, painted))
    return film


def make_frame(number: int, picture: np.ndarray) -> Frame:
    """A frame of a picture of any type."""
    luma = np.clip(picture, 0, 255).astype(np.uint8)
    return Frame(number, number / FRAMES_PER_SECOND, luma)


def enlarged_or_inverted(film: list[Frame], enlarge: float, *, bright: bool) -> list[Frame]:
    """The film enlarged, and inverted if `bright`."""
    pictures = [255 - one.luma if bright else one.luma for one in film]
    if enlarge != 1:
        pictures = [cv2.resize(one, None, fx=enlarge, fy=enlarge) for one in pictures]
    return [make_frame(i, one) for i, one in enumerate(pictures)]


def fish_study(
    shape: tuple[int, int], whole_m: float, fish_px: float = FISH_PX, start_px=None
) -> tuple[StudySettings, Trial]:
    """Setup and trial of the film, its fish stated as so many metres and pixels long."""
    m_per_px, body_m = whole_m / fish_px, whole_m * (1 - TAIL_SHARE)
    height, width = shape
    head_m = HEAD_SHARE * whole_m
    robot = {
        "mass_kg": 100 * body_m**3,
        "yaw_inertia_kg_m2": 5 * body_m**5,
        "body_length_m": body_m,
        "head_length_m": head_m,
        "head_span_m": 0.2 * body_m,
        "hinge_to_com_m": (COM_SHARE - HEAD_SHARE) * whole_m,
        "tail_length_m": TAIL_SHARE * whole_m,
        "keypoint_depth_m": 0.0,
    }
    sides = {"length_m": width * m_per_px, "width_m": height * m_per_px}
    corners = ((0, height), (width, height), (width, 0), (0, 0))
    setup = StudySettings(
        pool={**sides, "depth_m": height * m_per_px},
        robot=robot,
        camera={"pool_corners_px": corners},
        detection={"body": "auto" if start_px is None else "bending"},
    )
    start = (
        {} if start_px is None else dict(zip(("start_x_px", "start_y_px"), start_px, strict=True))
    )
    trial = Trial(
        trial_id="fish", source="fish.mp4", power_pct=0, head_angle_deg=0,
        head_length_m=head_m, **start,
    )  # fmt: skip
    return setup, trial


def score_fish(
    found: Keypoints, places: np.ndarray, shape: tuple[int, int], fish_px: float = FISH_PX
) -> Score:
    """Detection against the reference's places (frames, 3, 2) px of one fish."""
    known = np.isfinite(places[:, 0, 0])
    head = found.xy_px[:, :2].mean(axis=1)
    off = np.linalg.norm(head - places[:, 0], axis=1) / fish_px
    inside = ((found.xy_px >= 0) & (found.xy_px <= np.array(shape)[::-1] - 1)).all(axis=2)
    return Score(off[known], found.likelihood[known], inside[known])


def result_line(which: int, one: Score) -> str:
    """What is printed for a fish."""
    far = np.nanpercentile(np.where(one.found, one.off, np.nan), 95)
    believed = np.mean(one.likelihood.max(axis=1) > 0.5)
    return (
        f"fish {which:2d}: {len(one.off):4d} frames  found {one.found.mean():6.1%}  likely "
        f"{one.likely_share:6.1%}  wrong at 0.6 {one.wrong(0.6):3d}  at 0.9 {one.wrong(0.9):3d}  "
        f"95th percentile {far:.3f}  not doubted {believed:6.1%}"
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--fish", nargs="+", type=int, default=list(range(FISH_COUNT)))
    parser.add_argument("--together", action="store_true", help="all fish in the film")
    parser.add_argument("--enlarge", type=float, default=1.0)
    parser.add_argument("--bright", action="store_true", help="bright fish on a dark floor")
    parser.add_argument("--length-m", type=float, default=0.016)
    options = parser.parse_args()
    pictures, places = real_fish(options.folder)
    whole = [make_frame(i, one) for i, one in enumerate(pictures)]
    missed = []
    for which in options.fish:
        film = whole if options.together else film_of_one_fish(pictures, places, which)
        film = enlarged_or_inverted(film, options.enlarge, bright=options.bright)
        reference = (places[which] + 0.5) * options.enlarge - 0.5
        fish_px = FISH_PX * options.enlarge
        start = reference[0, 0] if options.together else None
        setup, trial = fish_study(film[0].luma.shape, options.length_m, fish_px, start)
        found = silhouette.detect_keypoints(lambda film=film: film, setup, trial)
        one = score_fish(found, reference, film[0].luma.shape, fish_px)
        print(result_line(which, one), flush=True)
        if options.together:
            good = one.wrong(0.6) == 0
        else:
            good = (
                one.found.mean() > FOUND_BAR
                and one.likely_share > LIKELY_BAR
                and one.wrong(0.9) == 0
            )
        missed += [] if good else [which]
    print(f"bars missed by fish {missed}" if missed else "all bars met")
    return 1 if missed else 0


if __name__ == "__main__":
    raise SystemExit(main())

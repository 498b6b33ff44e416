"""Detection on rendered footage: right points, honest likelihoods and covariances."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from itertools import pairwise

import cv2
import numpy as np
import pytest

from pipeline.data import PARTS, Frame
from pipeline.faults import Fault
from pipeline.keypoints import ends, markers, silhouette
from pipeline.keypoints.outline.background import median, sample, without_resident
from pipeline.keypoints.outline.edges import edge_offset
from pipeline.keypoints.outline.plane import plane_of
from pipeline.keypoints.outline.template import first_template, learned
from pipeline.study import Setup, Trial
from pipeline.synthetic.conditions import LADDER
from pipeline.synthetic.design import ladder_design
from pipeline.synthetic.film import frames_of
from pipeline.synthetic.optics import pool_corners
from pipeline.synthetic.trial import camera_at, frame_truth, prepare

RIGID = (0, 1, 2)
STRAIGHT, LEFT, RIGHT = "T01", "T02", "T03"


def setup_of(design, **detection) -> Setup:
    camera, tank = camera_at(design, -1.0), design.tank
    (fx, fy), (cx, cy) = camera.focal_px, camera.middle_px
    robot = {name: getattr(tank.robot, name) for name in tank.robot.__dataclass_fields__}
    return Setup(
        robot=robot,
        camera={
            "model": camera.lens,
            "image_size_px": camera.size_px,
            "matrix": ((fx, 0, cx), (0, fy, cy), (0, 0, 1)),
            "distortion": camera.distortion,
            "pool_corners_px": [tuple(map(float, c)) for c in pool_corners(camera, tank.pool_m)],
        },
        detection=detection,
    )


def trial_of(plan) -> Trial:
    return Trial(
        trial_id=plan.trial_id,
        source="v.mp4",
        power_pct=plan.power_pct,
        head_angle_deg=plan.head_angle_deg,
        head_length_m=plan.head_length_m,
    )


@lru_cache(maxsize=3)
def rendered(step: str, name: str, *, seconds: float = 2.4, every: int = 4, colour: bool = False):
    """Frames, setup, trial and true keypoints (frames, 5, 2) of one rendered trial."""
    design = ladder_design(LADDER[step], longest_s=seconds)
    trial = prepare(design, name)
    number = range(0, len(trial.time_s), every)
    thinned = replace(trial, time_s=trial.time_s[::every])
    film = []
    for i, planes in zip(number, frames_of(design, thinned), strict=True):
        bgr = _bgr(planes) if colour else None
        film.append(Frame(i, float(trial.time_s[i]), planes.luma, bgr))
    truth = frame_truth(design, thinned)["keypoints_px"]
    return film, setup_of(design), trial_of(trial.plan), truth


def _bgr(planes) -> np.ndarray:
    full = [cv2.resize(c, planes.luma.shape[::-1]) for c in planes.chroma]
    return cv2.cvtColor(np.stack([planes.luma, full[1], full[0]], axis=2), cv2.COLOR_YCrCb2BGR)


def errors(found, truth) -> np.ndarray:
    return np.linalg.norm(found.xy_px - truth, axis=2)


def pulls(found, truth) -> np.ndarray:
    """Root mean square of the normalised error of each part; 1 where the covariance is right."""
    off = found.xy_px - truth
    square = np.einsum("nki,nkij,nkj->nk", off, np.linalg.inv(found.cov_px2), off) / 2
    return np.sqrt(square.mean(axis=0))


@pytest.mark.parametrize("name", [STRAIGHT, LEFT, RIGHT])
def test_middle_step_is_found_to_a_third_of_a_pixel(name):
    film, setup, trial, truth = rendered("middle", name)
    found = silhouette.detect(lambda: film, setup, trial)
    off = errors(found, truth)
    assert found.names == PARTS
    assert np.all(np.median(off, axis=0)[list(RIGID)] <= 0.3)
    assert off.max() < 3.0
    assert np.mean(found.likelihood > 0.9) > 0.97
    assert np.all(np.median(off, axis=0) < 0.5)


def test_stated_covariances_have_the_right_width():
    square = []
    for name in (STRAIGHT, LEFT, RIGHT):
        film, setup, trial, truth = rendered("middle", name)
        square.append(pulls(silhouette.detect(lambda f=film: f, setup, trial), truth) ** 2)
    width = np.sqrt(np.mean(square, axis=0))
    assert np.all((width > 0.75) & (width < 1.25))
    assert np.sqrt(np.mean(width[list(RIGID)] ** 2)) == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize(
    ("step", "name"),
    [("hand", STRAIGHT), ("second_body", LEFT), ("occluder", LEFT), ("leaving", STRAIGHT)],
)
def test_things_in_the_way_never_make_a_confident_wrong_point(step, name):
    film, setup, trial, truth = rendered(step, name)
    found = silhouette.detect(lambda: film, setup, trial)
    wrong = (errors(found, truth) > 5.0) & (found.likelihood > 0.9)
    assert wrong.sum() == 0
    assert np.mean(found.likelihood[:, 2] > 0.5) > 0.6


def test_a_robot_that_never_moves_is_found_and_told():
    film, setup, trial, truth = rendered("middle", LEFT)
    still = [replace(frame, luma=film[0].luma) for frame in film[:6]]
    found = silhouette.detect(lambda: still, setup, trial)
    assert any("hardly left its place" in remark for remark in found.remarks)
    assert np.all(errors(found, truth[:1])[:, :3] < 5.0)


def test_an_empty_pool_has_no_robot():
    film, setup, trial, _ = rendered("middle", LEFT)
    empty = median([frame.luma for frame in film])
    rng = np.random.default_rng(0)
    noisy = [
        replace(f, luma=np.clip(empty + rng.normal(0, 2, empty.shape), 0, 255).astype(np.uint8))
        for f in film[:5]
    ]
    found = silhouette.detect(lambda: noisy, setup, trial)
    assert np.all(found.likelihood < 0.5)
    assert any("without the robot" in r or "no robot" in r for r in found.remarks)


def test_no_frames_is_a_fault():
    _, setup, trial, _ = rendered("middle", LEFT)
    for source in (silhouette, ends):
        with pytest.raises(Fault, match="no frames"):
            source.detect(list, setup, trial)


def test_a_brighter_robot_is_found_as_well():
    film, setup, trial, truth = rendered("calm", LEFT)
    bright = [replace(frame, luma=255 - frame.luma) for frame in film]
    found = silhouette.detect(lambda: bright, setup, trial)
    assert np.all(np.median(errors(found, truth), axis=0)[list(RIGID)] <= 1.0)


def test_markers_are_found_by_hue():
    film, setup, trial, truth = rendered("markers", LEFT, seconds=1.0, colour=True)
    hues = {"head_tip": 2, "hinge": 50, "core_center": 128, "tail_base": 306, "tail_tip": 29}
    detection = setup.detection.model_copy(update={"marker_hues_deg": hues})
    setup = setup.model_copy(update={"detection": detection})
    found = markers.detect(lambda: film, setup, trial)
    off = errors(found, truth)
    assert np.all(np.nanmedian(off, axis=0) < 0.6)
    assert not np.any((off > 5) & (found.likelihood > 0.9))
    with pytest.raises(Fault, match="colour frames"):
        markers.detect(lambda: [replace(film[0], bgr=None)], setup, trial)


def test_markers_need_hues():
    film, setup, trial, _ = rendered("middle", LEFT)
    with pytest.raises(Fault, match="marker_hues_deg"):
        markers.detect(lambda: film, setup, trial)


def step_picture(place: float, *, blur: float = 1.0, angle: float = 0.3) -> np.ndarray:
    """Dark (60) on the left of a slanted edge through (40 + place, 40), bright (180) beyond."""
    v, u = (np.indices((800, 800)) - 4.5) / 10.0
    beyond = (u - 40 - place) * np.cos(angle) + (v - 40) * np.sin(angle) > 0
    fine = cv2.GaussianBlur(np.where(beyond, 180.0, 60.0), (0, 0), 10 * blur)
    return np.round(fine.reshape(80, 10, 80, 10).mean(axis=(1, 3))).astype(np.uint8)


@pytest.mark.parametrize("place", [-1.3, -0.4, 0.0, 0.25, 0.7, 2.1])
@pytest.mark.parametrize("gain", [1.0, 0.85])
def test_an_edge_is_found_to_a_twentieth_of_a_pixel(place, gain):
    luma = step_picture(place)
    floor = np.full_like(luma, round(180 / gain))
    normal = (np.cos(0.3), np.sin(0.3))
    found = edge_offset((luma, floor), (40.0, 40.0, *normal), 60.0, np.empty((2, 17)))
    assert found == pytest.approx(place * np.cos(0.3), abs=0.06)


def test_no_edge_where_there_is_none():
    flat = np.full((80, 80), 180, np.uint8)
    assert np.isnan(edge_offset((flat, flat), (40.0, 40.0, 1.0, 0.0), 60.0, np.empty((2, 17))))
    dim = np.full((80, 80), 65, np.uint8)
    assert np.isnan(edge_offset((dim, dim), (40.0, 40.0, 1.0, 0.0), 60.0, np.empty((2, 17))))
    edge = step_picture(0.0)
    assert np.isnan(edge_offset((edge, edge), (3.0, 40.0, 1.0, 0.0), 60.0, np.empty((2, 17))))


def test_plane_agrees_with_independent_optics():
    design = ladder_design(LADDER["middle"])
    trial = prepare(design, STRAIGHT)
    truth = frame_truth(design, trial)
    plane = plane_of(setup_of(design))
    m, px = (truth[k].reshape(-1, 2) for k in ("keypoints_m", "keypoints_px"))
    assert np.abs(plane.pixels(m) - px).max() < 0.06
    assert np.abs(plane.metres(px) - m).max() < 2e-4


def test_median_is_exact():
    images = np.random.default_rng(2).integers(0, 256, (7, 40, 60)).astype(np.uint8)
    np.testing.assert_array_equal(median(images), np.median(images, axis=0).astype(np.uint8))


@pytest.mark.parametrize("count", [1, 4, 9, 40, 200])
def test_a_few_frames_from_all_of_a_film(count):
    film = [Frame(i, i / 30, np.full((4, 4), i % 256, np.uint8)) for i in range(count)]
    few = sample(iter(film), 5)
    assert 1 <= len(few) <= 5
    assert few[0].index == 0
    if count > 40:
        assert max(b.index - a.index for a, b in pairwise(few)) < 0.5 * count


def test_resting_body_is_bridged():
    pool = np.full((300, 400), 180, np.uint8)
    cv2.ellipse(pool, (200, 150), (60, 14), 20, 0, 360, 50, -1)
    assert without_resident(pool, 30.0).min() > 150


def test_template_learns_the_half_widths_and_keeps_the_nose_at_the_heads_length():
    _, setup, trial, _ = rendered("middle", LEFT)
    start = first_template(setup.robot, trial, 0.034, 60.0)
    kept = start.kept()
    shift = np.full((4, len(kept)), np.nan)
    shift[:, kept] = 0.002
    wider = learned(start, shift, np.full(shift.shape, 70.0))
    assert np.allclose(wider.half[5:-5], start.half[5:-5] + 0.002, atol=4e-4)
    assert wider.radii[0] == pytest.approx(start.radii[0], abs=1e-9)
    points, normals, part, skin = wider.shape()
    assert np.allclose(np.hypot(*normals.T), 1.0)
    assert points[part == 0, 0].max() == pytest.approx(trial.head_length_m)
    assert np.all(skin[2:-2] == 70.0)
    assert len(points) == len(skin) == len(part) == wider.kept().sum()


def mouse_setup() -> tuple[Setup, Trial]:
    robot = {
        "mass_kg": 1, "yaw_inertia_kg_m2": 1, "body_length_m": 0.1, "head_length_m": 0.03,
        "head_span_m": 0.03, "hinge_to_com_m": 0.02, "tail_length_m": 0.05,
    }  # fmt: skip
    corners = ((0, 480), (640, 480), (640, 0), (0, 0))
    trial = Trial(trial_id="m", source="m.mp4", power_pct=0, head_angle_deg=0, head_length_m=0.03)
    return Setup(robot=robot, camera={"pool_corners_px": corners}), trial


@pytest.mark.recordings
def test_nose_and_tail_base_of_the_labelled_mouse(recordings):
    """116 frames labelled by hand: median 5 px, 95 % within 15 px."""
    folder = recordings / "openfield_mouse" / "labeled-data" / "m4s1"
    from pipeline.keypoints.deeplabcut import read_any

    labels = read_any(folder / "CollectedData_Pranav.csv", 30.0)
    pictures = [
        cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) for path in sorted(folder.glob("*.png"))
    ]
    film = [Frame(i, i / 30, picture) for i, picture in enumerate(pictures)]
    found = ends.detect(lambda: film, *mouse_setup())
    assert len(film) == len(labels.time_s) == 116
    for part, label in (("head_tip", "snout"), ("tail_base", "tailbase")):
        off = np.linalg.norm(found.part(part) - labels.part(label), axis=1)
        assert np.median(off) <= 5.0
        assert np.mean(off <= 15.0) >= 0.95


def test_ends_of_a_drawn_body_with_and_without_a_tail():
    def picture(x: int, tailed: bool) -> np.ndarray:
        image = np.full((480, 640), 200, np.uint8)
        cv2.ellipse(image, (x, 240), (60, 24), 0, 0, 360, 20, -1)
        if tailed:
            cv2.line(image, (x - 58, 240), (x - 140, 250), 110, 5)
        return cv2.GaussianBlur(image, (0, 0), 1.0)

    film = [Frame(i, i / 30, picture(180 + 30 * i, i != 6)) for i in range(10)]
    found = ends.detect(lambda: film, *mouse_setup())
    nose, base = found.part("head_tip"), found.part("tail_base")
    assert np.abs(nose[:, 0] - (240 + 30 * np.arange(10))).max() < 5
    assert np.abs(base[:, 0] - (120 + 30 * np.arange(10))).max() < 6
    assert found.likelihood[6, 0] <= 0.5 < found.likelihood[2, 0]

"""The parts of detection one by one: edges, plane, background, template; and the ends of a body."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from scipy.special import ndtr
from test_keypoints_silhouette import STRAIGHT, setup_of_design, trial_of_plan

from bluekoi.camera import pool_camera, pool_to_pixels
from bluekoi.data import Frame
from bluekoi.keypoints.outline import ghost_removal
from bluekoi.keypoints.outline.background import (
    ROWS_PER_STRIP,
    grey_level_quantiles,
    median_image,
    sample_frames,
    without_static_robot,
)
from bluekoi.keypoints.outline.edges import edge_offset
from bluekoi.keypoints.outline.ghost_removal import _write_unhidden_median
from bluekoi.keypoints.outline.outline_stations import ACROSS_EDGE_PX, edge_blur_px
from bluekoi.keypoints.outline.plane import swimming_plane_map
from bluekoi.keypoints.outline.tail_detection import tail_length
from bluekoi.keypoints.outline.template import (
    initial_template,
    nan_median,
    nose_edge_shift_by_blur,
    with_learned_outline,
)
from bluekoi.synthetic.optics import gopro_like_camera
from bluekoi.synthetic.picture_conditions import PICTURE_CONDITIONS_BY_NAME
from bluekoi.synthetic.synthetic_study_design import picture_conditions_design
from bluekoi.synthetic.trial import frame_truth, solve_trial


def step_picture(place: float, *, blur: float = 1.0, angle: float = 0.3) -> np.ndarray:
    """Dark (60) on the left of a slanted edge through (40 + place, 40), bright (180) beyond."""
    v, u = (np.indices((800, 800)) - 4.5) / 10.0
    beyond = (u - 40 - place) * np.cos(angle) + (v - 40) * np.sin(angle) > 0
    fine = cv2.GaussianBlur(np.where(beyond, 180.0, 60.0), (0, 0), 10 * blur)
    return np.round(fine.reshape(80, 10, 80, 10).mean(axis=(1, 3))).astype(np.uint8)


@pytest.mark.parametrize("place", [-1.3, -0.4, 0.0, 0.25, 0.7, 2.1])
@pytest.mark.parametrize("gain", [1.0, 0.85, 0.72])
def test_an_edge_is_found_to_a_twentieth_of_a_pixel(place, gain):
    luma = step_picture(place)
    floor = np.full_like(luma, round(180 / gain))
    normal = (np.cos(0.3), np.sin(0.3))
    found, _, _ = edge_offset((luma, floor), (40.0, 40.0, *normal), 60.0, np.empty((2, 17)))
    assert found == pytest.approx(place * np.cos(0.3), abs=0.06)


@pytest.mark.parametrize("place", [-0.4, 0.0, 0.7])
@pytest.mark.parametrize("light", [-0.015, 0.015])
def test_an_edge_beside_a_shadow_is_found_where_it_is(place, light):
    """light: change of the floor's brightness, 1/px, as in the half-shade beside a shadow."""
    v, u = np.indices((80, 80))
    outwards = (u - 40) * np.cos(0.3) + (v - 40) * np.sin(0.3)
    body = (180.0 - step_picture(place)) / 120.0
    lit = body * 60.0 + (1.0 - body) * 180.0 * (0.85 + light * outwards)
    pictures = np.round(lit).astype(np.uint8), np.full((80, 80), 180, np.uint8)
    normal = (np.cos(0.3), np.sin(0.3))
    lines = np.empty((2, 17))
    found, gradient, derivative = edge_offset(pictures, (40.0, 40.0, *normal), 60.0, lines)
    off = found - place * np.cos(0.3)
    assert abs(off) > 0.1
    assert gradient == pytest.approx(light, rel=0.35)
    assert abs(off + gradient * derivative) < 0.4 * abs(off)


def test_no_edge_where_there_is_none():
    flat = np.full((80, 80), 180, np.uint8)
    assert np.isnan(edge_offset((flat, flat), (40.0, 40.0, 1.0, 0.0), 60.0, np.empty((2, 17)))[0])
    dim = np.full((80, 80), 65, np.uint8)
    assert np.isnan(edge_offset((dim, dim), (40.0, 40.0, 1.0, 0.0), 60.0, np.empty((2, 17)))[0])
    edge = step_picture(0.0)
    assert np.isnan(edge_offset((edge, edge), (3.0, 40.0, 1.0, 0.0), 60.0, np.empty((2, 17)))[0])


def nose_picture(centre: np.ndarray, angle: float, exponent: float) -> np.ndarray:
    """Dark (60) nose at an angle, its tip at a place, 1.5 (|y| / 4)^exponent px back at y aside."""
    v, u = (np.indices((600, 600)) - 4.5) / 10.0
    ahead = (u - centre[0]) * np.cos(angle) + (v - centre[1]) * np.sin(angle)
    aside = (v - centre[1]) * np.cos(angle) - (u - centre[0]) * np.sin(angle)
    body = ahead < -1.5 * (np.abs(aside) / 4.0) ** exponent
    fine = np.where(body & (ahead > -14), 60.0, 180.0)
    return np.round(fine.reshape(60, 10, 60, 10).mean(axis=(1, 3))).astype(np.uint8)


@pytest.mark.parametrize("sigma_px", [0.5, 0.7, 1.0])
def test_the_blur_is_read_from_the_coverage_across_an_edge(sigma_px):
    rng = np.random.default_rng(8)
    places = ACROSS_EDGE_PX[:, None] - rng.normal(0.0, 0.02, 200)
    covered = 0.04 + 0.93 * ndtr(-places / sigma_px) + rng.normal(0.0, 0.05, places.shape)
    assert edge_blur_px(covered) == pytest.approx(sigma_px, rel=0.1)


@pytest.mark.parametrize(("exponent", "within"), [(1.0, 0.03), (1.6, 0.03), (2.0, 0.03)])
def test_a_nose_is_seen_as_far_back_as_its_template_says(exponent, within):
    rng, offsets = np.random.default_rng(3), []
    for _ in range(40):
        centre, angle = 30 + rng.uniform(-0.5, 0.5, 2), rng.uniform(0, 2 * np.pi)
        luma = nose_picture(centre, angle, exponent)
        place = (*centre, np.cos(angle), np.sin(angle))
        floor = np.full_like(luma, 180)
        offsets.append(edge_offset((luma, floor), place, 60.0, np.empty((2, 17)))[0])
    lateral = np.array([0.0, 4.0, 8.0])
    axial = 10.0 - 1.5 * (lateral / 4.0) ** exponent
    loss = nose_edge_shift_by_blur(np.arctan2(lateral, axial), np.hypot(axial, lateral), 0.5)
    assert np.mean(offsets) == pytest.approx(-loss, abs=within)


def test_plane_agrees_with_independent_optics():
    design = picture_conditions_design(PICTURE_CONDITIONS_BY_NAME["middle"])
    trial = solve_trial(design, STRAIGHT)
    truth = frame_truth(design, trial)
    plane = swimming_plane_map(setup_of_design(design))
    m, px = (truth[k].reshape(-1, 2) for k in ("keypoints_m", "keypoints_px"))
    length_m = design.tank.robot.body_length_m
    assert np.abs(plane.body_lengths_to_pixels(m / length_m) - px).max() < 0.06
    assert np.abs(plane.pixels_to_body_lengths(px) * length_m - m).max() < 2e-4


@pytest.mark.parametrize("lens", ["pinhole", "fisheye"])
def test_the_plane_is_as_near_as_it_says_whatever_the_lens(lens):
    design = replace(
        picture_conditions_design(PICTURE_CONDITIONS_BY_NAME["middle"]),
        camera=gopro_like_camera(lens),
    )
    setup = setup_of_design(design)
    x, y = np.meshgrid(np.linspace(0.03, 2.55, 41), np.linspace(0.02, 1.57, 29))
    places = np.column_stack([x.ravel(), y.ravel()])
    plane = swimming_plane_map(setup)
    seen = pool_to_pixels(
        pool_camera(setup), np.column_stack([places, np.full(len(places), -0.04)])
    )
    length_m = setup.robot.body_length_m
    assert np.abs(plane.body_lengths_to_pixels(places / length_m) - seen).max() < 0.06
    assert np.abs(plane.pixels_to_body_lengths(seen) * length_m - places).max() < 2e-4


def dark_bar_picture() -> tuple[np.ndarray, np.ndarray]:
    """Luma and floor of a dark bar 4 px wide, 40 px long to the right of (60, 60)."""
    floor = np.full((120, 200), 180, np.uint8)
    luma = floor.copy()
    luma[58:62, 60:100] = 60
    return luma, floor


def test_a_tail_is_seen_to_end_where_it_does():
    found = tail_length.py_func(dark_bar_picture(), np.array([60.0, 60.0]), 0.0, 38.0, 60.0)
    assert found == pytest.approx(40.0, abs=1.0)


@pytest.mark.parametrize("back", [0.0, np.pi, np.pi / 2])
@pytest.mark.parametrize("base", [(-30, 40), (199, 60), (60, 119), (np.nan, 60), (15, 60)])
def test_a_tail_at_the_pictures_border_has_no_length_and_reads_nothing_beyond(base, back):
    found = tail_length.py_func(dark_bar_picture(), np.array(base, dtype=float), back, 38.0, 60.0)
    assert np.isnan(found)


def test_median_is_exact():
    images = np.random.default_rng(2).integers(0, 256, (7, 40, 60)).astype(np.uint8)
    np.testing.assert_array_equal(median_image(images), np.median(images, axis=0).astype(np.uint8))


@pytest.mark.parametrize("rows", [ROWS_PER_STRIP - 1, ROWS_PER_STRIP, 2 * ROWS_PER_STRIP + 3])
def test_ranked_pictures_are_those_of_a_sorted_stack(rows):
    images = list(np.random.default_rng(rows).integers(0, 256, (6, rows, 17), dtype=np.uint8))
    before = [image.copy() for image in images]
    found = grey_level_quantiles(images, 0.0, 0.4, 1.0)
    np.testing.assert_array_equal(found, np.sort(np.stack(before), axis=0)[[0, 2, 5]])
    np.testing.assert_array_equal(images, before)


def test_median_of_what_is_seen_is_numpys():
    rng = np.random.default_rng(3)
    values = rng.normal(size=(7, 40))
    values[rng.random(values.shape) < 0.4] = np.nan
    values[:, 5], values[1:, 6] = np.nan, np.nan
    seen = np.isfinite(values).any(axis=0)
    found = nan_median(values)
    np.testing.assert_array_equal(found[seen], np.nanmedian(values[:, seen], axis=0))
    assert np.isnan(found[~seen]).all()


@pytest.mark.parametrize("count", [1, 4, 9, 40, 200])
def test_a_few_frames_from_all_of_a_film(count):
    film = [Frame(i, i / 30, np.full((4, 4), i % 256, np.uint8)) for i in range(count)]
    few = sample_frames(iter(film), 5)
    assert 1 <= len(few) <= 5
    assert few[0].index == 0
    if count > 40:
        assert max(b.index - a.index for a, b in pairwise(few)) < 0.5 * count


def test_resting_body_is_bridged():
    pool = np.full((300, 400), 180, np.uint8)
    cv2.ellipse(pool, (200, 150), (60, 14), 20, 0, 360, 50, -1)
    assert without_static_robot(pool, 30.0).min() > 150


def test_template_learns_the_half_widths_and_keeps_the_nose_at_the_heads_length():
    design = picture_conditions_design(PICTURE_CONDITIONS_BY_NAME["middle"])
    setup, trial = setup_of_design(design), trial_of_plan(design.plans[1])
    start = initial_template(setup.robot, trial, 0.103, 60.0)
    visible = start.visible_stations()
    shift = np.full((4, len(visible)), np.nan)
    shift[:, visible] = 0.006
    wider = with_learned_outline(start, shift, np.full(shift.shape, 70.0))
    assert np.allclose(wider.half[5:-5], start.half[5:-5] + 0.006, atol=1.2e-3)
    assert wider.radii[0] == pytest.approx(start.radii[0], abs=1e-9)
    points, normals, part, skin = wider.outline_arrays()
    assert np.allclose(np.hypot(*normals.T), 1.0)
    assert points[part == 0, 0].max() == pytest.approx(
        trial.head_length_m / setup.robot.body_length_m
    )
    assert np.all(skin[2:-2] == 70.0)
    blurred = with_learned_outline(start, shift, np.full(shift.shape, 70.0), blur_bl=0.003)
    loss = nose_edge_shift_by_blur(start.angles, wider.radii, 0.003)
    assert wider.radii[0] - blurred.radii[0] == pytest.approx(loss, rel=0.1)
    assert len(points) == len(skin) == len(part) == wider.visible_stations().sum()


@pytest.mark.parametrize(("hidden", "made_again"), [(2, False), (3, True)])
def test_background_is_made_again_where_the_robot_hides_more_than_a_quarter_of_the_frames(
    monkeypatch, hidden, made_again
):
    """Of eight frames; the robot stands at one place in so many, and elsewhere in the others."""
    columns = [0] * hidden + list(range(4, 4 * (9 - hidden), 4))
    frames = [SimpleNamespace(luma=np.full((4, 40), 100, np.uint8)) for _ in columns]
    for frame, column in zip(frames, columns, strict=True):
        frame.luma[:, column : column + 4] = 20
    outline = SimpleNamespace(
        samples=list(zip(frames, columns, strict=True)),
        template=SimpleNamespace(half=np.ones(3)),
    )
    scene = SimpleNamespace(floor=np.full((4, 40), 50, np.uint8))
    monkeypatch.setattr(
        ghost_removal,
        "robot_mask",
        lambda column, *_: ((slice(0, 4), slice(column, column + 4)), np.ones((4, 4), np.uint8)),
    )
    found = ghost_removal.background_without_robot(outline, scene)
    assert (found is not None) is made_again
    if made_again:
        assert np.all(found[:, :4] == 100)


def test_what_hides_the_floor_is_left_out_of_its_median():
    rng = np.random.default_rng(4)
    stack = rng.integers(0, 256, (5, 20, 30)).astype(np.uint8)
    hidden = (rng.random(stack.shape) < 0.4).astype(np.uint8)
    floor = np.full((20, 30), 7, np.uint8)
    _write_unhidden_median(stack, hidden, floor)
    seen = np.where(hidden, np.nan, stack.astype(float))
    some = (hidden.sum(axis=0) > 0) & (hidden.sum(axis=0) < 5)
    assert np.abs(floor[some] - np.nanmedian(seen[:, some], axis=0)).max() <= 0.5
    assert np.all(floor[~some] == 7)

"""Wrong lens, refraction left out, wrong depth: what they do over the pool, by exact optics."""

from __future__ import annotations

import inspect
from dataclasses import asdict, replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bluekoi.camera import (
    Lens,
    PoolCamera,
    camera_from_corners,
    map_to_pool,
    pool_camera,
    pool_to_pixels,
)
from bluekoi.camera.camera_error_displacement import camera_error_field_coefficients
from bluekoi.camera.resection import pool_rectangle
from bluekoi.errors import InputError
from bluekoi.measurement import lens_error, scale_error, uncorrected_refraction
from bluekoi.model import trial_system
from bluekoi.model.simulation import constants_of_robot_trial
from bluekoi.observation import camera_error_inputs
from bluekoi.observation.trial_camera_errors import POOL_DIMENSION_ERROR_CONSTANTS
from bluekoi.study import StudySettings
from paper_robot import PAPER_SETUP

DEPTH_M, WATER = 0.06, 1.333
CORNERS_M = pool_rectangle(2.6, 1.6, 0.0)
GRID_M = np.array([(x, y) for x in np.linspace(0.2, 2.4, 12) for y in np.linspace(0.2, 1.4, 7)])


def lens_with_k1(k1: float = -0.06) -> Lens:
    matrix = np.array([[916.0, 0, 958], [0, 917, 544], [0, 0, 1]])
    return Lens("pinhole", matrix, np.array([k1, 0.012, 4e-4, -3e-4, -0.002]), (1920, 1080))


def tilted_camera(index: float = WATER) -> PoolCamera:
    """2 m up, a hand off the middle, leaning by two degrees."""
    turn = Rotation.from_rotvec([0.03, -0.02, 0.01]).as_matrix() @ np.diag([1.0, -1.0, -1.0])
    shift = -turn @ np.array([1.4, 0.75, 2.0])
    blank = PoolCamera(
        lens_with_k1().size_px,
        np.zeros((4, 2)),
        CORNERS_M,
        index,
        np.zeros((4, 2)),
        1.0,
        lens_with_k1(),
        turn,
        shift,
    )
    return camera_from_corners(lens_with_k1(), pool_to_pixels(blank, CORNERS_M), CORNERS_M, index)


def stated_setup(*, k1: float = -0.06, index: float = WATER) -> StudySettings:
    given = {
        "image_size_px": [1920, 1080],
        "matrix": lens_with_k1().matrix.tolist(),
        "distortion": lens_with_k1(k1).distortion.tolist(),
        "pool_corners_px": tilted_camera().corners_px.tolist(),
    }
    reported = PAPER_SETUP.model_dump() | {"camera": given, "water": {"refractive_index": index}}
    reported["robot"]["keypoint_depth_m"] = DEPTH_M
    return StudySettings.model_validate(reported)


CORE_CENTRE_CONSTANTS = {"cpsi": 1.0, "spsi": 0.0, "ahead": 0.0}
"""What is seen is the core's centre itself."""


def fitted_displacements(
    observe, constants: dict[str, float], k: float, seen: np.ndarray
) -> np.ndarray:
    """Displacements by an effect at the strength that comes nearest to those seen."""
    unit = np.array(
        [observe(x, y, **CORE_CENTRE_CONSTANTS, **constants, k=k)[:2] for x, y in GRID_M]
    )
    return unit * np.sum(unit * seen) / np.sum(unit * unit)


def named_constants(setup: StudySettings, names: tuple[str, ...]) -> dict[str, float]:
    given = asdict(camera_error_inputs(setup)) | {
        "L_pool": setup.pool.length_m,
        "W_pool": setup.pool.width_m,
    }
    return {name: given[name] for name in names}


def unexplained_share(model: np.ndarray, seen: np.ndarray) -> float:
    return float(np.sqrt(np.sum((model - seen) ** 2) / np.sum(seen**2)))


@pytest.mark.parametrize("off", [-0.05, 0.03])
def test_a_wrong_lens_moves_places_as_its_candidate_says(off):
    pixels = pool_to_pixels(
        tilted_camera(), np.column_stack([GRID_M, np.full(len(GRID_M), -DEPTH_M)])
    )
    wrong = camera_from_corners(
        lens_with_k1(-0.06 + off), tilted_camera().corners_px, CORNERS_M, WATER
    )
    seen = map_to_pool(wrong, pixels, DEPTH_M) - GRID_M
    given = named_constants(
        stated_setup(k1=-0.06 + off), ("x_lens", "y_lens", "Q_lens", "ax_lens", "ay_lens")
    )
    radial = given | {"q": 1.0, "p_x": 0.0, "p_y": 0.0}
    assert (
        unexplained_share(fitted_displacements(lens_error.observe, radial, 0.01, seen), seen) < 0.06
    )


def test_a_lens_out_of_line_moves_places_as_its_candidate_says():
    """Tangential distortion whose tilt the pose makes up for."""
    pixels = pool_to_pixels(
        tilted_camera(), np.column_stack([GRID_M, np.full(len(GRID_M), -DEPTH_M)])
    )
    right = lens_with_k1(-0.06)
    bent = replace(right, distortion=right.distortion + np.array([0, 0, 0.004, 0, 0]))
    wrong = camera_from_corners(bent, tilted_camera().corners_px, CORNERS_M, WATER)
    seen = map_to_pool(wrong, pixels, DEPTH_M) - GRID_M
    given = named_constants(
        stated_setup(), ("x_lens", "y_lens", "Q_lens", "ax_lens", "ay_lens")
    ) | {"q": 1.0}
    names = ({"k": 1.0}, {"p_x": 1.0}, {"p_y": 1.0})
    still = {"k": 0.0, "p_x": 0.0, "p_y": 0.0}
    units = [
        np.array(
            [
                lens_error.observe(x, y, **CORE_CENTRE_CONSTANTS, **given, **(still | unit))[:2]
                for x, y in GRID_M
            ]
        ).ravel()
        for unit in names
    ]
    strengths = np.linalg.lstsq(np.array(units).T, seen.ravel(), rcond=None)[0]
    assert unexplained_share(strengths @ np.array(units), seen.ravel()) < 0.15
    assert abs(strengths[2]) > 5 * abs(strengths[1])


@pytest.mark.parametrize("index", [1.0, 1.1, WATER])
def test_refraction_left_out_and_a_wrong_depth_move_places_as_their_candidate_says(index):
    """Left out: index 1 is stated, or one of no liquid. Else keypoints lie 30 mm too deep."""
    depth = DEPTH_M + (0.03 if index == WATER else 0.0)
    pixels = pool_to_pixels(
        tilted_camera(), np.column_stack([GRID_M, np.full(len(GRID_M), -depth)])
    )
    seen = map_to_pool(tilted_camera(index), pixels, DEPTH_M) - GRID_M
    given = named_constants(stated_setup(index=index), ("x_cam", "y_cam", "bend"))
    given |= {"q": 1.0, "d": 0.0, "session_place": 0.5}
    assert np.hypot(given["x_cam"] - 1.4, given["y_cam"] - 0.75) < 0.01
    assert (
        unexplained_share(
            fitted_displacements(uncorrected_refraction.observe, given, 0.01, seen), seen
        )
        < 0.03
    )


@pytest.mark.parametrize("index", [WATER, 1.0])
@pytest.mark.parametrize("depth_m", [0.0, 0.02, DEPTH_M, 0.3])
def test_refraction_moves_no_keypoint_between_surface_and_floor_by_more_than_its_range(
    index, depth_m
):
    """The range ends where keypoints lie on the floor, or above the surface by 5 % of the body."""
    low, high = camera_error_field_coefficients(stated_setup(index=index)).inward_shift_range
    near = np.array([1.4, 0.75]) + 0.05 * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    places = np.column_stack([near, np.full(len(near), -depth_m)])
    seen = map_to_pool(tilted_camera(index), pool_to_pixels(tilted_camera(), places), DEPTH_M)
    spread = np.linalg.norm(seen - seen.mean(axis=0), axis=1).mean() / 0.05
    assert low <= 1.0 - spread <= high
    assert low < 0 < high
    if depth_m == 0.3:  # the floor of this pool
        assert 1.0 - spread == pytest.approx(high, rel=0.03)


def test_the_search_for_refraction_keeps_within_what_surface_and_floor_allow():
    setup = stated_setup()
    constants = constants_of_robot_trial(setup, 0.12, view=camera_error_inputs(setup))
    strength = trial_system(constants).effect("uncorrected_refraction").parameters[0]
    assert (strength.lower, strength.upper) == pytest.approx(
        camera_error_field_coefficients(setup).inward_shift_range
    )
    unknown = constants_of_robot_trial(PAPER_SETUP, 0.12, view=camera_error_inputs(PAPER_SETUP))
    strength = trial_system(unknown).effect("uncorrected_refraction").parameters[0]
    assert (strength.lower, strength.upper) == (-0.05, 0.05)


def test_a_homography_is_taken_for_a_camera_over_the_middle():
    assert camera_error_field_coefficients(PAPER_SETUP).below_m == (1.3, 0.8)
    assert camera_error_field_coefficients(PAPER_SETUP).bend_1_m2 == 0.0
    assert camera_error_field_coefficients(PAPER_SETUP).lens_rest_m2 == pytest.approx(
        1.3**2 + 0.8**2
    )


def test_corners_that_fit_no_pose_are_seen_from_above_the_middle():
    setup = stated_setup()
    a, b, c, d = setup.camera.pool_corners_px
    crossed = setup.camera.model_copy(update={"pool_corners_px": (a, c, b, d)})
    with pytest.raises(InputError):
        pool_camera(setup.model_copy(update={"camera": crossed}))
    assert camera_error_field_coefficients(
        setup.model_copy(update={"camera": crossed})
    ).below_m == (
        1.3,
        0.8,
    )


@pytest.mark.parametrize("effect", [scale_error, uncorrected_refraction])
def test_an_error_that_grows_is_absent_in_the_first_trial_and_twice_its_mean_in_the_last(effect):
    names = ("L_pool", "W_pool", "x_cam", "y_cam", "bend", *POOL_DIMENSION_ERROR_CONSTANTS)
    known = named_constants(stated_setup(), names) | {"k": 0.01, "q": 1.0, "a": 0.0}
    asked = inspect.signature(effect.observe).parameters

    def displaced(session_place: float, d: float) -> np.ndarray:
        given = known | CORE_CENTRE_CONSTANTS | {"session_place": session_place, "d": d}
        given |= {"x": 0.7, "y": 0.4}
        return np.array(effect.observe(**{name: given[name] for name in asked}))

    assert displaced(0.0, 1.0) == pytest.approx(0.0)
    assert displaced(1.0, 1.0) == pytest.approx(2.0 * displaced(0.5, 0.0))
    assert displaced(0.0, -1.0) == pytest.approx(2.0 * displaced(0.5, 0.0))


@pytest.mark.parametrize(("sides", "a"), [((1.04, 1.0), 1.0), ((1.0, 1.04), -1.0)])
def test_a_side_stated_wrong_changes_the_scale_of_both_and_tilts_the_camera(sides, a):
    """With a known lens; the places are compared but for a shift, which no motion shows."""
    true = tilted_camera()
    pixels = pool_to_pixels(true, np.column_stack([GRID_M, np.full(len(GRID_M), -DEPTH_M)]))
    stated = pool_rectangle(2.6 * sides[0], 1.6 * sides[1], 0.0)
    wrong = camera_from_corners(lens_with_k1(), pool_to_pixels(true, CORNERS_M), stated, WATER)
    seen = map_to_pool(wrong, pixels, DEPTH_M) - GRID_M
    given = named_constants(stated_setup(), ("L_pool", "W_pool", *POOL_DIMENSION_ERROR_CONSTANTS))
    given |= {"a": a, "d": 0.0, "session_place": 0.5}
    found = np.array([scale_error.observe(x, y, **CORE_CENTRE_CONSTANTS, **given, k=0.02)[:2]
                      for x, y in GRID_M])  # fmt: skip
    off = seen - found
    off -= off.mean(axis=0)
    assert np.abs(off).max() < 0.03 * np.abs(seen - seen.mean(axis=0)).max()


@pytest.mark.parametrize(
    ("effect", "names"),
    [(scale_error, ("L_pool", "W_pool", *POOL_DIMENSION_ERROR_CONSTANTS)),
     (uncorrected_refraction, ("x_cam", "y_cam", "bend")),
     (lens_error, ("x_lens", "y_lens", "Q_lens", "ax_lens", "ay_lens"))],
)  # fmt: skip
def test_keypoints_placed_back_from_the_nose_are_displaced_as_the_nose_is(effect, names):
    forms = {
        lens_error: {"q": 1.0, "p_x": 0.01, "p_y": -0.02},
        scale_error: {"a": 0.3, "d": 0.5, "session_place": 0.8},
        uncorrected_refraction: {"q": 0.7, "d": 0.5, "session_place": 0.8},
    }
    given = named_constants(stated_setup(), names) | {"k": 0.02} | forms.get(effect, {})
    c, s, ahead = np.cos(2.1), np.sin(2.1), 0.15
    back = effect.observe(0.7, 0.4, c, s, ahead=ahead, **given)
    assert back == pytest.approx(
        effect.observe(0.7 + ahead * c, 0.4 + ahead * s, **CORE_CENTRE_CONSTANTS, **given)
    )
    assert back != pytest.approx(effect.observe(0.7, 0.4, **CORE_CENTRE_CONSTANTS, **given))

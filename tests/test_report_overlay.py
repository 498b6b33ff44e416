"""Overlay films: the right pixels at the right time, in a file that browsers play."""

from __future__ import annotations

import av
import numpy as np
import pytest
from exact_campaign import exact_campaign, exact_setup

from bluekoi.camera import pool_camera
from bluekoi.campaign import Campaign
from bluekoi.data import Frame, Keypoints
from bluekoi.report.overlay import (
    overlay_frame_rate,
    projected_overlay_paths,
    write_overlay,
    write_trial_overlay,
)
from bluekoi.report.overlay_frame import (
    AFTER_BGR,
    BEFORE_BGR,
    KEYPOINT_BGR,
    MEASURED_BGR,
    OverlayContent,
    OverlayPath,
    annotated_frame,
    empty_pool_image,
)

STRIP_HEIGHT_PX = 40
SCALE = 640 / 1920


@pytest.fixture(scope="module")
def overlay_campaign() -> Campaign:
    return exact_campaign(powers=(75,))


def film_pixel(x_m: float, y_m: float) -> tuple[int, int]:
    """Row and column in the film of a pool point: 500 px a metre in the raw frame."""
    return (
        STRIP_HEIGHT_PX + round(SCALE * (930 - 500 * y_m)),
        round(SCALE * (360 + 500 * x_m)),
    )


def has_colour_near(picture: np.ndarray, at: tuple[int, int], colour: tuple[int, int, int]) -> bool:
    """Whether a pixel within 1 px of a place has about the colour."""
    row, column = at
    patch = picture[row - 1 : row + 2, column - 1 : column + 2].astype(int)
    return bool((np.abs(patch - np.array(colour)).max(axis=2) < 40).any())


def test_paths_are_drawn_where_the_camera_sees_them(overlay_campaign):
    camera = pool_camera(exact_setup(), (1920, 1080))
    track = overlay_campaign.tracks["T02"]
    shift = {"time_s": track.time_s}
    for prefix, offset in (("joint", 0.1), ("extended", -0.1)):
        shift |= {f"{prefix}_x_m": track.x_m + offset, f"{prefix}_y_m": track.y_m}
    lines = projected_overlay_paths(camera, track, shift, 0.0)
    scene = OverlayContent("T02", (1920, 1080), lines, background=empty_pool_image(camera, 640))
    picture = annotated_frame(scene.background.copy(), scene, float(track.time_s[60]), SCALE)
    x, y = track.x_m[40], track.y_m[40]
    assert [line.name for line in lines] == ["measured path", "model after", "model before"]
    assert has_colour_near(picture, film_pixel(x, y), MEASURED_BGR)
    assert has_colour_near(picture, film_pixel(x - 0.1, y), AFTER_BGR)
    ends = track.x_m[60], track.y_m[60]
    assert has_colour_near(picture, film_pixel(ends[0] + 0.1, ends[1]), BEFORE_BGR)
    assert not has_colour_near(picture, film_pixel(track.x_m[80], track.y_m[80]), MEASURED_BGR)


def test_dashes_leave_gaps_and_keep_to_the_line():
    time = np.linspace(0, 1, 50)
    way = np.column_stack([np.linspace(300, 1500, 50), np.full(50, 540.0)])
    scene = OverlayContent(
        "x", (1920, 1080), (OverlayPath("model before", time, way, BEFORE_BGR, dashed=True),)
    )
    picture = annotated_frame(np.zeros((360, 640, 3), np.uint8), scene, 1.0, SCALE)
    drawn = (picture[STRIP_HEIGHT_PX + 180, 100:500] > 60).any(axis=1)
    assert 0.35 < drawn.mean() < 0.8
    assert np.abs(np.diff(drawn.astype(int))).sum() > 20
    assert not picture[STRIP_HEIGHT_PX + 190 :].any()


def test_only_confident_keypoints_of_the_moment_are_drawn():
    xy = np.array([[[600.0, 300.0], [900.0, 600.0]], [[700.0, 300.0], [np.nan, np.nan]]])
    found = Keypoints(
        np.array([0.0, 1.0]), ("head_tip", "hinge"), xy, np.array([[0.99, 0.2], [0.99, 0.9]]),
        np.full((2, 2, 2, 2), np.nan),
    )  # fmt: skip
    scene = OverlayContent("x", (1920, 1080), (), keypoints=found)
    dark = np.zeros((360, 640, 3), np.uint8)
    first = annotated_frame(dark.copy(), scene, 0.0, SCALE)
    assert has_colour_near(first, (STRIP_HEIGHT_PX + 100, 200), KEYPOINT_BGR)
    assert not has_colour_near(first, (STRIP_HEIGHT_PX + 200, 300), KEYPOINT_BGR)
    assert has_colour_near(
        annotated_frame(dark.copy(), scene, 1.0, SCALE), (STRIP_HEIGHT_PX + 100, 233), KEYPOINT_BGR
    )
    assert not annotated_frame(dark.copy(), scene, 0.5, SCALE)[STRIP_HEIGHT_PX:].any()


def test_a_keypoint_study_is_drawn_on_the_empty_pool(overlay_campaign, tmp_path):
    path = tmp_path / "T02.mp4"
    count, first_s = write_trial_overlay(overlay_campaign, "T02", tmp_path, path)
    assert not (tmp_path / "keypoints").exists()
    with av.open(str(path)) as film:
        stream = film.streams.video[0]
        pictures = [frame.to_ndarray(format="bgr24") for frame in film.decode(video=0)]
        assert stream.codec_context.name == "h264"
        assert stream.codec_context.pix_fmt == "yuv420p"
        assert float(stream.average_rate) == pytest.approx(30, rel=1e-3)
    assert count == len(pictures) == 90
    assert first_s == overlay_campaign.tracks["T02"].time_s[0]
    assert pictures[0].shape == (400, 640, 3)
    rim = pictures[0][film_pixel(1.3, 0.0)]
    assert np.all(rim > 180)
    track = overlay_campaign.tracks["T02"]
    assert has_colour_near(pictures[-1], film_pixel(track.x_m[-40], track.y_m[-40]), MEASURED_BGR)
    assert not has_colour_near(
        pictures[10], film_pixel(track.x_m[-40], track.y_m[-40]), MEASURED_BGR
    )


def test_frames_keep_their_times(tmp_path):
    grey = np.full((1080, 1920), 90, np.uint8)
    times = [2.0, 2.1, 2.2, 2.6, 2.601, 2.7]
    film = [Frame(i, t, grey) for i, t in enumerate(times)]
    count = write_overlay(tmp_path / "a.mp4", OverlayContent("x", (1920, 1080), ()), film, fps=10.0)
    assert count == 8  # 2.0 to 2.7 at 10 a second, the gap filled, the double left out
    assert overlay_frame_rate(np.arange(5) / 59.94) == 30.0
    assert overlay_frame_rate(np.arange(5) / 24.0) == pytest.approx(24.0)

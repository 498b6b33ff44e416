"""Videos written for people to look at: right times, whole or not at all."""

from __future__ import annotations

import numpy as np
import pytest
from test_footage import FRAME_SIZE_PX, numbered_picture

from bluekoi.footage import encode_h264, frames, open_recording


def decoded_frames(path) -> list[float]:
    return [frame.time_s for frame in frames(open_recording([path]))]


@pytest.mark.parametrize("fps", [24.0, 29.97, 30.0, 59.94, 120.0])
def test_pictures_without_times_keep_the_rate(tmp_path, fps):
    assert (
        encode_h264(
            tmp_path / "o.mp4",
            (numbered_picture(i) for i in range(12)),
            fps=fps,
            size=FRAME_SIZE_PX,
        )
        == 12
    )
    np.testing.assert_allclose(decoded_frames(tmp_path / "o.mp4"), np.arange(12) / fps, atol=2e-5)


def test_odd_sizes_and_colour_can_be_written(tmp_path):
    colour = np.zeros((97, 161, 3), np.uint8)
    colour[..., 2] = 200
    assert encode_h264(tmp_path / "c.mp4", [colour] * 3, fps=30, size=(161, 97)) == 3
    recording = open_recording([tmp_path / "c.mp4"])
    assert recording.size_px == (160, 96)
    red = next(iter(frames(recording, colour=True))).bgr[40, 80]
    assert red[2] > 150
    assert red[0] < 60


def test_where_a_picture_fails_nothing_is_left(tmp_path):
    def broken():
        yield numbered_picture(0)
        raise ValueError("no second picture")

    with pytest.raises(ValueError, match="no second"):
        encode_h264(tmp_path / "o.mp4", broken(), fps=30, size=FRAME_SIZE_PX)
    assert list(tmp_path.iterdir()) == []


def test_overlay_video_can_be_played(tmp_path):
    path = tmp_path / "o.mp4"
    assert (
        encode_h264(path, (numbered_picture(i) for i in range(8)), fps=29.97, size=FRAME_SIZE_PX)
        == 8
    )
    data = path.read_bytes()
    assert data.index(b"moov") < data.index(b"mdat")
    recording = open_recording([path])
    assert recording.codec == "h264"
    assert recording.size_px == FRAME_SIZE_PX
    assert len(list(frames(recording))) == 8

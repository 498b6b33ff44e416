"""Time that a file tells wrongly: time-lapse, slow motion; and rates that it tells rightly."""

from __future__ import annotations

from fractions import Fraction

import av
import numpy as np
import pytest
from gopro_files import gpmf_payload, video_with_lens_mode
from test_footage import FRAME_SIZE_PX, frame_numbers, numbered_picture, write_video

from bluekoi.errors import InputError
from bluekoi.footage import frames, open_recording
from bluekoi.footage import gopro_telemetry as reported
from bluekoi.footage.gopro_telemetry import camera_seconds_per_footage_second


class IndexEntry:
    """An entry of a track's index, as the container gives it."""

    def __init__(self, pos: int, size: int) -> None:
        self.pos, self.size = pos, size


def test_the_cameras_clock_is_read_from_each_sensors_stream(tmp_path):
    body = gpmf_payload({"Accelerometer": 80_577, "Gyroscope": 80_600})
    (tmp_path / "p.bin").write_bytes(b"xx" + body + b"more")
    found = reported._sensor_timestamps(tmp_path / "p.bin", IndexEntry(2, len(body)))
    assert found == {"Accelerometer": 80_577, "Gyroscope": 80_600}
    assert reported._sensor_timestamps(tmp_path / "p.bin", IndexEntry(0, 2**30)) == {}
    assert reported._sensor_timestamps(tmp_path / "p.bin", IndexEntry(2, 9)) == {}


@pytest.mark.parametrize(("ran", "refused"), [(1.0003, False), (None, False), (10.0, True)])
def test_a_time_lapse_is_refused_unless_its_rate_is_given(tmp_path, monkeypatch, ran, refused):
    frames_at = [1001 * i for i in range(6)]
    path = write_video(tmp_path / "GX010001.MP4", frames_at, front=False)
    video_with_lens_mode(path, b"L")
    monkeypatch.setattr(
        "bluekoi.footage.recording.camera_seconds_per_footage_second", lambda _: ran
    )
    if not refused:
        assert open_recording([path]).frames_present == 6
        return
    with pytest.raises(InputError, match="time-lapse or TimeWarp") as caught:
        open_recording([path])
    assert "GX010001.MP4" in str(caught.value)
    assert open_recording([path], fps=3.0).fps == 3.0


def test_a_file_without_telemetry_gives_no_clock(tmp_path):
    assert (
        camera_seconds_per_footage_second(write_video(tmp_path / "a.mp4", [0, 1001, 2002])) is None
    )


@pytest.mark.recordings
def test_a_gopros_own_clock_agrees_with_its_footage(recordings):
    path = recordings / "gopro_clip" / "max-heromode.mp4"
    assert camera_seconds_per_footage_second(path) == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize(
    "rate", [Fraction(24000, 1001), Fraction(30000, 1001), Fraction(30), Fraction(60000, 1001)]
)
@pytest.mark.parametrize("codec", ["libx264", "libx265", "mpeg4"])
def test_rates_are_exact(tmp_path, rate, codec):
    """29.97 and 59.94 are 30000/1001 and 60000/1001, not 30 and 60."""
    path = tmp_path / "r.mp4"
    with av.open(str(path), "w", format="mp4") as out:
        stream = out.add_stream(codec, rate=rate)
        stream.width, stream.height, stream.pix_fmt = *FRAME_SIZE_PX, "yuv420p"
        stream.bit_rate = 8_000_000
        stream.options = {"x265-params": "log-level=none"} if "265" in codec else {"bf": "0"}
        for number in range(12):
            out.mux(
                stream.encode(av.VideoFrame.from_ndarray(numbered_picture(number), format="gray"))
            )
        out.mux(stream.encode(None))
    recording = open_recording([path])
    times = [frame.time_s for frame in frames(recording)]
    assert recording.nominal_fps == pytest.approx(float(rate), rel=1e-9)
    np.testing.assert_allclose(times, np.arange(12) / float(rate), atol=2e-5)
    assert frame_numbers(frames(recording)) == list(range(12))

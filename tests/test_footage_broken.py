"""Footage that is cut, empty, stretched or no footage at all."""

from __future__ import annotations

import struct
from types import SimpleNamespace

import av
import numpy as np
import pytest
from gopro_files import video_with_lens_mode
from test_footage import FRAME_SIZE_PX, STEADY_TIMES, numbered_picture, patched_box, write_video

from bluekoi.errors import InputError
from bluekoi.footage import encode_h264, frames, open_recording
from bluekoi.stages.keypoints import unreadable_frames_remark
from bluekoi.study import Trial


def test_cut_file_gives_its_readable_frames(tmp_path):
    path = write_video(tmp_path / "cut.mp4", STEADY_TIMES)
    data = path.read_bytes()
    path.write_bytes(data[: len(data) - 300])
    recording = open_recording([path])
    assert recording.frames_declared == 24
    assert 1 <= recording.frames_present < 24
    assert any("cut short" in remark and "24" in remark for remark in recording.remarks)
    assert abs(len(list(frames(recording))) - recording.frames_present) <= 1


def test_file_without_index_names_the_rescue(tmp_path):
    path = write_video(tmp_path / "dead.mp4", STEADY_TIMES, front=False)
    data = path.read_bytes()
    path.write_bytes(data[: data.rindex(b"moov") - 4])
    with pytest.raises(InputError, match="untrunc"):
        open_recording([path])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "0 bytes"),
        (b"time_s,angle_deg\n0,1\n" * 20, "a text file"),
        (bytes(range(256)) * 40, "no readable video"),
        (b"\0\0\0\x08ftyp", "without its index"),
    ],
)
def test_what_is_no_video_is_reported(tmp_path, content, message):
    path = tmp_path / "x.mp4"
    path.write_bytes(content)
    with pytest.raises(InputError, match=message) as caught:
        open_recording([path])
    assert "x.mp4" in str(caught.value)


def test_a_codec_that_nobody_knows_is_reported(tmp_path):
    path = write_video(tmp_path / "odd.mp4", STEADY_TIMES[:4])
    data = path.read_bytes()
    assert b"avc1" in data
    path.write_bytes(data.replace(b"avc1", b"qqz9"))
    with pytest.raises(InputError, match="no video stream that can be decoded"):
        open_recording([path])


def test_missing_file(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        open_recording([tmp_path / "none.mp4"])


@pytest.mark.parametrize(("letter", "refused"), [(b"S", True), (b"H", True), (b"W", False)])
def test_stretched_lens_modes_are_refused(tmp_path, letter, refused):
    path = write_video(tmp_path / "s.mp4", STEADY_TIMES[:4], front=False)
    video_with_lens_mode(path, letter)
    if refused:
        with pytest.raises(InputError, match=r"SuperView|HyperView"):
            open_recording([path])
    else:
        assert open_recording([path]).frames_present == 4


def test_trimmed_file_is_remarked(tmp_path):
    path = write_video(tmp_path / "t.mp4", STEADY_TIMES)
    scale = av.open(str(path)).streams.video[0].time_base.denominator
    start = struct.pack(">i", scale * 10 * 1001 // 30000)
    recording = open_recording([patched_box(path, b"elst", 12, start)])
    assert any("trimmed" in remark for remark in recording.remarks)
    assert 13 <= len(list(frames(recording))) <= 15


def test_pictures_lost_in_the_midst_are_remarked():
    trial = Trial(
        trial_id="T01", source="a.mp4", power_pct=50, head_angle_deg=0, head_length_m=0.12
    )
    recording = SimpleNamespace(frames_present=90)
    time_s = np.arange(90) / 30.0
    assert unreadable_frames_remark(trial, recording, time_s) == ()
    (remark,) = unreadable_frames_remark(trial, recording, np.delete(time_s, slice(56, 88)))
    assert remark.startswith(
        "32 of 90 frames could not be read, the longest hole 1.10 s after 1.83"
    )
    part = trial.model_copy(update={"end_s": 2.0})
    assert unreadable_frames_remark(part, recording, time_s[:60]) == ()


def test_failed_overlay_leaves_nothing(tmp_path):
    def broken():
        yield numbered_picture(0)
        raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        encode_h264(tmp_path / "o.mp4", broken(), fps=30, size=FRAME_SIZE_PX)
    assert list(tmp_path.iterdir()) == []


def test_few_frames_of_a_trimmed_film_leave_the_rest_as_it_was(tmp_path):
    path = write_video(tmp_path / "t.mp4", STEADY_TIMES)
    scale = av.open(str(path)).streams.video[0].time_base.denominator
    patched_box(path, b"elst", 12, struct.pack(">i", scale * 10 * 1001 // 30000))
    recording = open_recording([path])
    plain = [frame.time_s for frame in frames(recording)]
    film = frames(recording)
    assert len(list(film.evenly_spaced(2))) == 2
    assert [frame.time_s for frame in film] == plain


@pytest.mark.parametrize(("suffix", "codec"), [("mkv", "libx264"), ("avi", "mpeg4")])
def test_a_cut_file_whose_index_lists_no_frames_is_counted(tmp_path, suffix, codec):
    path, rng = tmp_path / f"film.{suffix}", np.random.default_rng(1)
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=30)
        stream.width, stream.height, stream.pix_fmt = 160, 120, "yuv420p"
        for _ in range(60):
            noise = rng.integers(0, 255, (120, 160, 3), dtype=np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(noise, format="rgb24")))
        container.mux(stream.encode())
    whole = open_recording([path])
    assert (whole.frames_declared, whole.frames_present) == (60, 60)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    cut = open_recording([path])
    assert cut.frames_declared == 60
    assert 20 <= cut.frames_present <= 40
    assert any("cut short" in remark for remark in cut.remarks)
    assert len(list(frames(cut))) == cut.frames_present

"""Footage: true timestamps, chapters, broken files; and videos for the overlays."""

from __future__ import annotations

import struct
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
import pytest

from bluekoi.errors import InputError
from bluekoi.footage import frames, open_recording
from bluekoi.footage.frame_reading import evenly_spaced_frames
from bluekoi.footage.gopro_chapters import sort_chapters

FRAME_SIZE_PX = (160, 96)


def numbered_picture(number: int) -> np.ndarray:
    """A picture whose mean tells its number, with a bright top left corner."""
    image = np.full(FRAME_SIZE_PX[::-1], 40 + 4 * number, np.uint8)
    image[:24, :40] = 235
    return image


def write_video(
    path: Path,
    times: list[int],
    *,
    codec: str = "libx264",
    pix_fmt: str = "yuv420p",
    front: bool = True,
) -> Path:
    """A video whose frames are shown at `times` in units of 1/30000 s."""
    options = {"movflags": "faststart"} if front else {}
    with av.open(str(path), "w", format="mp4", options=options) as out:
        stream = out.add_stream(codec, rate=Fraction(30000, 1001))
        stream.width, stream.height, stream.pix_fmt = *FRAME_SIZE_PX, pix_fmt
        stream.codec_context.time_base = Fraction(1, 30000)
        stream.options = {"x265-params": "log-level=none"} if "265" in codec else {"bf": "0"}
        stream.codec_context.gop_size = 5
        for number, time in enumerate(times):
            frame = av.VideoFrame.from_ndarray(numbered_picture(number), format="gray")
            frame.pts, frame.time_base = time, Fraction(1, 30000)
            out.mux(stream.encode(frame))
        out.mux(stream.encode(None))
    return path


def patched_box(path: Path, name: bytes, offset: int, content: bytes) -> Path:
    """The file with bytes after the first box `name` replaced."""
    data = bytearray(path.read_bytes())
    at = data.index(name) + 4 + offset
    data[at : at + len(content)] = content
    path.write_bytes(bytes(data))
    return path


def stored_luma(image: np.ndarray) -> np.ndarray:
    """Luma of limited range that a grey picture becomes in the file."""
    return 16 + image.astype(float) * 219 / 255


def frame_numbers(film) -> list[int]:
    grey = [(float(np.median(frame.luma)) - 16) * 255 / 219 for frame in film]
    return [round((value - 40) / 4) for value in grey]


STEADY_TIMES = [1001 * i for i in range(24)]


def test_timestamps_are_those_of_the_container(tmp_path):
    recording = open_recording([write_video(tmp_path / "a.mp4", STEADY_TIMES)])
    times = [frame.time_s for frame in frames(recording)]
    assert recording.nominal_fps == pytest.approx(30000 / 1001)
    assert recording.frames_declared == recording.frames_present == 24
    np.testing.assert_allclose(times, np.arange(24) * 1001 / 30000, atol=1e-9)
    assert frame_numbers(frames(recording)) == list(range(24))


def test_variable_rate_keeps_each_frames_own_time(tmp_path):
    times = [0, 1001, 3003, 4004, 7007, 8008]
    recording = open_recording([write_video(tmp_path / "v.mp4", times)])
    found = [frame.time_s for frame in frames(recording)]
    np.testing.assert_allclose(found, np.array(times) / 30000, atol=1e-6)
    assert any("variable frame rate" in remark for remark in recording.remarks)


def test_given_rate_overrides_the_timestamps(tmp_path):
    recording = open_recording([write_video(tmp_path / "a.mp4", STEADY_TIMES)], fps=120.0)
    assert [f.time_s for f in frames(recording)][:3] == pytest.approx([0, 1 / 120, 2 / 120])
    assert any("replaces" in remark for remark in recording.remarks)


def test_part_of_a_recording(tmp_path):
    path = write_video(tmp_path / "a.mp4", STEADY_TIMES)
    recording = open_recording([path], start_s=0.2, end_s=0.4)
    times = [frame.time_s for frame in frames(recording)]
    assert min(times) >= 0.2
    assert max(times) <= 0.4
    assert len(times) == 6


def test_start_after_the_end_is_a_fault(tmp_path):
    with pytest.raises(InputError, match="start_s"):
        open_recording([write_video(tmp_path / "a.mp4", STEADY_TIMES)], start_s=60.0)


def test_chapters_are_joined_without_losing_time(tmp_path):
    late = write_video(tmp_path / "GX020042.MP4", STEADY_TIMES)
    early = write_video(tmp_path / "GX010042.MP4", STEADY_TIMES[:10])
    recording = open_recording([late, early])
    times = np.array([frame.time_s for frame in frames(recording)])
    assert [path.name for path in recording.paths] == ["GX010042.MP4", "GX020042.MP4"]
    np.testing.assert_allclose(np.diff(times), 1001 / 30000, atol=1e-4)
    assert len(times) == 34


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["GX010042.MP4", "GX030042.MP4"], "chapter 02 missing"),
        (["GX020042.MP4", "GX030042.MP4"], "chapter 01 missing"),
        (["GX010042.MP4", "GX020043.MP4"], "several recordings"),
        (["GX010042.MP4", "GX010042.MP4"], "named twice"),
        ([], "no file"),
    ],
)
def test_wrong_chapters_are_refused(names, message):
    with pytest.raises(InputError, match=message):
        sort_chapters([Path(name) for name in names])


def test_order_is_by_chapter_and_old_names_count(tmp_path):
    old = [Path("GP020007.MP4"), Path("GOPR0007.MP4"), Path("GP010007.MP4")]
    assert [p.name for p in sort_chapters(old)] == ["GOPR0007.MP4", "GP010007.MP4", "GP020007.MP4"]


def test_a_further_chapter_beside_it_is_remarked(tmp_path):
    path = write_video(tmp_path / "GX010042.MP4", STEADY_TIMES[:5])
    (tmp_path / "GX020042.MP4").write_bytes(b"x")
    (tmp_path / "GL010042.LRV").write_bytes(b"x")
    remarks = open_recording([path]).remarks
    assert any("GX020042.MP4" in remark and "LRV" not in remark for remark in remarks)


@pytest.mark.parametrize("degrees", [90, 180, 270])
def test_rotation_flag_is_applied_and_reported(tmp_path, degrees):
    cos, sin = {90: (0, 1), 180: (-1, 0), 270: (0, -1)}[degrees]
    one = 1 << 16
    matrix = struct.pack(">9i", cos * one, sin * one, 0, -sin * one, cos * one, 0, 0, 0, 1 << 30)
    path = patched_box(write_video(tmp_path / "r.mp4", STEADY_TIMES[:6]), b"tkhd", 40, matrix)
    recording = open_recording([path])
    shown = next(iter(frames(recording))).luma
    turned = np.rot90(numbered_picture(0), -degrees // 90)
    assert shown.shape == turned.shape == recording.size_px[::-1]
    assert np.mean(np.abs(shown - stored_luma(turned))) < 3
    assert any("turn of" in remark for remark in recording.remarks)
    assert any("camera matrix" in remark for remark in recording.remarks) == (degrees != 180)


def test_ten_bit_hevc_arrives_as_eight(tmp_path):
    path = write_video(tmp_path / "h.mp4", STEADY_TIMES[:6], codec="libx265", pix_fmt="yuv420p10le")
    recording = open_recording([path])
    frame = next(iter(frames(recording)))
    assert recording.codec == "hevc"
    assert frame.luma.dtype == np.uint8
    lit = frame.luma[4:20, 4:36].astype(float) - frame.luma[60:, 80:].mean()
    assert lit.mean() == pytest.approx((235 - 40) * 219 / 255, abs=3)
    with av.open(str(path)) as container:
        plane = next(container.decode(video=0)).planes[0]
    wide = np.frombuffer(plane, "<u2").reshape(plane.height, -1)[:, : FRAME_SIZE_PX[0]]
    np.testing.assert_array_equal(frame.luma, wide // 4)


def test_colour_only_when_asked(tmp_path):
    recording = open_recording([write_video(tmp_path / "a.mp4", STEADY_TIMES[:4])])
    assert next(iter(frames(recording))).bgr is None
    assert next(iter(frames(recording, colour=True))).bgr.shape == (*FRAME_SIZE_PX[::-1], 3)


@pytest.mark.parametrize("degrees", [0, 90])
def test_colours_can_be_reduced_by_the_decoder(tmp_path, degrees):
    recording = open_recording([write_video(tmp_path / "a.mp4", STEADY_TIMES[:2])])
    recording = replace(recording, rotation_deg=degrees)
    whole = next(iter(frames(recording, colour=True))).bgr
    size = (whole.shape[1] // 4, whole.shape[0] // 4)
    small = next(iter(frames(recording, colour=True, bgr_size=size))).bgr
    mean = cv2.resize(whole, size, interpolation=cv2.INTER_AREA)
    assert small.shape == (*size[::-1], 3)
    assert np.abs(small.astype(float) - mean).mean() < 2


def test_spread_gives_a_few_frames_from_everywhere(tmp_path):
    recording = open_recording([write_video(tmp_path / "a.mp4", STEADY_TIMES)])
    few = list(evenly_spaced_frames(recording, 3))
    assert [frame.time_s for frame in few] == pytest.approx(
        [0.0, 10 * 1001 / 30000, 20 * 1001 / 30000]
    )


def test_more_frames_are_taken_where_more_can_be_decoded_alone(tmp_path):
    recording = open_recording([write_video(tmp_path / "a.mp4", STEADY_TIMES)])
    assert len(list(evenly_spaced_frames(recording, 3, at_most=4))) == 4
    assert len(list(evenly_spaced_frames(recording, 3, at_most=9))) == 5  # key frames
    assert len(list(evenly_spaced_frames(recording, 2))) == 2


@pytest.mark.parametrize(("start_s", "end_s"), [(None, 0.25), (0.3, 0.55), (0.6, None)])
def test_a_few_frames_of_a_part_with_few_key_frames_are_spread_over_it(tmp_path, start_s, end_s):
    path = write_video(tmp_path / "a.mp4", STEADY_TIMES)
    part = open_recording([path], start_s=start_s, end_s=end_s)
    times = [frame.time_s for frame in evenly_spaced_frames(part, 4)]
    whole = [frame.time_s for frame in frames(part)]
    assert len(times) == 4
    assert (times[0], times[-1]) == (whole[0], pytest.approx(whole[-1], abs=2 / 30))


def test_a_few_frames_of_a_part_lie_in_it_where_fps_replaces_the_rate_of_the_file(tmp_path):
    path = write_video(tmp_path / "a.mp4", STEADY_TIMES)
    half_speed = open_recording([path], fps=15000 / 1001, start_s=0.6)
    few = frame_numbers(evenly_spaced_frames(half_speed, 3))
    assert len(few) == 3
    assert set(few) <= set(frame_numbers(frames(half_speed)))


@pytest.mark.parametrize("codec", ["libx264", "libx265", "mpeg4"])
def test_reordered_pictures_come_in_their_order(tmp_path, codec):
    """Files are opened without decoding, which must not cost the decoder its sense of order."""
    path = tmp_path / "b.mp4"
    with av.open(str(path), "w", format="mp4") as out:
        stream = out.add_stream(codec, rate=Fraction(30000, 1001))
        stream.width, stream.height, stream.pix_fmt = *FRAME_SIZE_PX, "yuv420p"
        stream.bit_rate = 8_000_000
        stream.options = {"x265-params": "log-level=none"} if "265" in codec else {"bf": "2"}
        for number in range(24):
            out.mux(
                stream.encode(av.VideoFrame.from_ndarray(numbered_picture(number), format="gray"))
            )
        out.mux(stream.encode(None))
    assert frame_numbers(frames(open_recording([path]))) == list(range(24))


def test_the_first_of_a_few_frames_is_the_first_picture(tmp_path):
    path = write_video(tmp_path / "a.mp4", STEADY_TIMES)
    recording = open_recording([path])
    decoded = next(iter(frames(recording))).luma
    assert recording.first_luma is not None
    np.testing.assert_array_equal(next(evenly_spaced_frames(recording, 3)).luma, decoded)
    late = open_recording([path], start_s=0.3)
    assert next(evenly_spaced_frames(late, 2)).time_s > 0.3


@pytest.mark.recordings
def test_gopro_clip_opens_with_true_timestamps(recordings):
    recording = open_recording([recordings / "gopro_clip" / "max-heromode.mp4"])
    times = np.array([frame.time_s for frame in frames(recording)])
    assert recording.nominal_fps == pytest.approx(30000 / 1001)
    assert len(times) == recording.frames_declared == 315
    np.testing.assert_allclose(np.diff(times), 1001 / 30000, atol=1e-6)


@pytest.mark.recordings
def test_true_variable_rate_and_its_constant_twin(recordings):
    folder = recordings / "ball_videos"
    true = [f.time_s for f in frames(open_recording([folder / "BallTossOut.mov"]))]
    twin = [f.time_s for f in frames(open_recording([folder / "BallTossOut.mp4"]))]
    assert len(true) == len(twin) == 32
    assert np.ptp(np.diff(true)) == pytest.approx(8 / 600, abs=1e-6)
    assert np.ptp(np.diff(twin)) < 1e-6


def test_a_film_gives_all_frames_after_a_few_and_again(tmp_path):
    film = frames(open_recording([write_video(tmp_path / "a.mp4", STEADY_TIMES)]))
    few = [frame.time_s for frame in film.evenly_spaced(3)]
    first = [(frame.time_s, int(frame.luma.sum())) for frame in film]
    second = [(frame.time_s, int(frame.luma.sum())) for frame in film]
    assert len(few) == 3
    assert len(first) == 24
    assert first == second

"""A recording, opened and checked before a single trial depends on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from pathlib import Path

from ..errors import InputError, input_error
from .gopro_chapters import gopro_chapter, sort_chapters, unlisted_chapters
from .gopro_telemetry import camera_seconds_per_footage_second
from .luma_planes import Luma
from .mp4_boxes import ContainerBoxes, read_container_boxes
from .video_probe import VideoProperties, video_properties

MAX_TELEMETRY_CLOCK_DIFFERENCE_SHARE = 0.02
"""Relative difference of two clocks of a recording above which it is reported."""
IMAGE_SEQUENCE_CODEC = "images"
"""Codec of a recording whose frames are picture files."""
GOPRO_STRETCHED_MODES = {"S": "SuperView", "H": "HyperView"}
"""Code of a GoPro's lens mode -> name, for those that stretch the picture by an unknown law."""


@dataclass(frozen=True)
class Recording:
    """One recording: its files in order and what they hold.

    size_px: (width, height) as shown, after rotation. frames_declared: by the files' indexes;
    frames_present: whose bytes are there. nominal_fps: mean rate of the container. fps: rate that
    overrides the timestamps, None to keep them. offset_s: where each file begins on the
    recording's clock. start_s, end_s: the part to use. rotation_deg: counter-clockwise turn
    applied to the stored picture. key_stamps: timestamps of the key frames of each file, in units
    of time_base_s. first_luma: brightness of the first key frame as stored,
    where it is known. picture_numbers: which frame each picture file is, of a recording of these.
    remarks: what a person should know of the recording; of one file without its name.
    """

    paths: tuple[Path, ...]
    size_px: tuple[int, int]
    codec: str
    frames_declared: int
    frames_present: int
    nominal_fps: float
    offset_s: tuple[float, ...]
    rotation_deg: int = 0
    fps: float | None = None
    start_s: float | None = None
    end_s: float | None = None
    remarks: tuple[str, ...] = ()
    picture_numbers: tuple[int, ...] = ()
    key_stamps: tuple[tuple[int, ...], ...] = ()
    time_base_s: float = 1.0
    first_luma: Luma | None = field(default=None, repr=False, compare=False)

    @property
    def duration_s(self) -> float:
        """Length of the whole recording by the number of its frames and their rate."""
        return self.frames_present / (self.fps or self.nominal_fps)

    @property
    def frame_count_in_part(self) -> int:
        """Number of the frames from start_s to end_s, by their rate."""
        end_s = min(self.end_s or self.duration_s, self.duration_s)
        return round((end_s - (self.start_s or 0.0)) * (self.fps or self.nominal_fps))


def open_recording(
    paths: Sequence[Path],
    *,
    fps: float | None = None,
    start_s: float | None = None,
    end_s: float | None = None,
) -> Recording:
    """Recording of one file, of the chapters of one recording in any order, or of pictures.

    Raises: InputError where a file is missing, empty, not a video, without its index, in a
    stretched lens mode or a time-lapse, of another size than its fellows, or where a chapter is
    missing.
    """
    from .image_sequence import all_are_images, open_image_sequence  # noqa: PLC0415  which needs `Recording`

    if all_are_images(paths):
        return open_image_sequence(paths, fps=fps, start_s=start_s, end_s=end_s)
    ordered = sort_chapters([Path(path) for path in paths])
    probes = [_probe_checked(path, fps) for path in ordered]
    _check_same_format(ordered, probes)
    first = probes[0]
    width, height = first.size_px
    turned = first.rotation_deg % 180 != 0
    recording = Recording(
        paths=ordered,
        size_px=(height, width) if turned else (width, height),
        codec=first.codec,
        frames_declared=sum(p.frames_declared for p in probes),
        frames_present=sum(p.frames_present for p in probes),
        nominal_fps=first.fps,
        offset_s=_chapter_starts_s(probes),
        rotation_deg=first.rotation_deg,
        fps=fps,
        start_s=start_s,
        end_s=end_s,
        remarks=_recording_remarks(ordered, probes, fps),
        key_stamps=tuple(p.key_stamps for p in probes),
        time_base_s=first.time_base_s,
        first_luma=first.first_luma,
    )
    _check_part_within_recording(recording, probes)
    return recording


def _probe_checked(path: Path, fps: float | None) -> VideoProperties:
    """Probe of one file that is worth decoding."""
    if not path.is_file():
        raise input_error(path, "", "no such file", "a video file")
    if path.stat().st_size == 0:
        remedy = "Copy it again from the card."
        raise input_error(path, "", "an empty file (0 bytes)", "a video", remedy)
    boxes = read_container_boxes(path)
    if boxes is not None and not boxes.has_index:
        raise _missing_index_error(path)
    result = video_properties(path, boxes)
    _check_lens_mode(path, boxes)
    _check_frame_rate(path, result, fps)
    if boxes is not None and boxes.gopro and fps is None:
        _check_telemetry_clock(path)
    return result


def _missing_index_error(path: Path) -> InputError:
    return input_error(
        path,
        "",
        "a video without its index (no moov): the recording stopped before the file was closed",
        "a complete mp4",
        "The pictures are still in it: copy the file, then `untrunc good.mp4 copy.mp4` with a good "
        "file of the same camera and mode rebuilds the index. Do not let the camera repair the "
        "only copy, it can overwrite data.",
    )


def _check_lens_mode(path: Path, boxes: ContainerBoxes | None) -> None:
    mode = boxes.gopro.get("VFOV", "") if boxes else ""
    if mode in GOPRO_STRETCHED_MODES:
        raise input_error(
            path,
            "lens mode",
            GOPRO_STRETCHED_MODES[mode],
            "Wide, Linear or Narrow",
            "This mode stretches the picture so that no lens model fits; film in Linear.",
        )


def _check_frame_rate(path: Path, found: VideoProperties, fps: float | None) -> None:
    captured = found.capture_fps
    if captured and fps is None and abs(captured / found.fps - 1) > 0.02:
        raise input_error(
            path,
            "frame rate",
            f"{captured:g} frames/s taken, {found.fps:g} shown (slow motion or time-lapse)",
            "pictures shown at the rate they were taken",
            f"Set fps to {captured:g} in trials.csv if that rate is true.",
        )


def _check_telemetry_clock(path: Path) -> None:
    """InputError if the clock in a GoPro's telemetry ran faster than the footage."""
    ran = camera_seconds_per_footage_second(path)
    if ran is not None and abs(ran - 1) > MAX_TELEMETRY_CLOCK_DIFFERENCE_SHARE:
        raise input_error(
            path,
            "frame rate",
            f"a time-lapse or TimeWarp ({ran:.3g} s on the camera's clock per second shown)",
            "pictures shown at the rate they were taken",
            "Film in video mode; or, if the true rate is known, set fps in trials.csv.",
        )


def _check_same_format(paths: tuple[Path, ...], probes: list[VideoProperties]) -> None:
    kinds = [(p.size_px, p.rotation_deg) for p in probes]
    for path, kind in zip(paths, kinds, strict=True):
        if kind != kinds[0]:
            raise input_error(
                path,
                "",
                f"{kind[0][0]}x{kind[0][1]} px turned by {kind[1]} degrees",
                f"{kinds[0][0][0]}x{kinds[0][0][1]} px turned by {kinds[0][1]}, as the first file",
            )


def _chapter_starts_s(probes: list[VideoProperties]) -> tuple[float, ...]:
    """Start of each chapter: the sum of the durations of those before it."""
    return tuple(accumulate((p.duration_s for p in probes[:-1]), initial=0.0))


def _check_part_within_recording(recording: Recording, probes: list[VideoProperties]) -> None:
    ends = sum(p.duration_s for p in probes)
    if recording.fps is not None:
        ends = recording.frames_present / recording.fps
    if recording.start_s is not None and ends > 0 and recording.start_s >= ends:
        raise input_error(
            recording.paths[0],
            "start_s",
            f"{recording.start_s:g} s in a recording of {ends:.2f} s",
            "a start inside the recording",
        )


def _recording_remarks(
    paths: tuple[Path, ...], probes: list[VideoProperties], fps: float | None
) -> tuple[str, ...]:
    found = [
        remark if len(paths) == 1 else f"{path.name}: {remark}"
        for path, p in zip(paths, probes, strict=True)
        for remark in p.remarks
    ]
    if others := unlisted_chapters(paths):
        found.append(
            f"{paths[0].name}: further chapters beside it are not used: {', '.join(others)}"
        )
    mark = gopro_chapter(paths[0])
    if mark is not None and mark[1] > 1:
        found.append(f"{paths[0].name} is chapter {mark[1]}: earlier chapters are not used")
    if fps is not None and abs(fps / probes[0].fps - 1) > 0.001:
        found.append(f"fps {fps:g} from trials.csv replaces the file's own {probes[0].fps:.6g}")
    return tuple(found)

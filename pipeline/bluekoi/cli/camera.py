"""`bluekoi calibrate` and `bluekoi pool`: the lens, and the corners of the pool."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .outputs import refuse_outputs_over_study_files
from .parameter_types import StudyName, TrialName
from .progress_notice import progress_notice

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..study import Study


CALIBRATION_SECONDS_PER_PICTURE = (
    1.0  # a photograph of 12 megapixels, its share of the fits included
)


@click.command()
@click.argument("images", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--pattern", default="9x6", show_default=True, help="Inner corners of the board.")
@click.option("--square-mm", default=25.0, show_default=True, help="Side of a square.")
@click.option(
    "--board", default="chessboard", show_default=True, help="Kind of board: chessboard or charuco."
)
@click.option("--model", default="auto", show_default=True, help="Lens model.",
              type=click.Choice(["auto", "pinhole", "fisheye"]))  # fmt: skip
@click.option("--out", default="camera.yaml", show_default=True, type=click.Path(path_type=Path),
              help="File for the section `camera:` of study.yaml.")  # fmt: skip
def calibrate(
    *, images: tuple[Path, ...], pattern: str, square_mm: float, board: str, model: str, out: Path
) -> None:
    """Calibrate the lens from photographs or videos of a board, or take a lens-profile json.

    The command writes two files: OUT with the section `camera:` for study.yaml, and a picture with
    the same name and the ending .png. The picture shows where the board appeared in the image, with
    the reprojection errors.
    """
    from ..camera.lens_calibration import calibrate_files  # noqa: PLC0415
    from ..errors import input_error  # noqa: PLC0415

    _refuse_overwriting(out, (".yaml", ".yml"), images)
    _refuse_overwriting(out.with_suffix(".png"), (".png",), images)
    if odd := next((path for path in images if path.exists() and not path.is_file()), None):
        raise input_error(odd, "", "no regular file", "pictures, videos or a lens profile")
    with progress_notice(
        f"calibrating from {len(images)} files", CALIBRATION_SECONDS_PER_PICTURE * len(images)
    ):
        found = calibrate_files(
            images, pattern=pattern, square_mm=square_mm, board=board, model=model, out=out
        )
    for remark in found.remarks:
        click.echo(remark)
    click.echo(f"{out}: {found.quality_text}")
    if [image.suffix.lower() for image in images] != [".json"]:
        click.echo(f"Drawn: {out.with_suffix('.png')}")


@click.command()
@click.argument("study", type=StudyName(path_type=Path))
@click.argument("frame", required=False, type=click.Path(path_type=Path))
@click.option(
    "--trial",
    "trial_id",
    type=TrialName(),
    help="Trial to take the frame from. Default: the first row of trials.csv with footage.",
)
@click.option("--out", default="pool.png", show_default=True, type=click.Path(path_type=Path),
              help="Picture to write.")  # fmt: skip
@click.pass_context
def pool(
    ctx: click.Context, study: Path, frame: Path | None, trial_id: str | None, out: Path
) -> None:
    """Draw the pool corners of STUDY on FRAME, and compare them with the pool edges in FRAME.

    FRAME is a picture or a video in the current folder or in STUDY. Without FRAME, the first frame
    of a trial is used. If study.yaml has no corners yet, the command draws ruled lines on the
    frame, from which the pixel coordinates of the corners can be read; study.yaml may then be
    incomplete. If study.yaml has corners, the exit code is 0 only if the edges of the pool are
    found with certainty and confirm these corners.
    """
    from ..camera.pixel_grid import frame_with_pixel_grid  # noqa: PLC0415
    from ..camera.pool_corner_check import pool_corners_picture  # noqa: PLC0415
    from ..study import (  # noqa: PLC0415
        lacks_pool_corners,
        load_incomplete_study,
        load_study,
        stated_image_size_px,
    )

    if frame and not frame.exists() and (study / frame).exists():
        frame = study / frame
    _refuse_overwriting(out, (".png",), (frame,) if frame else ())
    refuse_outputs_over_study_files(study, (out,))
    lacks_corners = lacks_pool_corners(study / "study.yaml")
    loaded = load_incomplete_study(study) if lacks_corners else load_study(study)
    if trial_id is not None:
        loaded.trial(trial_id)
    source, fps = (frame, None) if frame else _first_footage_file_and_fps(study, loaded, trial_id)
    picture = _read_image_or_first_frame(source, fps=fps)
    confirmed = None
    if lacks_corners:
        size_px = stated_image_size_px(study / "study.yaml")
        sentences = frame_with_pixel_grid(picture, out, size_px)
    else:
        check = pool_corners_picture(picture, loaded.setup, out)
        sentences, confirmed = check.sentences, check.confirmed
    for sentence in sentences:
        click.echo(sentence)
    click.echo(f"Drawn: {out}")
    if confirmed is not None:
        click.echo(f"The corners given are {'confirmed' if confirmed else 'not confirmed'}.")
        ctx.exit(0 if confirmed else 1)


def _refuse_overwriting(out: Path, suffixes: tuple[str, ...], inputs: Sequence[Path]) -> None:
    """Raises: InputError where writing `out` would cost an input or a study, or it is no such
    file.
    """
    from ..errors import input_error  # noqa: PLC0415

    if out.suffix.lower() not in suffixes:
        raise input_error(out, "--out", f"a name that ends in '{out.suffix}'", f"{suffixes[0]}",
                    "Nothing was written.")  # fmt: skip
    if out.name == "study.yaml" and out.exists():
        raise input_error(out, "--out", "a study.yaml that is there already", "a file of its own",
                    "Nothing was written: write camera.yaml and copy its section.")  # fmt: skip
    if any(out.resolve() == path.resolve() for path in inputs):
        raise input_error(out, "--out", "a file that is read here", "another name",
                    "Nothing was written.")  # fmt: skip


def _first_footage_file_and_fps(
    folder: Path, study: Study, trial_id: str | None
) -> tuple[Path, float | None]:
    """First file and frame rate of the named trial's film, or of the first filmed trial's; without
    a filmed trial, the first video in a folder whose study.yaml is still incomplete.
    """
    from ..errors import input_error  # noqa: PLC0415
    from ..footage import open_recording  # noqa: PLC0415
    from ..footage.image_sequence import all_are_images  # noqa: PLC0415
    from ..study import VIDEO_SUFFIXES  # noqa: PLC0415

    named = study.trials if trial_id is None else (study.trial(trial_id),)
    filmed = [trial for trial in named if trial.sources and not trial.reads_keypoints]
    if not filmed and trial_id is None and study.setup is None:
        films = (p for p in folder.rglob("*") if p.suffix.lower() in VIDEO_SUFFIXES)
        if film := min(films, default=None):
            return film, None
    if not filmed:
        raise input_error(folder / "trials.csv", "", "no footage to draw on",
                          "a trial with a video or pictures",
                    "Or name a picture: bluekoi pool STUDY FRAME.")  # fmt: skip
    paths = study.paths(filmed[0])
    if all_are_images(paths):  # the first of the size that the recording has, at whatever rate
        paths = open_recording(paths, fps=filmed[0].fps or 1.0).paths
    return paths[0], filmed[0].fps


def _read_image_or_first_frame(path: Path, *, fps: float | None = None) -> Any:
    """A picture file, or the first frame of a video, (height, width, 3) bgr."""
    import cv2  # noqa: PLC0415

    from ..errors import input_error  # noqa: PLC0415
    from ..footage import frames, open_recording  # noqa: PLC0415
    from ..study import VIDEO_SUFFIXES  # noqa: PLC0415

    if path.suffix.lower() in VIDEO_SUFFIXES:
        first = next(iter(frames(open_recording([path], fps=fps), colour=True)), None)
        found: Any = first.bgr if first else None
    else:
        found = cv2.imread(str(path)) if path.is_file() else None
    if found is None:
        raise input_error(path, "", "no picture", "a picture or a video to draw on",
                    "Name one: bluekoi pool STUDY FRAME.")  # fmt: skip
    return found

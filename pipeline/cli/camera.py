"""`bluekoi calibrate` and `bluekoi pool`: the lens, and the corners of the pool."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("images", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--pattern", default="9x6", show_default=True, help="Inner corners of the board.")
@click.option("--square-mm", default=25.0, show_default=True, help="Side of a square.")
@click.option("--board", default="chessboard", show_default=True, help="Kind of board.")
@click.option("--model", default="auto", show_default=True, help="auto, pinhole or fisheye.")
@click.option("--out", default="camera.yaml", show_default=True, type=click.Path(path_type=Path))
def calibrate(
    *, images: tuple[Path, ...], pattern: str, square_mm: float, board: str, model: str, out: Path
) -> None:
    """Calibrate the lens from photographs or videos of a board, or take a lens-profile json.

    Writes the camera section for study.yaml, and a picture of coverage and residuals beside it.
    """
    from ..camera.calibrate import calibrate_files  # noqa: PLC0415

    found = calibrate_files(
        images, pattern=pattern, square_mm=square_mm, board=board, model=model, out=out
    )
    for remark in found.remarks:
        click.echo(remark)
    click.echo(
        f"{out}: {found.views} views, corner error {found.rms_px:.3f} px rms, "
        f"{found.held_out_px:.3f} px on views held out"
    )


@click.command()
@click.argument("study", type=click.Path(path_type=Path))
@click.option("--trial", "trial_id", help="Trial to take the frame from; else the first filmed.")
@click.option("--out", default="pool.png", show_default=True, type=click.Path(path_type=Path))
def pool(study: Path, trial_id: str | None, out: Path) -> None:
    """Draw the pool corners of STUDY on a frame, and say how well they fit the edges seen."""
    from ..camera.corners_picture import pool_corners_picture  # noqa: PLC0415
    from ..faults import fault  # noqa: PLC0415
    from ..footage import frames, open_recording  # noqa: PLC0415
    from ..study import load_study  # noqa: PLC0415

    loaded = load_study(study)
    filmed = [trial for trial in loaded.trials if not trial.reads_keypoints]
    if trial_id is not None:
        filmed = [loaded.trial(trial_id)]
    if not filmed or filmed[0].reads_keypoints:
        raise fault(study / "trials.csv", "", "no footage to draw on", "a trial with a video")
    recording = open_recording(loaded.paths(filmed[0]), fps=filmed[0].fps)
    picture = next(iter(frames(recording, colour=True))).bgr
    if picture is None:
        raise fault(recording.paths[0], "", "no colour picture", "a video with readable frames")
    for sentence in pool_corners_picture(picture, loaded.setup, out).sentences:
        click.echo(sentence)
    click.echo(f"Drawn: {out}")

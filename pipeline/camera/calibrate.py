"""A lens from pictures of a board: files in, camera.yaml and a picture out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..data import Float
from ..faults import Fault, Finding, fault
from ..files import write_text
from .boards import Grey, View, read_board
from .calibration_picture import draw_calibration
from .focal_groups import two_focal_lengths
from .judge import CANDIDATES, Judged, chosen, coverage, judged
from .lens import MODELS, Lens
from .pictures import find_views, grey_pictures
from .profile import read_profile

GOOD_COVERAGE = 0.6
HELD_OUT_RATIO = 1.2


@dataclass(frozen=True)
class Calibration:
    """A calibrated lens and how far to trust it.

    lens_std: of fx, fy, cx, cy and the distortion. rms_px: corners used in the fit; held_out_px:
    corners of views held out. compared: the held-out error of every model tried, or why refused.
    """

    lens: Lens
    lens_std: Float
    rms_px: float
    held_out_px: float
    views: int
    coverage: float
    compared: tuple[str, ...]
    remarks: tuple[str, ...]

    @property
    def quality(self) -> str:
        """How well it fits, in words."""
        told = f"{self.views} views, corner error {self.rms_px:.3f} px rms"
        if not np.isfinite(self.held_out_px):
            return told if np.isfinite(self.rms_px) else "no corner error stated"
        return f"{told}, {self.held_out_px:.3f} px on views held out"


def calibrate_files(
    images: Sequence[str | Path],
    *,
    pattern: str = "9x6",
    square_mm: float = 25.0,
    board: str = "chessboard",
    model: str = "auto",
    out: str | Path = "camera.yaml",
    picture: str | Path | None = None,
) -> Calibration:
    """Calibration written to `out` as a camera section for study.yaml, with a picture beside it.

    images: photographs or videos of the board, or a single lens-profile json. pattern: inner
    corners, `9x6`. model: auto, pinhole or fisheye; auto takes the least error on views held out.
    picture: coverage and residuals, by default `out` with the ending .png.

    Raises: Fault with every reason why the calibration cannot be right.
    """
    paths = [Path(path) for path in images]
    if not paths:
        raise fault("calibrate", "", "no pictures", "photographs or videos of a board")
    if [path.suffix.lower() for path in paths] == [".json"]:
        if model not in ("auto", "fisheye"):
            raise fault("--model", "", f"'{model}'", "fisheye, as lens profiles are, or auto")
        result = from_profile(paths[0])
        write_text(out, camera_section(result))
        return result
    kind = read_board(pattern, square_mm, board)
    views, without, size = find_views(grey_pictures(paths), kind)
    best, candidates = best_model(views, model, size)
    result = _result(best, candidates, without, size)
    target = Path(out)
    draw_calibration(picture or target.with_suffix(".png"), best, candidates)
    write_text(target, camera_section(result))
    return result


def best_model(
    views: list[View], model: str, size_px: tuple[int, int]
) -> tuple[Judged, list[Judged]]:
    """The model to believe and all that were tried.

    Raises: Fault where every model is refused, with the reasons of each.
    """
    if model not in ("auto", *MODELS):
        raise fault("--model", "", f"'{model}'", f"one of auto, {', '.join(MODELS)}")
    candidates = []
    for name, terms in CANDIDATES:
        if model in ("auto", name):
            try:
                candidates.append(judged(views, name, terms, size_px))
            except ValueError:
                continue
    best = chosen(candidates)
    if best is None:
        raise Fault(_why_refused(candidates, len(views)))
    return best, candidates


def from_profile(path: str | Path, size_px: tuple[int, int] | None = None) -> Calibration:
    """Calibration as a lens-profile json states it, scaled to `size_px` where given."""
    lens, rms, count = read_profile(path, size_px)
    remark = (
        "from a lens profile made with another camera of this type: good for a start; calibrate "
        "your own for measurements"
    )
    return Calibration(
        lens=lens,
        lens_std=np.full(8, np.nan),
        rms_px=rms,
        held_out_px=float("nan"),
        views=count,
        coverage=float("nan"),
        compared=(),
        remarks=(remark,),
    )


def camera_section(result: Calibration) -> str:
    """The `camera:` section of study.yaml, its quality in comments."""
    lens, std = result.lens, result.lens_std
    rows = ", ".join("[" + ", ".join(f"{x:.6g}" for x in row) + "]" for row in lens.matrix)
    known = np.isfinite(std).all()
    spread = ["standard deviations: " + ", ".join(f"{x:.3g}" for x in std)] if known else []
    comments = [
        result.quality,
        *spread,
        *(f"compared: {line}" for line in result.compared),
        *result.remarks,
        "add pool_corners_px: images of pool (0,0), (L,0), (L,W), (0,W); `bluekoi pool` helps",
    ]
    lines = [
        *(f"# {comment}" for comment in comments),
        "camera:",
        f"  model: {lens.model}",
        f"  image_size_px: [{lens.size_px[0]}, {lens.size_px[1]}]",
        f"  matrix: [{rows}]",
        f"  distortion: [{', '.join(f'{x:.8g}' for x in lens.distortion)}]",
    ]
    return "\n".join(lines) + "\n"


def calibrate_pictures(
    pictures: Iterable[tuple[str, Grey]], *, pattern: str, square_mm: float, board: str, model: str
) -> Calibration:
    """Calibration from grey pictures handed in, such as `pictures.from_frames(...)`."""
    kind = read_board(pattern, square_mm, board)
    views, without, size = find_views(pictures, kind)
    best, candidates = best_model(views, model, size)
    return _result(best, candidates, without, size)


def _result(
    best: Judged, candidates: list[Judged], without: list[str], size_px: tuple[int, int]
) -> Calibration:
    covered = coverage(best.views, size_px)
    remarks = []
    if without:
        remarks.append(f"board not found in {len(without)} pictures: {', '.join(without[:10])}")
    if best.left_out:
        remarks.append(f"left out as grossly off: {', '.join(best.left_out)}")
    if covered < GOOD_COVERAGE:
        remarks.append(
            f"corners cover {100 * covered:.0f} % of the picture; outside them the lens is guessed"
        )
    if best.held_out_px > HELD_OUT_RATIO * best.fit.rms_px:
        remarks.append("views held out fit worse than those used: take more views")
    if two := two_focal_lengths(best.fit, list(best.views)):
        remarks.append(two)
    return Calibration(
        lens=best.fit.lens,
        lens_std=np.sqrt(np.diag(best.fit.lens_cov)),
        rms_px=best.fit.rms_px,
        held_out_px=best.held_out_px,
        views=len(best.views),
        coverage=covered,
        compared=tuple(_compared(candidate) for candidate in candidates),
        remarks=tuple(remarks),
    )


def _compared(candidate: Judged) -> str:
    text = f"{candidate.label}: {candidate.held_out_px:.3f} px held out"
    return text + (f", refused ({'; '.join(candidate.refusals)})" if candidate.refusals else "")


def _why_refused(candidates: list[Judged], views: int) -> list[Finding]:
    expected = "a lens that can be right"
    cure = (
        "Take 15 or more pictures that fill the frame up to its corners, most with the board "
        "tilted by 20 to 45 degrees in different directions, held still."
    )
    reasons: dict[str, list[str]] = {}
    for candidate in candidates:
        for reason in candidate.refusals:
            reasons.setdefault(reason, []).append(candidate.label)
    if not reasons:
        found = f"{views} views that no starting focal length suits"
        return [Finding("calibrate", "", found, expected, cure)]
    return [
        Finding("calibrate", "; ".join(labels), reason, expected, cure if not i else "")
        for i, (reason, labels) in enumerate(reasons.items())
    ]

"""A lens from pictures of a board: files in, camera.yaml and a picture out."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..data import Float
from ..errors import InputError, InputIssue, input_error
from ..files import atomic_write, write_text
from .board_pictures import BoardViews, find_board_views, read_grey_pictures
from .boards import BoardView, board_from_pattern
from .calibration_picture import draw_calibration
from .focal_length_groups import zoom_change_remark
from .gyroflow_profile import read_lens_profile
from .image_circle import ImageCircle
from .lens import LENS_MODELS, Lens
from .lens_selection import (
    MIN_BOARD_VIEWS,
    MODELS_COMPARED,
    LensCandidate,
    fit_lens_candidate,
    image_coverage,
    opencv_held_out_rms,
    select_lens,
    too_few_views_reason,
)

MIN_IMAGE_COVERAGE_SHARE = 0.6
"""Share of the picture that corners should cover; with less the calibration carries a remark."""
MAX_HELD_OUT_TO_USED_ERROR_RATIO = 1.2
"""Reprojection error of held-out over used views, above which more views are asked for."""


@dataclass(frozen=True)
class LensCalibration:
    """A calibrated lens and its accuracy.

    lens_std: of fx, fy, cx, cy and the distortion. rms_px: corners used in the fit; held_out_px:
    corners of held-out views; opencv_px: the same by OpenCV's calibration of the same model, on the
    same views and folds (NaN: not compared). compared: the held-out error of every model tried, or
    the reason that refuses it. circle: of a circular fisheye lens.
    """

    lens: Lens
    lens_std: Float
    rms_px: float
    held_out_px: float
    opencv_px: float
    views: int
    coverage: float
    compared: tuple[str, ...]
    remarks: tuple[str, ...]
    circle: ImageCircle | None = None

    @property
    def quality_text(self) -> str:
        """How well it fits, in words."""
        fit = f"{self.views} views, corner error {self.rms_px:.3f} px rms"
        if not np.isfinite(self.held_out_px):
            return fit if np.isfinite(self.rms_px) else "no corner error stated"
        opencv = f"{self.opencv_px:.3f} px" if np.isfinite(self.opencv_px) else "fails"
        return f"{fit}, {self.held_out_px:.3f} px on held-out views (OpenCV: {opencv})"


def calibrate_files(
    images: Sequence[str | Path], *, pattern: str = "9x6", square_mm: float = 25.0, board: str =
    "chessboard", model: str = "auto", out: str | Path = "camera.yaml",
) -> LensCalibration:  # fmt: skip
    """Calibration written to `out` as a camera section for study.yaml, with a picture beside it.

    images: photographs or videos of the board, or a single lens-profile json. pattern: inner
    corners, `9x6`. model: auto, pinhole or fisheye; auto takes the least error on views held out.
    The picture shows coverage and residuals; its name is `out` with the ending .png.

    Both files are written, or neither. Raises: InputError with every reason why the calibration
    cannot be right.
    """
    paths, target = [Path(path) for path in images], Path(out)
    is_profile = [path.suffix.lower() for path in paths] == [".json"]
    for path in (target,) if is_profile else (target, target.with_suffix(".png")):
        if path.is_dir():
            raise input_error(path, "--out", "a folder", "the name of a file to write")
    if not paths:
        raise input_error("calibrate", "", "no pictures", "photographs or videos of a board")
    if is_profile:
        if model not in ("auto", "fisheye"):
            raise input_error("--model", "", f"'{model}'", "fisheye, as lens profiles are, or auto")
        result = calibration_from_lens_profile(paths[0])
        write_text(out, camera_yaml(result))
        return result
    wanted = board_from_pattern(pattern, square_mm, board)
    found = find_board_views(read_grey_pictures(paths, wanted), wanted)
    best, candidates = select_lens_model(found.views, model, found.size_px, found.circle)
    result = _calibration_result(best, candidates, found)
    with atomic_write(target) as temporary:
        temporary.write_text(camera_yaml(result), encoding="utf-8")
        draw_calibration(target.with_suffix(".png"), best, candidates, found.circle)
    return result


def select_lens_model(
    views: list[BoardView], model: str, size_px: tuple[int, int], circle: ImageCircle | None = None
) -> tuple[LensCandidate, list[LensCandidate]]:
    """The selected model and all that were compared.

    Raises: InputError where every model is refused, with the reasons of each.
    """
    if model not in ("auto", *LENS_MODELS):
        raise input_error("--model", "", f"'{model}'", f"one of auto, {', '.join(LENS_MODELS)}")
    if len(views) < MIN_BOARD_VIEWS:
        raise InputError(_all_models_refused_error([], len(views), circle))
    candidates: list[LensCandidate] = []
    for name, terms in MODELS_COMPARED:
        simpler = [c.fit.lens for c in candidates if c.model == name]
        if model in ("auto", name):
            with suppress(ValueError):
                candidates.append(
                    fit_lens_candidate(views, name, terms, size_px, circle=circle, simpler=simpler)
                )
    best = select_lens(candidates)
    if best is None:
        raise InputError(_all_models_refused_error(candidates, len(views), circle))
    return best, candidates


def calibration_from_lens_profile(path: str | Path) -> LensCalibration:
    """Calibration as a lens-profile json states it, scaled to `size_px` where given."""
    lens, rms, count = read_lens_profile(path)
    remark = (
        "from a lens profile made with another camera of this type: good for a start; calibrate "
        "your own for measurements"
    )
    return LensCalibration(
        lens=lens,
        lens_std=np.full(8, np.nan),
        rms_px=rms,
        held_out_px=float("nan"),
        opencv_px=float("nan"),
        views=count,
        coverage=float("nan"),
        compared=(),
        remarks=(remark,),
    )


def camera_yaml(result: LensCalibration) -> str:
    """The `camera:` section of study.yaml, its quality in comments."""
    lens, std = result.lens, result.lens_std
    rows = ", ".join("[" + ", ".join(f"{x:.6g}" for x in row) + "]" for row in lens.matrix)
    known = np.isfinite(std).all()
    spread = ["standard deviations: " + ", ".join(f"{x:.3g}" for x in std)] if known else []
    comments = [
        result.quality_text,
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


def _calibration_result(
    best: LensCandidate, candidates: list[LensCandidate], found: BoardViews
) -> LensCalibration:
    covered = image_coverage(best.views, found.size_px, found.circle)
    remarks = []
    if found.without:
        names = ", ".join(found.without[:10])
        remarks.append(f"board not found in {len(found.without)} pictures: {names}")
    if best.left_out:
        remarks.append(f"left out as gross outliers: {', '.join(best.left_out)}")
    if found.circle:
        remarks.append(_image_circle_remark(best, found.circle))
    if covered < MIN_IMAGE_COVERAGE_SHARE:
        where = "image circle" if found.circle else "picture"
        remarks.append(
            f"corners cover {100 * covered:.0f} % of the {where}; "
            "elsewhere the lens is extrapolated"
        )
    if best.held_out_px > MAX_HELD_OUT_TO_USED_ERROR_RATIO * best.fit.rms_px:
        remarks.append("held-out views fit worse than those used: take more views")
    if two := zoom_change_remark(best.fit, list(best.views)):
        remarks.append(two)
    return LensCalibration(
        lens=best.fit.lens,
        lens_std=np.sqrt(np.diag(best.fit.lens_cov)),
        rms_px=best.fit.rms_px,
        held_out_px=best.held_out_px,
        opencv_px=opencv_held_out_rms(best, found.size_px),
        views=len(best.views),
        coverage=covered,
        compared=tuple(_candidate_sentence(candidate) for candidate in candidates),
        remarks=tuple(remarks),
        circle=found.circle,
    )


def _image_circle_remark(best: LensCandidate, circle: ImageCircle) -> str:
    """The image circle, and how far out of it the corners of the boards lie."""
    points = np.concatenate([view.image_px for view in best.views])
    reach = float(np.max(np.hypot(*(points - circle.center_px).T))) / circle.radius_px
    return f"{circle.text}; the boards' corners lie within {100 * reach:.0f} % of its radius"


def _candidate_sentence(candidate: LensCandidate) -> str:
    text = f"{candidate.label}: {candidate.held_out_px:.3f} px held out"
    reasons = "; ".join(candidate.implausibilities)
    return text + (f", refused ({reasons})" if reasons else "")


def _all_models_refused_error(
    candidates: list[LensCandidate], views: int, circle: ImageCircle | None
) -> list[InputIssue]:
    expected = "a lens that can be right"
    reach = "bring the board to the rim of the image circle" if circle else "fill the frame"
    remedy = (
        f"Take 15 or more pictures that together {reach} on all sides, most with the board tilted "
        "by 20 to 45 degrees in different directions, held still."
    )
    reasons: dict[str, list[str]] = {}
    for candidate in candidates:
        for reason in candidate.implausibilities:
            reasons.setdefault(reason, []).append(candidate.label)
    if not reasons:
        found = f"{views} views that no starting focal length suits"
        if views < MIN_BOARD_VIEWS:
            found = too_few_views_reason(views)
        return [InputIssue("calibrate", "", found, expected, remedy)]
    if circle:
        remedy = f"The pictures show an {circle.text}. {remedy}"
    return [
        InputIssue("calibrate", "; ".join(labels), reason, expected, remedy if not i else "")
        for i, (reason, labels) in enumerate(reasons.items())
    ]

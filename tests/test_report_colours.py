"""Colours of page, figures and videos: legible, distinguishable with colour vision deficiencies."""

from __future__ import annotations

import re
from importlib.resources import files
from itertools import combinations

import numpy as np
import pytest

from bluekoi.figures.drawing import style
from bluekoi.report import overlay_frame

CSS = files("bluekoi.report").joinpath("page.css").read_text(encoding="utf-8")
# Machado, Oliveira and Fernandes (2009), Table 1, severity 1.0, on linear RGB.
COLOUR_VISION_MATRICES = {
    "all three": np.eye(3),
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
                   [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
                     [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602],
                   [0.004733, 0.691367, 0.303900]],
}  # fmt: skip
RGB_TO_XYZ = np.array(
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
)
MIN_DISTANCE = 20.0
"""Distance in CIE Lab; 2.3 is the least that is noticed side by side."""


def linear_rgb(colour: str) -> np.ndarray:
    """Linear RGB of `#rrggbb` (IEC 61966-2-1)."""
    full = colour if len(colour) == 7 else "#" + "".join(2 * c for c in colour[1:])
    rgb = np.array([int(full[k : k + 2], 16) for k in (1, 3, 5)]) / 255
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


def cie_lab(rgb: np.ndarray) -> np.ndarray:
    """CIE Lab of linear RGB, white at D65."""
    x, y, z = np.cbrt(
        np.clip(RGB_TO_XYZ @ np.clip(rgb, 0, 1) / RGB_TO_XYZ.sum(axis=1), 0.008856, None)
    )
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def contrast_ratio(one: str, other: str) -> float:
    """Of two colours, by WCAG 2.1: 1 to 21."""
    a, b = sorted((RGB_TO_XYZ[1] @ linear_rgb(colour) for colour in (one, other)), reverse=True)
    return float((a + 0.05) / (b + 0.05))


def bgr_to_hex(bgr: tuple[int, ...]) -> str:
    return "#{:02x}{:02x}{:02x}".format(*bgr[::-1])


def test_contrast_is_that_of_the_standard():
    assert contrast_ratio("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast_ratio("#777777", "#ffffff") == pytest.approx(4.48, abs=0.01)


@pytest.mark.parametrize("name", ["ink", "soft", "blue", "orange", "green"])
def test_text_stands_out_from_white_and_from_the_wash(name):
    colours = dict(re.findall(r"--(\w+): (#[0-9a-f]+)", CSS))
    for ground in ("#ffffff", colours["wash"]):
        assert contrast_ratio(colours[name], ground) >= 4.5  # WCAG 2.1, level AA


def test_text_on_tags_stands_out():
    pairs = re.findall(r"background: (#[0-9a-f]{6}); color: (#[0-9a-f]{6})", CSS)
    assert len(pairs) >= 2
    assert all(contrast_ratio(*pair) >= 4.5 for pair in pairs)


PATH_COLOURS = {
    "page": [re.search(rf"polyline\.{kind} {{ stroke: (#[0-9a-f]+)", CSS)[1]
             for kind in ("measured", "before", "after")],
    "figures": [style.MEASURED_COLOUR, style.BEFORE_COLOUR, style.AFTER_COLOUR],
    "videos": [bgr_to_hex(getattr(overlay_frame, f"{k}_BGR"))
               for k in ("MEASURED", "BEFORE", "AFTER")],
}  # fmt: skip


@pytest.mark.parametrize("sight", COLOUR_VISION_MATRICES)
@pytest.mark.parametrize("where", PATH_COLOURS)
def test_the_three_paths_are_distinguishable(where, sight):
    seen = [
        cie_lab(np.asarray(COLOUR_VISION_MATRICES[sight]) @ linear_rgb(colour))
        for colour in PATH_COLOURS[where]
    ]
    assert min(np.linalg.norm(a - b) for a, b in combinations(seen, 2)) > MIN_DISTANCE

"""Seven swimming larvae against the kinematics of an independent R package (deepdanio).

1000 frames/s, 0.0222 mm per pixel; times in ms after the movement begins.
"""

from __future__ import annotations

import csv

import numpy as np
import pytest

from bluekoi.data import KeypointPositions, Pose
from bluekoi.motor import tail_beat_from_video
from bluekoi.smoothing import smooth_pose
from keypoint_files import read_all_parts

MM_PER_PX = 0.0222
LARVAE = ("01128", "01129", "01130", "01137", "01140", "01146", "01149")
pytestmark = pytest.mark.recordings


@pytest.fixture(params=LARVAE)
def larva(request, recordings):
    """Positions in mm from the start of the movement on, and the package's results."""
    folder, name = recordings / "zebrafish_kinematics", request.param
    with (folder / "kin_results" / f"{name}_one_row.csv").open() as lines:
        result = {k: v.strip() for k, v in next(csv.DictReader(lines)).items()}
    with (folder / "kin_results" / f"{name}_all_ms.csv").open() as lines:
        start = next(int(r["orig.ms"]) for r in csv.DictReader(lines) if r["move.ms"] == "0")
    found = read_all_parts(next((folder / "dlc").glob(f"{name}DLC*.csv")), 1000.0)
    return found, MM_PER_PX * found.xy_px, start, result


def path_length(xy) -> float:
    return float(np.hypot(*np.diff(xy, axis=0).T).sum())


def test_distance(larva):
    found, xy, start, result = larva
    body = float(result["BL.mm"])
    at = slice(start, start + 61)
    measured = path_length(xy[at, found.names.index("S2")]) / body
    assert measured == pytest.approx(float(result["overall.dist.BL"]), abs=0.0022)


def test_distance_of_the_smoothed_path(larva):
    """The path without the noise is shorter, by little: 0.01 body lengths, 0.045 in one larva that
    hardly swims."""
    found, xy, start, result = larva
    snout, middle = (xy[:, found.names.index(n)] for n in ("TS", "S2"))
    heading = np.unwrap(np.arctan2(*(snout - middle).T[::-1]))
    values = np.column_stack([middle, heading, np.zeros(len(middle))])[: start + 100]
    cov = np.tile(np.diag([1e-4, 1e-4, 1e-3, 1e-4]), (len(values), 1, 1))
    track = smooth_pose(Pose(found.time_s[: start + 100], values, cov), 0.0)
    at = slice(start, start + 61)
    body = float(result["BL.mm"])
    theirs = float(result["overall.dist.BL"])
    assert path_length(np.column_stack([track.x_m, track.y_m])[at]) / body == pytest.approx(
        theirs, abs=0.05
    )
    travelled = np.trapezoid(track.speed_m_s[at], track.time_s[at]) / body
    assert travelled == pytest.approx(theirs, abs=0.05)


def test_tail_beat_frequency(larva):
    """Their frequency counts strokes, two a beat, over the swimming stage of 2 to 6 strokes."""
    found, xy, start, result = larva
    first = start + int(result["stg1.dur.ms"]) + int(result["stg2.dur.ms"])
    at = slice(first, first + int(result["stg3.total.dur.ms"]) + 1)
    parts = [found.names.index(n) for n in ("S1", "T1", "T4")]
    n = at.stop - at.start
    positions = KeypointPositions(
        found.time_s[at],
        ("core_center", "tail_base", "tail_tip"),
        xy[at][:, parts],
        np.tile(1e-4 * np.eye(2), (n, 3, 1, 1)),
        found.likelihood[at][:, parts],
    )
    theirs = float(result["stg3.ave.TSF.Hz"]) / 2
    hz, std = tail_beat_from_video(positions, theirs)
    assert hz == pytest.approx(theirs, rel=0.03)
    if int(result["stg3.no.strokes"]) >= 5:
        blind, _ = tail_beat_from_video(positions)
        assert blind == pytest.approx(theirs, rel=0.03)
        assert std < 1.0

"""Synthetic studies of robotic fish in a harbour dock, for blind tests of a finder of causes.

`generate(seed, index, folder)` writes folder/studies/NAME in the layout of STUDY.md (DeepLabCut
csv files as source) and folder/truth/NAME.json, and returns the truth. Deterministic in (seed,
index). Groups, in random order within 20 consecutive indices: 4 null, 8 one, 5 two, 3 unlisted;
half of the robots of each group have a tail fin.

Modelled: the flat-plate equations of MODEL.md (RK4, 20 ms), robots of 0.2 to 0.8 m in a basin of
fitting size; start from rest; slow water motion (Ornstein-Uhlenbeck, uniform in the basin, new in
every trial), servo and thrust errors per trial, small residual starting rates; one of five fin
laws; 30 hidden causes with two to five forms each; six forces that are on nobody's list. Causes
act in the equations (physics) or on the true camera, its clock or the numbers in study.yaml
(measurement). Camera: OpenCV's pinhole or fisheye, tilt, refraction by Snell's law at a flat
surface, corner marks with 0.25 px of noise, intrinsics with 0.015 %. Labels: recoil in heading and
sway and a beating tail at the shaft's frequency, white and correlated tracking noise, outliers
(some with high likelihood), gaps of single points and of whole frames. Motor logs with dead zone.

The sources of the forms, named beside them, are given from memory and were not looked up.

Sigma (detector.py): linear and ideal. Observed are x, y, heading, head angle and apparent body
length every 0.26 s; the covariance has tracking noise, water motion, starting state, servo and
thrust errors; refitted are the six coefficients, strength and place of the fin, the other cause,
and with priors the scale of each axis (0.08 %) and the placing of the end labels (0.5 %). It does
not use the phase of the tail beat nor the motor log.

Left out: waves and glare, rolling and pitching, reaction of the body to the turning head, change
of speed within a beat, water motion that differs between places (except as a cause), accelerated
water in the added mass, contact with walls. A camera that was knocked in a trial is put back
before the next one. The log's clock is exact.

Known inaccuracies: the strips of `crossflow_drag` include both ends, so that its yaw damping is
half as large again as that of the integral; a wave hump grows beyond the robot's top speed; a robot
that takes up water for 15 s may sink to the floor; a shifted centre of mass moves neither the fin
nor the arms of other causes.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .study import build

__all__ = ["generate"]


def generate(seed: int, index: int, folder: Path) -> dict[str, Any]:
    """Write one complete study and its truth below `folder`; return the truth."""
    return build(int(seed), int(index), Path(folder))

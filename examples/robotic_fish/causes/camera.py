"""What the camera and its clock may have got wrong.

Source: own statements.
"""

from __future__ import annotations

from bluekoi.explain import Cause, Parameter

Three = tuple[float, float, float]


def beat_clock(beat_hz: float, beat_hz0: float, k: float) -> tuple[float]:
    """True seconds in a recorded one: 1 + k (seen beat / f0 - 1); k = 1: the clock is at fault."""
    return (k * (beat_hz / beat_hz0 - 1.0),)


def point_observe(cpsi: float, spsi: float, bx: float, by: float) -> Three:
    """The tracked point lies (bx, by) from the centre of mass, fixed to the body."""
    return bx * cpsi - by * spsi, bx * spsi + by * cpsi, 0.0


def heading_observe(d: float) -> Three:
    """The heading is read d beside the body's axis."""
    return 0.0, 0.0, d


CAUSES = (
    Cause(
        "clock_error",
        "The recordings' clocks run at different rates; a tail that beats at one "
        "rate is seen at several.",
        {"clock": beat_clock},
        (
            Parameter(
                "k", "1", 0.5, -1.0, 2.0, "1: the whole difference of the seen beats is the clock's"
            ),
        ),
        kind="measurement",
        site=True,
    ),
    Cause(
        "keypoint_bias",
        "The tracked point is not the centre of mass.",
        {"observe": point_observe},
        (
            Parameter("by", "m", 0.003, -0.1, 0.1, "to the left"),
            Parameter("bx", "m", 0.003, -0.15, 0.15, "ahead"),
        ),
        kind="measurement",
        strengths=2,
    ),
    Cause(
        "heading_bias",
        "The heading is read beside the body's axis.",
        {"observe": heading_observe},
        (Parameter("d", "rad", 0.02, -0.4, 0.4, "to the left"),),
        kind="measurement",
    ),
)

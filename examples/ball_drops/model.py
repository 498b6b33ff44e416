"""A ball falls: h' = w, m w' = -m g + what was left out; a camera sees h.

Drag coefficients are those of a sphere of the ball's circumference: F = 1/2 rho A C w |w|.
"""

from __future__ import annotations

from bluekoi.explain import Cause, Constant, Model, Observation, Parameter, Stage, State
from bluekoi.integrate.branchless import smooth_step

from .reading import GRAVITY, read_folder

AIR_KG_M3 = 1.2
DRAG_SPREAD = 0.4
"""How far one ball's drag coefficient may be from that of all, as a share: spheres have 0.4 to 0.5
below the drag crisis, 0.1 to 0.3 beyond it, to 0.6 with fuzz or holes. Source: Hoerner,
Fluid-Dynamic Drag (1965), sec. 3.3; Mehta, Annu. Rev. Fluid Mech. 17 (1985), 151 (sports balls)."""


def gravity(m: float, g: float) -> tuple[float]:
    """Weight (N)."""
    return (-m * g,)


def motion(w: float, m: float, m_air: float, F: float) -> tuple[float, float, float]:
    """H' = w, w' = F / (m + m_air); the drop's scale s stays as it is."""
    return w, F / (m + m_air), 0.0


def seen(h: float, h0: float, s: float) -> tuple[float]:
    """Height as the camera gives it (m): in this drop 1 + s times too long, from the start on."""
    return (h + s * (h - h0),)


def drag(w: float, rho: float, A: float, C: float, z: float) -> tuple[float]:
    """F = -1/2 rho A C (1 + z) w |w|; z: by how much this ball differs from C."""
    return (-0.5 * rho * A * C * (1.0 + z) * w * abs(w),)


def own_drag() -> tuple[float]:
    """A ball's z stays as it is."""
    return (0.0,)


def crisis(w: float, rho: float, A: float, k: float, Re: float) -> tuple[float]:
    """F = +1/2 rho A k w |w| s: the drag lost where the boundary layer turns turbulent; s rises
    from 0 to 1 as the Reynolds number |w| D / nu goes from 0.7 to 1.3 times Re (in 1e5).
    """
    diameter = 2.0 * (A / 3.141592653589793) ** 0.5
    number = abs(w) * diameter / 1.5
    return (0.5 * rho * A * k * w * abs(w) * smooth_step((number / Re - 0.7) / 0.6),)


def carried(rho: float, A: float, k: float) -> tuple[float]:
    """Added mass (kg): k times that of a sphere, 1/2 rho (4/3) A r, r = sqrt(A / pi)."""
    r = (A / 3.141592653589793) ** 0.5
    return (k * 0.5 * rho * 1.3333333333333333 * A * r,)


def scaled(h: float, h0: float, k: float) -> tuple[float]:
    """Lengths are seen (1 + k) times too long, measured from where the ball starts."""
    return (k * (h - h0),)


def distorted(h: float, h0: float, k: float) -> tuple[float]:
    """Seen too short by the share 2 k at both ends of the fall and too long by k in its middle,
    as a barrel lens does, the ends in their places: k m (z^3 - z), z = (h - m) / m, m = h0 / 2.
    """
    m = 0.5 * h0
    z = (h - m) / m
    return (-k * m * z * (z * z - 1.0),)


def tilted(h: float, h0: float, k: float) -> tuple[float]:
    """A camera that looks up: h (1 + k) / (1 + k h / h0) - h, both ends in their places.

    Lengths near the ground are seen 1 + k times, at the top 1 / (1 + k) times as long as they are.
    """
    return (h * (1.0 + k) / (1.0 + k * h / h0) - h,)


def quickened(k: float) -> tuple[float]:
    """True seconds in a recorded one: 1 + k."""
    return (k,)


def clock() -> tuple[float]:
    """True seconds in a recorded one."""
    return (1.0,)


CAUSES = (
    Cause(
        "air_drag",
        "The air holds the ball back, as the square of its speed.",
        {"force": drag},
        (Parameter("C", "1", 0.4, 0.0, 3.0, "drag coefficient of the sphere"),),
        states=("z",),
        rates=own_drag,
        start_std=DRAG_SPREAD,
    ),
    Cause(
        "added_mass",
        "The ball has to set air in motion.",
        {"inertia": carried},
        (Parameter("k", "1", 1.0, 0.0, 50.0, "1: a sphere's in still air"),),
    ),
    Cause(
        "scale_error",
        "All lengths are seen too long or too short.",
        {"observe": scaled},
        (Parameter("k", "1", 0.01, -0.3, 0.3, "share seen too long"),),
        kind="measurement",
        site=True,
    ),
    Cause(
        "clock_error",
        "The frame rate is not what it was said to be.",
        {"clock": quickened},
        (Parameter("k", "1", 0.01, -0.3, 0.3, "share by which true time runs faster"),),
        kind="measurement",
        site=True,
    ),
    Cause(
        "lens_error",
        "The lens shows the ends of the fall shorter than its middle.",
        {"observe": distorted},
        (Parameter("k", "1", 0.01, -0.2, 0.2, "middle seen too long"),),
        kind="measurement",
        site=True,
    ),
    Cause(
        "perspective",
        "Lengths near the ground are seen longer than lengths near the top.",
        {"observe": tilted},
        (Parameter("k", "1", 0.02, -0.4, 0.8, "too long at the ground"),),
        kind="measurement",
        site=True,
    ),
    Cause(
        "drag_crisis",
        "At speed the boundary layer turns turbulent and drag falls.",
        {"force": crisis},
        (
            Parameter("k", "1", 0.2, 0.0, 1.0, "drag coefficient lost"),
            Parameter("Re", "1e5", 1.5, 0.3, 5.0, "Reynolds number of the crisis"),
        ),
    ),
)
MODEL = Model(
    name="ball_drops",
    states=(
        State("h", "m", 0.3, observed="height"),
        State("w", "m/s", 0.4, rate_of="height"),
        State("s", "1", 0.05),
    ),
    observations=(Observation("height", "m", 0.02),),
    constants=(
        Constant("m", "kg"),
        Constant("A", "m2"),
        Constant("rho", "kg/m3", AIR_KG_M3),
        Constant("h0", "m"),
    ),
    coefficients=(Parameter("g", "m/s2", GRAVITY, 9.78, 9.84, "gravity, anywhere on the ground"),),
    stages=(
        Stage("clock", ("clock_rate",), clock, open=True),
        Stage("force", ("F",), gravity, open=True),
        Stage("inertia", ("m_air",), None, open=True),
        Stage("rates", ("h", "w", "s"), motion),
        Stage("observe", ("height",), seen),
    ),
    causes=CAUSES,
    pushed=(),
    read=read_folder,
)
"""Nothing pushes a ball in still air. s: share by which a drop's lengths are seen too long."""

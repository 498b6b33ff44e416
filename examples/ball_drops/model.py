"""A ball falls: h' = w, m w' = -m g + what was left out; a camera sees h.

Drag coefficients are those of a sphere of the ball's circumference: F = 1/2 rho A C w |w|.
"""

from __future__ import annotations

from pipeline.integrate import Parameter, Stage, System
from pipeline.integrate.trigonometry import smooth_step

from ..effect import effect

AIR_KG_M3 = 1.2
GRAVITY = 9.81


def gravity(m: float, g: float) -> tuple[float]:
    """Weight (N)."""
    return (-m * g,)


def motion(w: float, m: float, m_air: float, F: float) -> tuple[float, float]:
    """H' = w, w' = F / (m + m_air)."""
    return w, F / (m + m_air)


def seen(h: float) -> tuple[float]:
    """Height as the camera gives it (m)."""
    return (h,)


def drag(w: float, rho: float, A: float, C: float) -> tuple[float]:
    """F = -1/2 rho A C w |w|."""
    return (-0.5 * rho * A * C * w * abs(w),)


def linear_drag(w: float, k: float) -> tuple[float]:
    """F = -k w."""
    return (-k * w,)


def lift(rho: float, A: float, w: float, k: float) -> tuple[float]:
    """F = 1/2 rho A k w^2: a spinning ball that glides."""
    return (0.5 * rho * A * k * w * w,)


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


def scaled(h: float, h0: float, second: float, k1: float, k2: float) -> tuple[float]:
    """Lengths are seen (1 + k) times too long, measured from where the ball starts."""
    return ((k1 + (k2 - k1) * second) * (h - h0),)


def distorted(h: float, h0: float, k: float) -> tuple[float]:
    """Seen too short by the share 2 k at both ends of the fall and too long by k in its middle,
    as a barrel lens does, the ends in their places: k m (z^3 - z), z = (h - m) / m, m = h0 / 2.
    """
    m = 0.5 * h0
    z = (h - m) / m
    return (-k * m * z * (z * z - 1.0),)


def tilted(h: float, h0: float, k: float) -> tuple[float]:
    """Seen too short by the share k at the top and too long by k at the ground, both ends in their
    places: k h (1 - h / h0); so a camera that looks up from below, or a fall towards it.
    """
    return (k * h * (1.0 - h / h0),)


def quickened(k: float) -> tuple[float]:
    """True seconds in a recorded one: 1 + k."""
    return (k,)


def clock() -> tuple[float]:
    """True seconds in a recorded one."""
    return (1.0,)


def disturbance_force(m: float, g_up: float) -> tuple[float]:
    """A random acceleration (m/s2) as a force (N)."""
    return (m * g_up,)


def disturbance_rate(g_up: float, tau: float) -> tuple[float]:
    """It forgets itself within tau."""
    return (-g_up / tau,)


def lasting_height(e: float) -> tuple[float]:
    """An error of the tracked height (m)."""
    return (e,)


def lasting_decay(e: float, tau_e: float) -> tuple[float]:
    """It forgets itself within tau_e."""
    return (-e / tau_e,)


EFFECTS = (
    effect("disturbance", "Air is never quite still.", {"force": disturbance_force},
           (("present", "1", 1.0, 0.0, 1.0, "1 where it acts"),
            ("tau", "s", 1.0, 0.05, 10.0, "memory")),
           kind="disturbance", channels=("fall",), states=("g_up",), rates=disturbance_rate),
    effect("lasting_error", "The tracked height's errors last for a while.",
           {"observe": lasting_height},
           (("present", "1", 1.0, 0.0, 1.0, "1 where they are"),
            ("tau_e", "s", 0.2, 0.02, 2.0, "memory")),
           kind="disturbance", states=("e",), rates=lasting_decay),
    effect("air_drag", "The air holds the ball back, as the square of its speed.", {"force": drag},
           (("C", "1", 0.4, 0.0, 3.0, "drag coefficient of the sphere"),),
           evidence={"sphere_drag": 1.0}),
    effect("linear_drag", "The air holds the ball back, in proportion to its speed.",
           {"force": linear_drag}, (("k", "N s/m", 0.01, 0.0, 5.0, "force at 1 m/s"),)),
    effect("added_mass", "The ball has to set air in motion.", {"inertia": carried},
           (("k", "1", 1.0, 0.0, 50.0, "1: a sphere's in still air"),)),
    effect("scale_error", "All lengths are seen too long or too short.", {"observe": scaled},
           (("k1", "1", 0.01, -0.3, 0.3, "share seen too long in the first drop"),
            ("k2", "1", 0.01, -0.3, 0.3, "share seen too long in the second drop")),
           kind="measurement", strengths=2),
    effect("clock_error", "The frame rate is not what it was said to be.", {"clock": quickened},
           (("k", "1", 0.01, -0.3, 0.3, "share by which true time runs faster"),),
           kind="measurement"),
    effect("lens_error", "The lens shows the ends of the fall shorter than its middle.",
           {"observe": distorted}, (("k", "1", 0.01, -0.2, 0.2, "middle seen too long"),),
           kind="measurement"),
    effect("perspective", "Lengths near the ground are seen longer than lengths near the top.",
           {"observe": tilted}, (("k", "1", 0.02, -0.3, 0.3, "too long at the ground"),),
           kind="measurement"),
    effect("drag_crisis", "At speed the boundary layer turns turbulent and drag falls.",
           {"force": crisis},
           (("k", "1", 0.2, 0.0, 1.0, "drag coefficient lost"),
            ("Re", "1e5", 1.5, 0.3, 5.0, "Reynolds number of the crisis"))),
)  # fmt: skip
STAGES = (
    Stage("clock", ("clock_rate",), clock, open=True),
    Stage("force", ("F",), gravity, open=True),
    Stage("inertia", ("m_air",), None, open=True),
    Stage("rates", ("h", "w"), motion),
    Stage("observe", ("height",), seen, open=True),
)
CONSTANTS = ("m", "A", "rho", "h0", "second")
COEFFICIENTS = (Parameter("g", "m/s2", GRAVITY, 9.78, 9.84, "gravity, anywhere on the ground"),)
SYSTEM = System("ball_drops", ("h", "w"), CONSTANTS, (), COEFFICIENTS, STAGES, ("height",), EFFECTS)

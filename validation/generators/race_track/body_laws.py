"""Forces on core and tail, in axes of the core: (force in N, complex; moment in N m).

Sources beside the functions. D0: reference drag of the robot; V0: its reference speed.
"""

from __future__ import annotations

import numpy as np

from .form import Family, Flow, reference
from .robots import DENSITY, Array, Robot

Loads = tuple[Array, Array | float]
NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)


def _power_drag(flow: Flow, robot: Robot, size: float, power: float) -> Loads:
    """Size D0 (V/V0)^power against the motion."""
    return size * robot.drag * reference(flow, robot) ** power * flow.backward, 0.0


def stokes(flow: Flow, robot: Robot, size: float, _shape: float) -> Loads:
    """Drag as V: creeping flow about wires and gaps; G. G. Stokes, 1851."""
    return _power_drag(flow, robot, size, 1.0)


def blasius(flow: Flow, robot: Robot, size: float, _shape: float) -> Loads:
    """Drag as V^1.5: laminar boundary layer; H. Blasius, Z. Math. Phys. 56 (1908)."""
    return _power_drag(flow, robot, size, 1.5)


def abraham(flow: Flow, robot: Robot, size: float, shape: float) -> Loads:
    """What (1 + d / sqrt Re)^2 adds to V^2: terms V^1.5 and V.

    F. F. Abraham, Physics of Fluids 13 (1970) 2194.
    """
    thick = 0.3 + 0.5 * shape
    x = reference(flow, robot)
    drag = (2 * x**1.5 + thick * x) / (2 + thick)
    return size * robot.drag * drag * flow.backward, 0.0


def wave_fourth(flow: Flow, robot: Robot, size: float, _shape: float) -> Loads:
    """Wave resistance as V^4 below the hump."""
    return _power_drag(flow, robot, size, 4.0)


def wave_sixth(flow: Flow, robot: Robot, size: float, _shape: float) -> Loads:
    """Wave resistance as V^6 far below the hump; J. N. Newman, Marine Hydrodynamics (1977) 6.17."""
    return _power_drag(flow, robot, size, 6.0)


def wave_havelock(flow: Flow, robot: Robot, size: float, shape: float) -> Loads:
    """Size D0 x^2 exp(-c (1/x^2 - 1)), c = 2 g d / V0^2 of a submerged body.

    T. H. Havelock, Proc. R. Soc. A 131 (1931) 275; c of the robot's depth is held to 1.2 to 2.5.
    """
    c = np.clip(2 * 9.81 * robot.keypoint_depth / robot.speed**2, 1.2, 2.2 + 0.3 * shape)
    x2 = reference(flow, robot) ** 2 + 1e-6
    return size * robot.drag * x2 * np.exp(-c * (1 / x2 - 1)) * flow.backward, 0.0


def dry(flow: Flow, robot: Robot, size: float, _shape: float) -> Loads:
    """Friction of constant size, rounded at rest."""
    return size * robot.drag * np.tanh(flow.speed / (0.03 * robot.speed)) * flow.backward, 0.0


def stribeck(flow: Flow, robot: Robot, size: float, shape: float) -> Loads:
    """Friction that is larger at low speed; B. Armstrong-Helouvry, Automatica 30 (1994) 1083."""
    x = reference(flow, robot)
    level = (1 + (0.3 + shape) * np.exp(-((x / 0.2) ** 2))) * np.tanh(x / 0.04)
    return size * robot.drag * level * flow.backward, 0.0


def saturating(flow: Flow, robot: Robot, size: float, shape: float) -> Loads:
    """V / (V + c): surface film and cable."""
    x = reference(flow, robot)
    return size * robot.drag * x / (x + 0.05 + 0.1 * shape) * flow.backward, 0.0


def _rates(flow: Flow, robot: Robot) -> tuple[float, Array]:
    """Reference moment (N m), and yaw rate over V0 / (2 L)."""
    return 0.2 * robot.drag * robot.body_length, flow.r * 2 * robot.body_length / robot.speed


def damping_linear(flow: Flow, robot: Robot, size: float, _shape: float) -> Loads:
    """Yaw damping as r."""
    moment, rate = _rates(flow, robot)
    return 0j * flow.v, -size * moment * rate


def damping_laminar(flow: Flow, robot: Robot, size: float, _shape: float) -> Loads:
    """Yaw damping as r^1.5: laminar friction of a turning body (as `blasius`)."""
    moment, rate = _rates(flow, robot)
    return 0j * flow.v, -size * moment * rate * np.sqrt(np.abs(rate))


def damping_speed(flow: Flow, robot: Robot, size: float, _shape: float) -> Loads:
    """Yaw damping as V r; K. Nomoto, Int. Shipbuilding Progress 4 (1957) 354."""
    moment, rate = _rates(flow, robot)
    return 0j * flow.v, -size * moment * rate * reference(flow, robot)


def _strips(flow: Flow, robot: Robot, size: float, *, power: float, taper: float) -> Loads:
    """-(rho/2) C h w |w|^(power - 1) V0^(2 - power) along core and tail, 6 Gauss points."""
    half = 0.5 * (robot.aft + robot.hinge_to_com)
    along = robot.hinge_to_com - half + half * NODES
    height = robot.head_span * (1 - taper * np.abs(NODES) ** 2)
    w = flow.v.imag + flow.r * along[:, None]
    load = -0.5 * DENSITY * size * w * (np.abs(w) + 1e-9) ** (power - 1)
    load = load * robot.speed ** (2 - power) * (WEIGHTS * half * height)[:, None]
    return 1j * load.sum(0), (load * along[:, None]).sum(0)


def crossflow_flat(flow: Flow, robot: Robot, size: float, _shape: float) -> Loads:
    """Strips of equal height; H. J. Allen, NACA RM A9I26 (1949)."""
    return _strips(flow, robot, size, power=2.0, taper=0.0)


def crossflow_tapered(flow: Flow, robot: Robot, size: float, shape: float) -> Loads:
    """Strips lower at the ends; O. M. Faltinsen, Hydrodynamics of High-Speed Vehicles (2005) 10."""
    return _strips(flow, robot, size, power=2.0, taper=0.4 + 0.5 * shape)


def crossflow_reynolds(flow: Flow, robot: Robot, size: float, shape: float) -> Loads:
    """Strips with a coefficient that falls with Reynolds number, power 1.65 to 1.85."""
    return _strips(flow, robot, size, power=1.65 + 0.2 * shape, taper=0.2)


def _gaps(flow: Flow, robot: Robot) -> tuple[Array, Array]:
    """Gaps to the four walls over the body length, (4, columns); directions to them, core axes."""
    length, width = flow.pool
    away = np.array([flow.z.real, length - flow.z.real, flow.z.imag, width - flow.z.imag])
    to_wall = np.array([-1, 1, -1j, 1j])[:, None] * np.exp(-1j * flow.psi)
    return np.maximum(away / robot.body_length, 0.15), to_wall


def wall_drag(flow: Flow, robot: Robot, size: float, shape: float) -> Loads:
    """Drag that rises as exp(-gap / length) near walls."""
    gaps, _ = _gaps(flow, robot)
    near = np.exp(-gaps / (0.4 + 0.4 * shape)).sum(0)
    return 3 * size * robot.drag * reference(flow, robot) ** 2 * near * flow.backward, 0.0


def wall_suction(flow: Flow, robot: Robot, size: float, shape: float) -> Loads:
    """Suction to the wall and bow-out moment of an image body, inverse square of the gap.

    J. N. Newman, J. Ship Research 9 (1965), as fitted by P. Norrbin, 10th ONR Symposium (1974).
    """
    gaps, to_wall = _gaps(flow, robot)
    pull = size * robot.drag * reference(flow, robot) ** 2 * 0.5 / (gaps + 0.3) ** 2
    side = (pull * to_wall.imag * np.abs(to_wall.imag)).sum(0)
    return 1j * side, -side * (0.1 + 0.2 * shape) * robot.body_length


def wall_cushion(flow: Flow, robot: Robot, size: float, shape: float) -> Loads:
    """A Gaussian cushion that pushes the bow away and brakes."""
    gaps, to_wall = _gaps(flow, robot)
    near = 2 * size * robot.drag * reference(flow, robot) ** 2
    near = near * np.exp(-((gaps / (0.6 + 0.4 * shape)) ** 2))
    side = -(near * to_wall.imag).sum(0)
    return 1j * side + near.sum(0) * flow.backward, side * 0.15 * robot.body_length


FAMILIES = (
    Family("viscous_drag", "force", "share_of_drag", "1", 0.03, 3.0,
           {"stokes": stokes, "blasius": blasius, "abraham": abraham}),
    Family("wave_drag", "force", "share_of_drag", "1", 0.03, 4.0,
           {"fourth": wave_fourth, "sixth": wave_sixth, "havelock": wave_havelock}),
    Family("coulomb_friction", "force", "share_of_drag", "1", 0.01, 0.3,
           {"dry": dry, "stribeck": stribeck, "saturating": saturating}),
    Family("linear_yaw_damping", "force", "share_of_moment", "1", 0.03, 6.0,
           {"linear": damping_linear, "laminar": damping_laminar, "speed": damping_speed}),
    Family("crossflow_drag", "force", "coefficient", "1", 0.05, 4.0,
           {"flat": crossflow_flat, "tapered": crossflow_tapered, "reynolds": crossflow_reynolds}),
    Family("wall_effect", "force", "share_of_drag", "1", 0.03, 3.0,
           {"drag": wall_drag, "suction": wall_suction, "cushion": wall_cushion}),
)  # fmt: skip

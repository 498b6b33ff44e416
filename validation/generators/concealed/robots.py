"""Robots of other dimensions, with coefficients of their own; half of them swim straight."""

import numpy as np

from bluekoi.synthetic.ground_truth_physics import Recoil, Robot
from validation.generators.concealed.swimmer.inputs import BodyParameters, HiddenLaws

__all__ = ["draw_body", "draw_fin", "draw_recoil", "draw_robot"]


def draw_robot(rng: np.random.Generator) -> Robot:
    """The published robot or, as often, one of other size and proportions."""
    if rng.random() < 0.5:
        return Robot()
    L = rng.uniform(0.26, 0.40)
    mass = 0.68 * (L / 0.331) ** 3 * rng.uniform(0.85, 1.15)
    reported = {
        "mass_kg": mass,
        "yaw_inertia_kg_m2": mass * L**2 * rng.uniform(0.11, 0.14),
        "body_length_m": L,
        "head_length_m": L * rng.uniform(0.33, 0.39),
        "head_span_m": L * rng.uniform(0.19, 0.23),
        "hinge_to_com_m": L * rng.uniform(0.10, 0.14),
        "tail_length_m": L * rng.uniform(0.18, 0.22),
        "keypoint_depth_m": rng.uniform(0.03, 0.05),
    }
    return Robot(**{name: round(float(value), 5) for name, value in reported.items()})


def draw_body(rng: np.random.Generator, robot: Robot) -> BodyParameters:
    """Coefficients about those of Table I, scaled to the robot's length."""
    scale = robot.body_length_m / 0.331

    def about(value: float, spread: float) -> float:
        return float(value * rng.uniform(1 - spread, 1 + spread))

    return BodyParameters(
        mass_kg=robot.mass_kg,
        yaw_inertia_kg_m2=robot.yaw_inertia_kg_m2,
        body_length_m=robot.body_length_m,
        head_1x_m=robot.head_length_m,
        head_span_m=robot.head_span_m,
        hinge_to_com_m=robot.hinge_to_com_m,
        tail_length_m=robot.tail_length_m,
        C_T=about(4.5e-3, 0.2) * scale**2,
        C_D0=about(0.5, 0.2),
        C_Da=about(2.5, 0.4),
        C_La=about(3.14, 0.12),
        C_Ma=about(0.1, 0.3) * scale,
        C_Md=about(0.13, 0.2) * scale**5,
        pulse=float(rng.uniform(0.2, 0.6)),
    )


def draw_fin(rng: np.random.Generator, robot: Robot) -> HiddenLaws:
    """Laws of core and tail as a fin that lets the robot swim straight, at a point or in strips."""
    scale = robot.body_length_m / 0.331
    strips = rng.random() < 0.5
    return HiddenLaws(
        fin_m2=float(rng.uniform(0.02, 0.035)) * scale**2,
        fin_arm_m=float(rng.uniform(0.10, 0.15)) * scale,
        fin_spread_m=0.045 * scale if strips else 0.0,
    )


def draw_recoil(rng: np.random.Generator) -> Recoil:
    """Sway and heading that the beating tail forces on the body."""
    return Recoil(
        sway_m=float(rng.uniform(0.001, 0.004)),
        heading_rad=float(np.radians(rng.uniform(0.5, 1.8))),
        lag_rad=float(rng.uniform(0.8, 1.6)),
    )

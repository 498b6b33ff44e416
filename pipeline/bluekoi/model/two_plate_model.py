"""The two-plate model: equations of motion, observation model, and the effects of the folders."""

from __future__ import annotations

import pkgutil
from dataclasses import replace
from functools import lru_cache
from importlib import import_module

from .. import effects, measurement, observation
from ..data import Float
from ..integrate import Effect, Parameter, Stage, System, effect_from_module
from ..observation import head_angle_error, tracking_error
from . import (
    disturbance,
    equations,
    periodic_forces,
    random_current,
    residual,
    servo_error,
    speed_peak_forces,
    tether,
)
from .similarity import (
    PUBLISHED_MASS_KG,
    PUBLISHED_ROBOT_SCALE_RATIOS,
    RobotScaleRatios,
    RobotSize,
    effect_scaled_to_robot,
    parameter_scaled_to_robot,
    robot_scale_ratios,
)

HYDRODYNAMIC_COEFFICIENTS = (
    Parameter("C_T", "m2", 4.5e-3, 1e-5, 0.2, "thrust over 1/2 rho A f^2"),
    Parameter("C_D0", "1", 0.5, 1e-3, 20.0, "profile drag"),
    Parameter("C_Da", "1", 2.0, -1.0, 40.0, "drag that comes with the angle of attack"),
    Parameter("C_La", "1", 3.14, -2.0, 40.0, "lift over sin 2 alpha"),
    Parameter("C_Ma", "m", 0.1, -1.0, 2.0, "moment over sin 2 alpha"),
    Parameter("C_Md", "kg m2", 0.12, 0.0, 5.0, "damping of the yaw rate squared"),
)
"""Coefficients of the published model with unit, start value, bounds and meaning, for the published
robot."""

EQUATION_OF_MOTION_STAGES = (
    Stage("actuation_inputs", ("phi", "f"), equations.actuation_inputs, open=True),
    Stage("ambient_flow", ("wx", "wy", "wr", "wd"), None, open=True),
    Stage("head", ("cphi", "sphi"), equations.head_angle_cos_sin),
    Stage(
        "flow",
        ("cpsi", "spsi", "uc", "vc", "rc", "rd", "uh", "vh", "V"),
        equations.relative_flow_velocities,
    ),
    Stage("thrust", ("T",), equations.thrust, open=True),
    Stage("head_plate_force", ("Xh", "Yh"), equations.head_plate_force, open=True),
    Stage("force", ("X", "Y", "N"), equations.force, open=True),
    Stage("inertia", ("mx", "my", "J"), equations.inertia, open=True),
    Stage("mobility", ("bx", "by", "bJ"), equations.inverse_inertias),
    Stage("core_turn_rate", ("core_turn_rate",), equations.core_turn_rate, open=True),
    Stage("rates", ("x", "y", "psi", "u", "v", "r"), equations.rigid_body_state_derivatives),
)
"""Equations of motion, in order."""
MODEL_EQUATION_STAGES = (
    observation.CLOCK_STAGE,
    *EQUATION_OF_MOTION_STAGES,
    observation.OBSERVATION_STAGE,
)

ROBOT_STATE_NAMES = ("x", "y", "psi", "u", "v", "r")
"""States: position in the pool, heading of the core, surge, sway, yaw rate."""
DYNAMICS_CONSTANT_NAMES = (
    "rho", "A", "A_ref", "l", "m", "I", "h", "span", "length", "x_hinge", "x_tail",
    "l_tail", "L_pool", "W_pool", "x0", "y0", "psi0", "phi0", "t_start", "length_unit",
    "speed_unit", "time_unit",
)  # fmt: skip
"""Constants of the equations of motion; those of the observation model follow them. The units are
those of the robot over those of the published one (`similarity`)."""
CONTROL_INPUT_NAMES = ("head_angle", "flap_hz")
"""Inputs: head angle and flapping frequency."""


def effect_names(package: object = effects) -> tuple[str, ...]:
    """Names of the effects (or measurement causes) in a folder, in alphabetical order."""
    found = pkgutil.iter_modules(package.__path__)  # type: ignore[attr-defined]
    return tuple(sorted(module.name for module in found))


@lru_cache(maxsize=1)
def all_effects() -> tuple[Effect, ...]:
    """Random processes, errors of single trials, residual terms, physical effects, measurement
    causes.
    """
    trial_errors = [servo_error, head_angle_error]
    modules = [disturbance, tracking_error, random_current, *trial_errors, residual] + [
        import_module(f"{package.__name__}.{name}")
        for package in (effects, measurement)
        for name in effect_names(package)
    ]
    found = tuple(effect_from_module(module, MODEL_EQUATION_STAGES) for module in modules)
    return (
        *found,
        *speed_peak_forces.RESIDUAL_FORCE_EFFECTS,
        *periodic_forces.RESIDUAL_FORCE_EFFECTS,
        *tether.RESIDUAL_FORCE_EFFECTS,
    )


def is_residual(label: str) -> bool:
    """Whether an effect, a term or a parameter belongs to the residual force."""
    return label.split(".", maxsplit=1)[0] in _residual_effect_names()


@lru_cache(maxsize=1)
def _residual_effect_names() -> frozenset[str]:
    return frozenset(effect.name for effect in all_effects() if effect.kind == residual.EFFECT_KIND)


@lru_cache(maxsize=64)
def two_plate_system(units: RobotScaleRatios = PUBLISHED_ROBOT_SCALE_RATIOS) -> System:
    """The paper's model with every effect that may extend it.

    units: of the robot, from which the parameters' starts, bounds and plausible magnitudes follow.
    """
    return System(
        name="plates",
        states=ROBOT_STATE_NAMES,
        constants=(*DYNAMICS_CONSTANT_NAMES, *observation.camera_error_constant_names()),
        inputs=CONTROL_INPUT_NAMES,
        coefficients=tuple(parameter_scaled_to_robot(p, units) for p in HYDRODYNAMIC_COEFFICIENTS),
        stages=MODEL_EQUATION_STAGES,
        observations=observation.OBSERVED_QUANTITIES,
        effects=tuple(effect_scaled_to_robot(e, units) for e in all_effects()),
        time_unit_s=units.time,
    )


def robot_system(robot: RobotSize) -> System:
    """`two_plate_system` with the starts, bounds and plausible magnitudes of a robot."""
    return two_plate_system(robot_scale_ratios(robot))


def robot_scale_ratios_of_trial(constants: Float) -> RobotScaleRatios:
    """`RobotScaleRatios` of the robot in a trial, by the constants (constants,) of the trial."""
    names = DYNAMICS_CONSTANT_NAMES
    mass, length, time = (
        float(constants[names.index(name)]) for name in ("m", "length_unit", "time_unit")
    )
    return RobotScaleRatios(mass / PUBLISHED_MASS_KG, length, time)


def trial_system(constants: Float) -> System:
    """`robot_system` of the robot in a trial, by the constants (constants,) of the trial, with the
    bounds that they set (`Parameter.bounded_by`).
    """
    system = two_plate_system(robot_scale_ratios_of_trial(constants))
    values = dict(zip(system.constants, map(float, constants), strict=True))
    bounds = tuple(values[name] for name in _bounding_constants(system))
    return _system_with_parameter_bounds(system, bounds)


def _bounding_constants(system: System) -> tuple[str, ...]:
    """Names of the constants that bound a parameter of an effect."""
    return tuple(name for e in system.effects for p in e.parameters for name in p.bounded_by or ())


@lru_cache(maxsize=64)
def _system_with_parameter_bounds(system: System, bounds: tuple[float, ...]) -> System:
    """A system whose effects have parameters between bounds, those of `_bounding_constants`."""
    values = dict(zip(_bounding_constants(system), bounds, strict=True))
    return replace(system, effects=tuple(
        replace(e, parameters=tuple(p.with_trial_bounds(values) for p in e.parameters))
        if any(p.bounded_by for p in e.parameters) else e
        for e in system.effects
    ))  # fmt: skip

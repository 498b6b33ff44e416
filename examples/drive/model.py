"""A linear drive: M v' = motor force - viscous friction; what else holds it back?

Source: Janot, Gautier and Brunot, Workshop on Nonlinear System Identification Benchmarks (2019)
(the electro-mechanical positioning system); Armstrong-Helouvry, Dupont and Canudas de Wit,
Automatica 30 (1994), 1083 (laws of friction).
"""

from bluekoi.explain import Cause, Input, Model, Observation, Parameter, Stage, State


def viscous(v: float, F_v: float) -> tuple[float]:
    """Viscous friction (N)."""
    return (-F_v * v,)


def motion(v: float, motor: float, F: float, M: float) -> tuple[float, float]:
    """X' = v, v' = (motor + F) / M."""
    return v, (motor + F) / M


def encoder(x: float) -> tuple[float]:
    """The position that the encoder reads (m)."""
    return (x,)


def coulomb(v: float, F_c: float, v_s: float) -> tuple[float]:
    """F = -F_c sign v, smooth within v_s."""
    return (-F_c * v / (v * v + v_s * v_s) ** 0.5,)


def offset(F_0: float) -> tuple[float]:
    """F = F_0."""
    return (F_0,)


def quadratic(v: float, k: float) -> tuple[float]:
    """F = -k v |v|."""
    return (-k * v * abs(v),)


def spring(x: float, k: float) -> tuple[float]:
    """F = -k x."""
    return (-k * x,)


def gain(motor: float, k: float) -> tuple[float]:
    """F = k motor."""
    return (k * motor,)


MODEL = Model(
    name="drive",
    states=(State("x", "m", 1e-3, observed="position"),
            State("v", "m/s", 0.05, rate_of="position")),
    inputs=(Input("motor", "N", held=True),),
    observations=(Observation("position", "m", 1e-5),),
    coefficients=(Parameter("M", "kg", 100.0, 1.0, 1000.0, "moving mass"),
                  Parameter("F_v", "N s/m", 200.0, 0.0, 2000.0, "viscous friction")),
    stages=(Stage("force", ("F",), viscous, open=True),
            Stage("rates", ("x", "v"), motion),
            Stage("observe", ("position",), encoder)),
    causes=(
        Cause("coulomb_friction", "Dry friction, the same at every speed.", {"force": coulomb},
              (Parameter("F_c", "N", 10.0, 0.0, 200.0, "friction force"),
               Parameter("v_s", "m/s", 0.003, 0.0005, 0.03, "speed of the transition", 0.003))),
        Cause("offset", "A constant force, or a current sensor that is off zero.",
              {"force": offset}, (Parameter("F_0", "N", 5.0, -100.0, 100.0, "force"),)),
        Cause("quadratic_drag", "Drag grows with the square of the speed.", {"force": quadratic},
              (Parameter("k", "N s2/m2", 200.0, 0.0, 10000.0, "drag at 1 m/s"),)),
        Cause("spring", "A force that grows with the position, as of a cable.", {"force": spring},
              (Parameter("k", "N/m", 20.0, -1000.0, 1000.0, "stiffness"),)),
        Cause("motor_gain", "The motor is stronger in one direction.",
              {"force": gain}, (Parameter("k", "1", 0.05, -0.9, 0.9, "extra force"),),
              kind="measurement"),
    ),
)  # fmt: skip

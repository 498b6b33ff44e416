"""Forms that change the head plate's coefficients, the inertia or the centre of mass.

A law of stage `coefficients` maps (C_L, C_D, C_M) to new ones; `inertia` returns added masses;
`centre` returns the shift of the centre of mass in core axes. Sources: Thwaites (1960) for
Kirchhoff flow past a plate, Leishman and Beddoes (1989), Goman and Khrabrov (1994), R. T. Jones
(1940) for Wagner's function, Lamb (1932) and Newman (1977) for added mass.
"""

import numpy as np

from .form import Form, family
from .laws_body import logistic


def _lift_loss(C, factor):
    return C[0] * factor, C[1], C[2]


def _kirchhoff(attached, p):
    """1 - amp (1 - ((1 + sqrt f) / 2)^2) for the attached share f of the plate."""
    return 1 - p.amp * (1 - ((1 + np.sqrt(np.clip(attached, 0, 1))) / 2) ** 2)


def _attached(s, p):
    return 1 - logistic((np.abs(s.alpha) - p.onset) / 0.05)


def _beddoes(s, p):
    x = (np.abs(s.alpha) - p.onset) / 0.08
    return np.where(
        x < 0, 1 - 0.3 * np.exp(np.minimum(x, 0)), 0.04 + 0.66 * np.exp(-np.maximum(x, 0))
    )


def _goman_rates(s, p):
    return ((_attached(s, p) - s.memory[0]) * s.V / (p.delay * s.head))[None]


def _moment_stall(s, p, C):
    """Centre of pressure moves aft by amp quarter heads past the onset; force unchanged."""
    normal = C[0] * np.cos(s.alpha) + C[1] * np.sin(s.alpha)
    return C[0], C[1], C[2] + 0.25 * p.amp * s.head * normal * (1 - _attached(s, p)) * -1.0


_ONSET = {"onset": (0.12, 0.45, "rad")}
_STALL = {
    "smooth_step": (lambda s, p, C: _lift_loss(C, 1 - p.amp * (1 - _attached(s, p))), _ONSET),
    "kirchhoff": (lambda s, p, C: _lift_loss(C, _kirchhoff(_attached(s, p), p)), _ONSET),
    "leishman_beddoes": (lambda s, p, C: _lift_loss(C, _kirchhoff(_beddoes(s, p), p)), _ONSET),
    "goman_khrabrov": (
        lambda s, p, C: _lift_loss(C, _kirchhoff(s.memory[0], p)),
        {**_ONSET, "delay": (1.5, 6.0, "heads")},
        {"states": 1, "rates": _goman_rates},
    ),
    "moment_stall": (_moment_stall, _ONSET),
}
STALL = family("stall", "coefficients", ("loss", "1", lambda _b: 0.95), _STALL)

_WAGNER = ((0.165, 0.0455), (0.335, 0.3))
_THEODORSEN = ((0.308, 0.0965), (0.1916, 0.4555))


def _reduced_rate(s, p):
    """Semi-chords travelled per second, stretched by amp; bounded for the integrator."""
    return np.minimum(s.V / (0.5 * s.head * (p.amp + 1e-3)), 60.0)


def _indicial(table):
    """Law and rates of C_L = (1 - sum A) C_L + sum A z, z' = b (C_L - z) per semi-chord."""

    def law(s, _p, C):
        lagged = sum(A * (z - C[0]) for (A, _), z in zip(table, s.memory, strict=True))
        return C[0] + lagged, C[1], C[2]

    def rates(s, p):
        speed = _reduced_rate(s, p)
        return np.stack(
            [b * speed * (s.quasi[0] - z) for (_, b), z in zip(table, s.memory, strict=True)]
        )

    return law, rates


def _first_order(s, p):
    return (0.5 * _reduced_rate(s, p) * (s.quasi[0] - s.memory[0]))[None]


def _circulation_rates(s, p):
    return (0.5 * _reduced_rate(s, p) * (s.quasi[0] * s.V - s.memory[0]))[None]


_LAG = {
    "first_order": (
        lambda s, _p, C: (s.memory[0], C[1], C[2]),
        {},
        {"states": 1, "rates": _first_order},
    ),
    "wagner_jones": (_indicial(_WAGNER)[0], {}, {"states": 2, "rates": _indicial(_WAGNER)[1]}),
    "theodorsen": (
        _indicial(_THEODORSEN)[0],
        {},
        {"states": 2, "rates": _indicial(_THEODORSEN)[1]},
    ),
    "circulation": (
        lambda s, _p, C: (s.memory[0] / (s.V + 0.02 * s.b.speed_ref), C[1], C[2]),
        {},
        {"states": 1, "rates": _circulation_rates},
    ),
}
LAG = family("lift_lag", "coefficients", ("stretch", "1", lambda _b: 5.0), _LAG)


def _biased(p, C, side, drag=0.0):
    return C[0] * (1 + p.amp * side), C[1] * (1 + drag * p.amp * side), C[2]


_ASYMMETRY = {
    "step": lambda s, p, C: _biased(p, C, np.tanh(s.alpha / 0.01)),
    "tanh": (lambda s, p, C: _biased(p, C, np.tanh(s.alpha / p.knee)), {"knee": (0.1, 0.3, "rad")}),
    "large_alpha": (
        lambda s, p, C: _biased(
            p, C, np.sign(s.alpha) * logistic((np.abs(s.alpha) - p.onset) / 0.05)
        ),
        {"onset": (0.12, 0.35, "rad")},
    ),
    "with_drag": lambda s, p, C: _biased(p, C, np.tanh(s.alpha / 0.03), 1.0),
}
ASYMMETRY = family(
    "port_starboard_asymmetry",
    "coefficients",
    ("bias", "1", lambda _b: 0.4),
    _ASYMMETRY,
    signed=True,
)


def _slender(s, p, munk=1.0, surge=0.0):
    """Slender body: a22 = rho pi span^2 / 4 L, a66 = a22 L^2 / 12."""
    a22 = p.amp * s.b.slender_mass * s.b.length
    return {
        "a11": surge * a22,
        "a22": a22,
        "a26": 0.0,
        "a66": a22 * s.b.length**2 / 12,
        "munk": munk,
    }


def _ellipsoid(s, p):
    """Spheroid of the robot's mass: Lamb's factors for the slenderness drawn."""
    b = s.b
    k1, k2, k6 = 0.21 * p.thickness**1.4, 1 - 0.5 * p.thickness, (1 - p.thickness) ** 2
    return {
        "a11": p.amp * k1 * b.mass,
        "a22": p.amp * k2 * b.mass,
        "a26": 0.0,
        "a66": p.amp * k6 * b.mass * b.length**2 * (1 + p.thickness**2) / 20,
        "munk": 1.0,
    }


def _strip(s, p):
    """Strips along the core only, centred behind the centre of mass."""
    a22 = p.amp * s.b.slender_mass * s.b.aft
    return {
        "a11": 0.0,
        "a22": a22,
        "a26": -0.5 * a22 * s.b.aft,
        "a66": a22 * s.b.aft**2 / 3,
        "munk": 1.0,
    }


_ADDED_MASS = {
    "slender_body": _slender,
    "ellipsoid": (_ellipsoid, {"thickness": (0.15, 0.4, "1")}),
    "strip": _strip,
    "partial_munk": (lambda s, p: _slender(s, p, p.munk, 0.05), {"munk": (0.3, 0.8, "1")}),
}
ADDED_MASS = family("added_mass", "inertia", ("factor", "1", lambda _b: 1.3), _ADDED_MASS)


_CENTRE = {
    "fixed": lambda s, p: p.amp + 0j * s.phi,
    "with_phi": lambda s, p: p.amp * (1 - np.exp(-1j * s.phi)),
    "with_head_length": lambda s, p: p.amp * (0.3 + 1.4 * (s.head / s.b.head - 1)) + 0j * s.phi,
}
CENTRE = family(
    "centre_of_mass_shift",
    "centre",
    ("shift", "m", lambda b: 0.09 * b.length),
    _CENTRE,
    signed=True,
)

PLATE_FORMS: list[Form] = [*STALL, *LAG, *ASYMMETRY, *ADDED_MASS, *CENTRE]

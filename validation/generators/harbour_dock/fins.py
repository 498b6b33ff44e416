"""Tail fins (core and tail carrying side force), five laws from the literature.

In core axes u is the forward and v the port-side speed (m/s) through the water, the fin lies x (m)
behind the centre of mass and meets the sideways speed w = v - x r. K (kg/m) is its strength: every
form has the side force -K u w for small w. K and x are `fin_strength` and `fin_behind` of the
variants.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.random import Generator

from .engine import Here
from .law import Law, pick


def _local(here: Here) -> tuple[Any, Any, Any]:
    w = here.sideways - here.values["fin_behind"] * here.rate
    speed = np.sqrt(here.forward**2 + w**2) + 1e-9
    return w, speed, np.arctan2(w, np.abs(here.forward) + 1e-9)


def _speed_times_w(here: Here, _size: Any) -> tuple[Any, Any]:
    # lift with the local speed, as for rudders in inflow: Fossen (2011), Handbook of Marine
    # Craft Hydrodynamics, sec. 9 (F = K V w)
    w, speed, _ = _local(here)
    y = -here.values["fin_strength"] * speed * w
    return 1j * y, -here.values["fin_behind"] * y


def _polhamus(here: Here, _size: Any) -> tuple[Any, Any]:
    # leading-edge-suction analogy: C_N = K_p sin b cos b + K_v sin^2 b, Polhamus (1966),
    # NASA TN D-3767; K_v = pi and K_p = 2 (aspect ratio about 1.5)
    _, speed, b = _local(here)
    s = np.sin(b)
    y = -here.values["fin_strength"] * speed**2 * (s * np.cos(b) + np.pi / 2.0 * s * np.abs(s))
    return 1j * y, -here.values["fin_behind"] * y


def _lighthill(here: Here, _size: Any) -> tuple[Any, Any]:
    # momentum shed at the trailing edge: side force -m U w and surge force -m w^2 / 2,
    # Lighthill (1971), Proc. R. Soc. B 179, 125
    w, _, _ = _local(here)
    y = -here.values["fin_strength"] * np.abs(here.forward) * w
    return -0.5 * here.values["fin_strength"] * w**2 + 1j * y, -here.values["fin_behind"] * y


def _stalling(here: Here, _size: Any) -> tuple[Any, Any]:
    # free-stream control surface of low aspect ratio, losing lift beyond about 25 degrees:
    # Whicker & Fehlner (1958), DTMB Report 933 (lift normal to the local flow)
    _, speed, b = _local(here)
    lost = 1.0 / (1.0 + np.exp(-(np.abs(b) - np.deg2rad(27.0)) / np.deg2rad(4.0)))
    lift = -here.values["fin_strength"] * speed**2 * np.sin(b) * (1.0 - 0.5 * lost)
    y = lift * np.cos(b)
    return lift * np.sin(b) * np.sign(here.forward) + 1j * y, -here.values["fin_behind"] * y


def _induced(here: Here, _size: Any) -> tuple[Any, Any]:
    # lifting fin with its own induced drag C_L^2 / (pi AR e): Hoerner & Borst (1975),
    # Fluid-Dynamic Lift, ch. 17 (AR 1.5, e 0.85, slope 2.2 per rad)
    w, _, _ = _local(here)
    y = -here.values["fin_strength"] * np.abs(here.forward) * w
    drag = here.values["fin_strength"] * 2.2 / (np.pi * 1.5 * 0.85) * w**2
    return -drag + 1j * y, -here.values["fin_behind"] * y


FORMS = {
    "speed_times_sideways": _speed_times_w,
    "polhamus_suction": _polhamus,
    "lighthill_trailing_edge": _lighthill,
    "low_aspect_stalling": _stalling,
    "lift_with_induced_drag": _induced,
}


def make_fin(rng: Generator, strength: float, behind: float) -> Law:
    """A fin law; strength in kg/m, place behind the centre of mass in m.

    Both act through the variants, not through the size.
    """
    form = pick(rng, *FORMS)
    return Law(
        name="tail_fin_lift",
        form=form,
        key="K",
        unit="kg m^-1",
        size=strength,
        largest=strength,
        hooks={"force": FORMS[form]},
        extra={"x_fin_behind_com": (behind, "m")},
        channels=("sway", "yaw"),
    )

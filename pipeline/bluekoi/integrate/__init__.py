"""Compiled fixed-step simulation and filtering of any state-space model and its effects."""

from ..vectors import prefer_widest
from .kernel import LANES, Kernel, compiled, kernel_folder
from .system import Effect, Parameter, Stage, System, effect_from_module

__all__ = [
    "LANES",
    "Effect",
    "Kernel",
    "Parameter",
    "Stage",
    "System",
    "compiled",
    "effect_from_module",
    "kernel_folder",
]

prefer_widest()

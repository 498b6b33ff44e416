"""Compiled fixed-step simulation and filtering of any state-space model and its effects."""

from ..numba_settings import prefer_widest_vectors
from .array_arguments import elementwise
from .compiled_system import LANES, CompiledSystem, compile_system, kernel_folder
from .system import Effect, Parameter, Stage, System, effect_from_module

prefer_widest_vectors()

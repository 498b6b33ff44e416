"""Compiled right-hand side, integrator and filter of a system, sixteen simulations at a time.

The functions of a system and its effects are put together into source files
(`kernel_code_generation`), named after the hash of all sources that go into them, and compiled by
numba with its cache when they are first asked for: a changed effect gives a new file, an unchanged
one is loaded. Everything a simulation needs lies in one flat array of rows of 16 lanes (16
simulations), at offsets that are constants of the source, so that each loop over lanes becomes
vector instructions.
"""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from threading import RLock
from types import ModuleType
from typing import Any

import numpy as np

from ..errors import input_error
from ..files import write_text
from . import branchless
from .kernel_code_generation import kernel_source
from .row_layout import LANES
from .stage_dependencies import STOCHASTIC_EFFECT_KIND
from .system import Function, System

__all__ = ["LANES", "CompiledSystem", "compile_system"]

_LOADING_LOCK = RLock()
"""Held while a kernel is written and loaded, so that two threads do not compile the same; nor may
two of them parse Python at once (3.11: "AST constructor recursion depth mismatch").
"""


@dataclass(frozen=True)
class _KernelFunctions:
    """Functions of one kernel; see `kernel_template.txt` for their arguments."""

    propagate: Callable[..., None]
    compiled_filter: Callable[[], Callable[..., float]]

    @cached_property
    def kalman(self) -> Callable[..., float]:
        """The filter, compiled when it is first asked for."""
        return self.compiled_filter()


@dataclass(frozen=True)
class CompiledSystem:
    """Compiled simulation and filter of one system, each compiled when first called.

    Two kernels are behind it: a fast one, and one for where more than random parts is on.
    """

    system: System

    def propagate(self, *given: Any) -> None:
        """Simulate; arguments as in `kernel_template.txt`, `on` the ninth."""
        self._kernel_for_active_effects(given[8]).propagate(*given)

    def kalman(self, *given: Any) -> float:
        """Log likelihood of one trial; arguments as in `kernel_template.txt`, `on` the 13th."""
        return self._kernel_for_active_effects(given[12]).kalman(*given)

    def _kernel_for_active_effects(self, on: np.ndarray) -> _KernelFunctions:
        """The kernel for the effects that are on."""
        return self._general_kernel if on[self._deterministic_effects].any() else self._fast_kernel

    @cached_property
    def _deterministic_effects(self) -> np.ndarray:
        """Which effects are more than random parts, (effects,)."""
        return np.array([e.kind != STOCHASTIC_EFFECT_KIND for e in self.system.effects], dtype=bool)

    @cached_property
    def _fast_kernel(self) -> _KernelFunctions:
        return _load_compiled(self.system, False)

    @cached_property
    def _general_kernel(self) -> _KernelFunctions:
        return _load_compiled(self.system, True)


@lru_cache(maxsize=32)
def compile_system(system: System) -> CompiledSystem:
    """CompiledSystem of a system, compiled once per change of its sources."""
    return CompiledSystem(system)


@lru_cache(maxsize=64)
def _load_compiled(system: System, general: bool) -> _KernelFunctions:
    with _LOADING_LOCK:
        return _write_and_load_kernel(system, general)


def _write_and_load_kernel(system: System, general: bool) -> _KernelFunctions:
    """A kernel written, where it was not yet, and loaded."""
    text = kernel_source(system, general=general)
    digest = hashlib.sha256(text.encode())
    for name in sorted(_source_files(system)):
        digest.update(Path(name).read_bytes())
    kind = "general" if general else "fast"
    name = f"bluekoi_{system.name}_{kind}_{digest.hexdigest()[:16]}"
    path = kernel_folder() / f"{name}.py"
    if not path.exists():
        write_text(path, text)
    module = load_source(name, path)
    return _KernelFunctions(module.propagate, module.compiled_filter)


def kernel_folder() -> Path:
    """Folder for the models' compiled code: in BLUEKOI_CACHE, else in the user's cache.

    Raises: InputError where there is none and none can be made.
    """
    default = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "bluekoi"
    folder = Path(os.environ.get("BLUEKOI_CACHE", default)) / "kernels"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        expected = "a folder for compiled code that can be written to"
        remedy = "Name one in the environment: BLUEKOI_CACHE=FOLDER."
        raise input_error(folder, "", f"'{error.strerror}'", expected, remedy) from error
    return folder


def load_source(name: str, path: Path) -> ModuleType:
    """The module in a source file, loaded once under a name."""
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"cannot load {path}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]  # half a module must not be found by the next call
        raise
    return module


def _stage_and_effect_functions(system: System) -> list[Function]:
    base = [stage.function for stage in system.stages if stage.function]
    own = [f for e in system.effects for f in (*e.hooks.values(), *([e.rates] if e.rates else []))]
    return base + own


def _source_files(system: System) -> set[str]:
    return {inspect.getfile(f) for f in _stage_and_effect_functions(system)} | {branchless.__file__}

"""Compiled right-hand side, integrator and filter of a system, sixteen simulations at a time.

The functions of a system and its effects are put together into one source file (`writing`), named
after the hash of all sources that go into it, and compiled by numba with its cache: a changed
effect gives a new file, an unchanged one is loaded. Everything a simulation needs lies in one flat
array of rows of 16 lanes (16 simulations), at offsets that are constants of the source, so that
each loop over lanes becomes vector instructions.
"""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import ModuleType

from ..files import write_text
from . import trigonometry
from .rows import LANES
from .system import Function, System
from .vectors import prefer_widest
from .writing import source

__all__ = ["LANES", "Kernel", "compiled"]


@dataclass(frozen=True)
class Kernel:
    """Compiled functions of one system; see `kernel_template.txt` for their arguments."""

    system: System
    propagate: Callable[..., None]
    kalman: Callable[..., float]


@lru_cache(maxsize=32)
def compiled(system: System) -> Kernel:
    """Kernel of a system, compiled once per change of its sources."""
    prefer_widest()
    text = source(system)
    digest = hashlib.sha256(text.encode())
    for name in sorted(_files(system)):
        digest.update(Path(name).read_bytes())
    name = f"bluekoi_{system.name}_{digest.hexdigest()[:16]}"
    path = _folder() / f"{name}.py"
    if not path.exists():
        write_text(path, text)
    module = _load(name, path)
    return Kernel(system, module.propagate, module.kalman)


def _folder() -> Path:
    default = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "bluekoi"
    folder = Path(os.environ.get("BLUEKOI_CACHE", default)) / "kernels"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _load(name: str, path: Path) -> ModuleType:
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"cannot load {path}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def _functions(system: System) -> list[Function]:
    base = [stage.function for stage in system.stages if stage.function]
    own = [f for e in system.effects for f in (*e.hooks.values(), *([e.rates] if e.rates else []))]
    return base + own


def _files(system: System) -> set[str]:
    return {inspect.getfile(f) for f in _functions(system)} | {trigonometry.__file__}

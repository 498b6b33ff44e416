"""The widest vectors that the processor has, for all that numba compiles from here on.

LLVM takes 256-bit vectors on processors with 512-bit ones, since on the first of these wide
instructions lowered the clock. For loops over sixteen simulations the wide ones are a quarter
faster. NUMBA_CPU_FEATURES, where it is set, is left as it is.
"""

from __future__ import annotations

from llvmlite import binding
from numba import config


def prefer_widest() -> None:
    """Tell numba's compiler; without effect once it has compiled something."""
    if config.CPU_FEATURES is not None:
        return
    features = binding.get_host_cpu_features()
    if features.get("avx512f"):
        config.CPU_FEATURES = f"{features.flatten()},-prefer-256-bit"

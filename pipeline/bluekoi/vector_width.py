"""The widest vectors that the processor has, for all that numba compiles from here on.

LLVM takes 256-bit vectors on processors with 512-bit ones, since on the first of these wide
instructions lowered the clock. For loops over sixteen simulations the wide ones are a quarter
faster. NUMBA_CPU_FEATURES, where it is set, is left as it is.

numba reads its settings when the first function of the process is declared, so each module takes
`njit` from here, whatever is imported first: code that one process compiled is then loaded by all.
Where functions of another package were declared before, their vectors stay (and all is a quarter
slower, not wrong).
"""

from __future__ import annotations

from llvmlite import binding
from numba import config, njit

__all__ = ["njit", "prefer_widest_vectors"]


def prefer_widest_vectors() -> None:
    """Tell numba's compiler; without effect once a function has been declared."""
    if config.CPU_FEATURES is not None:
        return
    features = binding.get_host_cpu_features()
    if features.get("avx512f"):
        config.CPU_FEATURES = f"{features.flatten()},-prefer-256-bit"


prefer_widest_vectors()

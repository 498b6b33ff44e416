"""Settings of numba for all that it compiles from here on: the processor's widest vectors, and
where compiled code is kept.

LLVM takes 256-bit vectors on processors with 512-bit ones, since on the first of these wide
instructions lowered the clock. For loops over sixteen simulations the wide ones are a quarter
faster. NUMBA_CPU_FEATURES, where it is set, is left as it is.

numba reads its settings when the first function of the process is declared, so each module takes
`njit` from here, whatever is imported first: code that one process compiled is then loaded by all.
Where functions of another package were declared before, their vectors stay (and all is a quarter
slower, not wrong).

Compiled code is kept beside the modules. Where these are in a folder that this user may not write,
it goes to BLUEKOI_CACHE, where that is set; otherwise numba takes the user's cache.
"""

from __future__ import annotations

import os
from pathlib import Path

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


def keep_compiled_code_in_own_cache() -> None:
    """Set numba's folder to BLUEKOI_CACHE/numba, if the package's folder is read-only."""
    own = os.environ.get("BLUEKOI_CACHE")
    if own and not config.CACHE_DIR and not os.access(Path(__file__).parent, os.W_OK):
        config.CACHE_DIR = str(Path(own) / "numba")


keep_compiled_code_in_own_cache()
prefer_widest_vectors()

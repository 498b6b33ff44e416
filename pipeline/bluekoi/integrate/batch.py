"""Batches of simulations: plain arrays in, observations and states out, both cores used."""

from __future__ import annotations

import itertools
import os
import threading
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from functools import lru_cache
from typing import Any

import numpy as np

from ..data import Float
from ..numba_settings import njit
from .compiled_system import LANES, CompiledSystem
from .system import System

MAX_INTEGRATION_STEP_S = 1 / 60
"""Longest integration step, to 1 %: error of the paper's model below 0.01 mm over 8 s (tests)."""


def active_effects(system: System, values: Float) -> np.ndarray:
    """Which effects any of the parameter vectors `(..., parameters)` uses, uint8 `(effects,)`."""
    return _active_effects_by_block(system, values.reshape(1, -1, values.shape[-1]).swapaxes(1, 2))[
        0
    ]


def active_effects_by_parameter_vector(system: System, values: Float) -> np.ndarray:
    """Which effects each of the parameter vectors (n, parameters) uses, uint8 (n, effects)."""
    return _active_effects_by_block(system, values[:, :, None])


def _active_effects_by_block(system: System, values: Float) -> np.ndarray:
    """Which effects each block of parameter vectors (blocks, parameters, n) uses, uint8 (blocks,
    effects).
    """
    slots, first = system.strength_parameter_indices
    ends = np.append(first[1:], len(slots)) if len(slots) else first
    out = np.zeros((len(values), len(first)), dtype=np.uint8)
    _mark_active_effects(np.ascontiguousarray(values, dtype=np.float64), slots, first, ends, out)
    return out


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc"})
def _mark_active_effects(
    values: Float, slots: np.ndarray, first: np.ndarray, ends: np.ndarray, out: np.ndarray
) -> None:
    """Set `out` (blocks, effects) to 1 where any strength of an effect is not 0 in any column of
    values (blocks, parameters, n); effect i has the places `slots[first[i] : ends[i]]`.
    """
    for b in range(len(values)):
        for i in range(len(first)):
            for k in range(first[i], ends[i]):
                total = 0.0  # a sum without a branch becomes vector instructions
                for j in range(values.shape[2]):
                    total += abs(values[b, slots[k], j])
                if total != 0.0:
                    out[b, i] = 1


def simulate_batch(
    kernel: CompiledSystem, state: Float, values: Float, constants: Float, *, times: Float,
    inputs: Float,
    frames: np.ndarray | None = None, seen: Float | None = None, gains: Float | None = None,
    keep_states: bool = False, step_s: float | None = None,
) -> tuple[Float, Float]:  # fmt: skip
    """Observations `(blocks, frames, observations, 16)` and states `(blocks, frames, states, 16)`.

    state (blocks, states, 16), values (blocks, parameters, 16), constants (blocks, constants, 16),
    times (blocks, frames), inputs (blocks, frames, inputs). With `seen` (blocks, frames,
    observations) and `gains` (blocks, frames, states, observations) each frame's state is
    corrected by the innovation; without, the simulation runs free. States only where asked for.
    step_s: longest step; without, the system's own, else `MAX_INTEGRATION_STEP_S`.
    """
    blocks, n = times.shape
    n_states, n_obs = len(kernel.system.all_states), len(kernel.system.observations)
    observed = np.empty((blocks, n, n_obs, LANES))
    states = np.zeros((blocks, n if keep_states else 0, n_states, LANES))
    counts = np.full(blocks, n) if frames is None else np.asarray(frames)
    seen = np.zeros((blocks, n, n_obs)) if seen is None else seen
    gains = np.zeros((blocks, 0, n_states, n_obs)) if gains is None else gains
    on = _active_effects_by_block(kernel.system, values)
    changes = np.flatnonzero((on[1:] != on[:-1]).any(axis=1)) + 1
    step_s = step_s or kernel.system.longest_step_s(MAX_INTEGRATION_STEP_S)
    flat = [np.ascontiguousarray(a, dtype=np.float64).ravel() for a in (state, values, constants)]
    times = np.ascontiguousarray(times, dtype=np.float64)
    rest = [np.ascontiguousarray(a, dtype=np.float64) for a in (inputs, seen, gains)]

    def run(first: int, last: int) -> None:
        inner = changes[(changes > first) & (changes < last)].tolist()
        for begin, end in itertools.pairwise([first, *inner, last]):  # blocks of the same effects
            kernel.propagate(
                *flat, times, counts.astype(np.int64), *rest, on[begin], step_s,
                observed.reshape(-1), states.reshape(-1), begin, end,
            )  # fmt: skip

    map_ranges_in_threads(run, blocks)
    return observed, states


def repeat_over_lanes(rows: Float) -> Float:
    """Rows (..., n) for every lane, (..., n, LANES)."""
    return np.repeat(rows[..., None], LANES, axis=-1)


def map_ranges_in_threads(run: Callable[[int, int], Any], count: int) -> None:
    """Call `run(first, last)` over 0..count in as many threads as there are cores to use."""
    workers = min(thread_count(), max(1, count // 4))
    edges = [count * part // workers for part in range(workers + 1)]
    threaded_map(lambda ends: run(*ends), list(itertools.pairwise(edges)))


def threaded_map(function: Callable[[Any], Any], items: Sequence[Any]) -> list[Any]:
    """`[function(item) for item in items]` with threads, for compiled functions without the GIL.

    The calling thread takes items as well. Within a call of `function` further calls run one after
    the other: the cores are taken.
    """
    if thread_count() < 2 or len(items) < 2 or getattr(_thread_state, "one", False):
        return [function(item) for item in items]
    todo = deque(enumerate(items))
    found: list[Any] = [None] * len(items)

    def take() -> None:
        _thread_state.one = True
        try:
            while (one := _pop_next_item(todo)) is not None:
                found[one[0]] = function(one[1])
        finally:
            _thread_state.one = False
            todo.clear()  # empty, unless a call has failed: then no other is begun

    others = min(thread_count(), len(items)) - 1
    helpers = [_thread_pool(os.getpid(), thread_count() - 1).submit(take) for _ in range(others)]
    try:
        take()
    finally:
        wait(helpers)
    for helper in helpers:
        helper.result()
    return found


def _pop_next_item(todo: deque[tuple[int, Any]]) -> tuple[int, Any] | None:
    try:
        return todo.popleft()
    except IndexError:
        return None


_thread_state = threading.local()


@lru_cache(maxsize=4)
def _thread_pool(process: int, workers: int) -> ThreadPoolExecutor:
    """Threads that live as long as the process: a forked one cannot use those of its parent."""
    return ThreadPoolExecutor(workers, thread_name_prefix=f"bluekoi-{process}")


def thread_count() -> int:
    """Threads to use: BLUEKOI_THREADS, or the cores this process may use."""
    given = os.environ.get("BLUEKOI_THREADS", "")
    return int(given) if given.isdigit() and int(given) > 0 else len(os.sched_getaffinity(0))

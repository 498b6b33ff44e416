"""What is random in a recording: pushes of the surroundings, and errors that last for a while.

Both are first-order processes, x' = -x / tau, whose size and memory are fitted to the recordings
(`bluekoi.fitting.fit_noise`). States are named g_1, g_2, ... (pushes) and e_1, e_2, ... (errors).
Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation
(2001), sec. 8.2.
"""

from __future__ import annotations

from collections.abc import Sequence

from bluekoi.integrate import Effect
from bluekoi.integrate.system import Function

from .effect import effect

Two = tuple[float, float]
Three = tuple[float, float, float]
Memory = tuple[float, float, float]
"""Start, least and longest time (s) within which a random state is forgotten."""


def push_1(g_1: float) -> tuple[float]:
    """The push itself."""
    return (g_1,)


def push_1_fades(g_1: float, tau: float) -> tuple[float]:
    """G' = -g / tau."""
    return (-g_1 / tau,)


def push_2(g_1: float, g_2: float) -> Two:
    """Two pushes."""
    return g_1, g_2


def push_2_fades(g_1: float, g_2: float, tau: float) -> Two:
    """G' = -g / tau."""
    return -g_1 / tau, -g_2 / tau


def push_3(g_1: float, g_2: float, g_3: float) -> Three:
    """Three pushes."""
    return g_1, g_2, g_3


def push_3_fades(g_1: float, g_2: float, g_3: float, tau: float) -> Three:
    """G' = -g / tau."""
    return -g_1 / tau, -g_2 / tau, -g_3 / tau


def error_1(e_1: float) -> tuple[float]:
    """The error is seen as if it were motion."""
    return (e_1,)


def error_1_fades(e_1: float, tau_e: float) -> tuple[float]:
    """E' = -e / tau_e."""
    return (-e_1 / tau_e,)


def error_2(e_1: float, e_2: float) -> Two:
    """Errors of two observations."""
    return e_1, e_2


def error_2_fades(e_1: float, e_2: float, tau_e: float) -> Two:
    """E' = -e / tau_e."""
    return -e_1 / tau_e, -e_2 / tau_e


def error_3(e_1: float, e_2: float, e_3: float) -> Three:
    """Errors of three observations."""
    return e_1, e_2, e_3


def error_3_fades(e_1: float, e_2: float, e_3: float, tau_e: float) -> Three:
    """E' = -e / tau_e."""
    return -e_1 / tau_e, -e_2 / tau_e, -e_3 / tau_e


_PUSHES: dict[int, tuple[Function, Function]] = {
    1: (push_1, push_1_fades), 2: (push_2, push_2_fades), 3: (push_3, push_3_fades),
}  # fmt: skip
_ERRORS: dict[int, tuple[Function, Function]] = {
    1: (error_1, error_1_fades), 2: (error_2, error_2_fades), 3: (error_3, error_3_fades),
}  # fmt: skip


def pushes(statement: str, stage: str, channels: Sequence[str], tau: Memory) -> Effect:
    """Random pushes, added to the outputs of `stage`: one for each channel."""
    hook, rates = _PUSHES[len(channels)]
    return effect(
        "disturbance", statement, {stage: hook},
        (("present", "1", 1.0, 0.0, 1.0, "1 where they act"), ("tau", "s", *tau, "memory")),
        kind="disturbance", channels=tuple(channels), rates=rates,
        states=tuple(f"g_{i + 1}" for i in range(len(channels))),
    )  # fmt: skip


def lasting_errors(statement: str, count: int, tau: Memory) -> Effect:
    """Errors of the `count` observations that last for a while."""
    hook, rates = _ERRORS[count]
    return effect(
        "lasting_error", statement, {"observe": hook},
        (("present", "1", 1.0, 0.0, 1.0, "1 where they are"), ("tau_e", "s", *tau, "memory")),
        kind="disturbance", rates=rates, states=tuple(f"e_{i + 1}" for i in range(count)),
    )  # fmt: skip

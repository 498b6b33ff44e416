"""Functions of a model, written for one simulation, applied to arrays of arguments."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache, reduce
from types import FunctionType, SimpleNamespace
from typing import Any

import numpy as np

_NUMPY_MATH_NAMESPACE = SimpleNamespace(
    sqrt=np.sqrt, exp=np.exp, log=np.log, sin=np.sin, cos=np.cos, tanh=np.tanh,
    atan2=np.arctan2, hypot=np.hypot, pi=math.pi,
)  # fmt: skip


@lru_cache(maxsize=256)
def elementwise(function: Callable[..., Any]) -> Callable[..., Any]:
    """The same function for arrays: `min`, `max` and `math`, also in the functions that it calls,
    act on each element. It must not branch on its arguments.
    """
    if not isinstance(function, FunctionType):
        return function
    names = dict(function.__globals__)
    for name in function.__code__.co_names:
        called = names.get(name)
        if isinstance(called, FunctionType):
            names[name] = elementwise(called)
    names |= {"min": _elementwise_min, "max": _elementwise_max, "math": _NUMPY_MATH_NAMESPACE}
    return FunctionType(function.__code__, names, function.__name__, function.__defaults__)


def _elementwise_min(*values: Any) -> Any:
    return reduce(np.minimum, values)


def _elementwise_max(*values: Any) -> Any:
    return reduce(np.maximum, values)

"""What a fitted model foretells of the rest of a trial from its beginning, and how surely.

A free run (`bluekoi.fitting.shoot`) begins where whole trials suit it best; here the filter alone
says where a trial stands when the forecast begins, lasting errors and all, and nothing later is
used.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bluekoi.data import Float
from bluekoi.fitting import Noise, Series, filter_series, smooth
from bluekoi.fitting.filtering import with_noise
from bluekoi.integrate import LANES, Kernel
from bluekoi.integrate.batch import propagate


@dataclass(frozen=True)
class Forecast:
    """Times (n,); foretold observations, their deviations, and what was seen, (n, observations)."""

    times: Float
    foretold: Float
    std: Float
    seen: Float

    @property
    def mean_square(self) -> float:
        """Mean square error of the first observation."""
        return float(np.mean((self.foretold[:, 0] - self.seen[:, 0]) ** 2))

    @property
    def path_rms(self) -> float:
        """Root mean square distance between the first two observations seen and foretold."""
        apart = (self.foretold - self.seen)[:, :2]
        return float(np.sqrt(np.mean(np.sum(apart**2, axis=1))))

    @property
    def expected(self) -> float:
        """What `mean_square` should be by the stated deviations."""
        return float(np.mean(self.std[:, 0] ** 2))


def forecast(kernel: Kernel, one: Series, values: Float, noise: Noise, known_s: float) -> Forecast:
    """The rest of a trial from what was seen until `known_s`.

    With the predicted mean x and covariance P = L L' of a frame, y = h(x) and
    var y = sum over columns (h(x + L_j) - y)^2.
    """
    known = one.times <= known_s
    told = filter_series(
        kernel, replace(one, seen=np.where(known[:, None], one.seen, np.nan)), values, noise
    )
    mean, root = told.predicted[~known], _root(told.cov_predicted[~known])
    observed = _observed(kernel, mean, root, with_noise(kernel, values, noise), one)
    spread = observed[:, :, 1:] - observed[:, :, :1]
    std = np.sqrt(np.sum(spread**2, axis=2))
    return Forecast(one.times[~known], observed[:, :, 0], std, one.seen[~known])


def _root(cov: Float) -> Float:
    """L (n, states, states) with L L' = cov, columns of most variance first."""
    values, vectors = np.linalg.eigh(cov)
    return (vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :])[:, :, ::-1]


def _observed(kernel: Kernel, mean: Float, root: Float, values: Float, one: Series) -> Float:
    """Observations (n, observations, 16) at x, then at x + L_j."""
    n, states = mean.shape
    columns = min(states, LANES - 1)
    state = np.repeat(mean[:, :, None], LANES, axis=2)
    state[:, :, 1 : columns + 1] += root[:, :, :columns]
    observed, _ = propagate(
        kernel, state, _lanes(values, n), _lanes(one.constants, n),
        times=np.zeros((n, 1)), inputs=np.repeat(one.inputs[None, :1], n, axis=0),
    )  # fmt: skip
    return observed[:, 0]


def _lanes(vector: Float, blocks: int) -> Float:
    return np.tile(np.asarray(vector, dtype=float)[None, :, None], (blocks, 1, LANES))


def state_of(
    kernel: Kernel, one: Series, values: Float, noise: Noise, name: str
) -> tuple[float, float]:
    """A state at the first frame and its deviation, from all of the trial."""
    mean, cov = smooth(filter_series(kernel, one, values, noise))
    k = kernel.system.all_states.index(name)
    return float(mean[0, k]), float(np.sqrt(max(cov[0, k, k], 0.0)))

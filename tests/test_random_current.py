"""The random current: water that carries the robot, distinguished from random forces."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from bluekoi.data import Float
from bluekoi.fitting import (
    Noise,
    TrialSeries,
    estimate_noise_model,
    filter_all,
    parametric_bootstrap,
)
from bluekoi.fitting.linear import linearised_filter, log_likelihood
from bluekoi.integrate import CompiledSystem, compile_system
from bluekoi.integrate.batch import repeat_over_lanes, simulate_batch
from bluekoi.model import constants_of_robot_trial, two_plate_system
from bluekoi.observation import camera_error_inputs
from paper_robot import PAPER_SETUP
from simulated_campaigns import COEFFICIENTS

POSE_STD = np.array([2e-4, 2e-4, 3e-3, 5e-3])
NO_CURRENT = Noise(np.array([3e-3, 3e-3, 3e-4, 1e-5, 1e-5, 1e-4]),
                   np.array([0.5, 0.5, 0.5, 0.2, 0.2, 0.2]), np.ones(4))  # fmt: skip


@lru_cache(maxsize=1)
def _kernel() -> CompiledSystem:
    return compile_system(two_plate_system())


def _noise(forces: Float, current_m_s: float) -> Noise:
    still = NO_CURRENT.disturbance[3:]
    return Noise(np.concatenate([forces, still, [current_m_s] * 2]),
                 np.concatenate([NO_CURRENT.tau, [1.0, 1.0]]), np.ones(4))  # fmt: skip


def _trials(noise: Noise, *, seed: int) -> tuple[list[TrialSeries], list[Float]]:
    """Six turns of 12 s to both sides, drawn from the published model with a noise."""
    kernel, times = _kernel(), np.arange(0.0, 12.0, 0.1)
    states = len(kernel.system.all_states)
    frames = len(times)
    series = [
        TrialSeries(
            name=f"T{k}", group="100", condition="", times=times,
            inputs=np.tile([np.radians(angle), 4.5], (frames, 1)),
            constants=constants_of_robot_trial(PAPER_SETUP, 0.12,
                                               view=camera_error_inputs(PAPER_SETUP)),
            seen=np.zeros((frames, 4)), noise=np.tile(np.diag(POSE_STD**2), (frames, 1, 1)),
            mean=np.zeros(states), cov=np.diag([1e-6] * states),
        )
        for k, angle in enumerate((30.0, -30.0, 40.0, -40.0, 50.0, -50.0))
    ]  # fmt: skip
    values = [kernel.system.parameter_vector(COEFFICIENTS)] * len(series)
    drawn = parametric_bootstrap(kernel, series, values, [noise] * len(series),
                                 np.zeros((len(series), states)),
                                 np.random.default_rng(seed))  # fmt: skip
    return drawn, values


def test_a_robot_that_drifts_with_the_water_meets_no_force() -> None:
    """Constant current w: a robot without thrust that moves at w keeps its velocity."""
    kernel, states = _kernel(), len(_kernel().system.all_states)
    w = np.array([0.03, -0.02])
    state = np.zeros(states)
    state[3:5] = w
    state[[kernel.system.all_states.index(name) for name in ("w_x", "w_y")]] = w
    values = kernel.system.parameter_vector(
        COEFFICIENTS | {"C_T": 0.0}, {"random_current": {"present": 1.0, "tau": 1e9}}
    )
    fixed = constants_of_robot_trial(PAPER_SETUP, 0.12)
    times = np.linspace(0.0, 4.0, 41)
    _, run = simulate_batch(
        kernel, *(repeat_over_lanes(a[None]) for a in (state, values, fixed)), times=times[None],
        inputs=np.tile([np.radians(30.0), 4.5], (1, 41, 1)), keep_states=True,
    )  # fmt: skip
    assert run[0, -1, 3:5, 0] == pytest.approx(w, rel=1e-6)
    assert run[0, -1, :2, 0] == pytest.approx(4.0 * w, rel=1e-6)
    assert run[0, -1, 2, 0] == pytest.approx(0.0, abs=1e-9)


def test_a_current_is_not_estimated_as_random_forces() -> None:
    """Water of 4 mm/s; the estimate begins at forces of 3 mN. They become a tenth at most, which
    they do not without the current, and the trials are then e^100 times less likely.
    """
    seen, values = _trials(_noise(np.full(3, 1e-6), 0.004), seed=3)
    start = _noise(NO_CURRENT.disturbance[:3], 0.003)
    found = estimate_noise_model(_kernel(), seen, values, start, rounds=60)
    assert found.noise.disturbance[6:] == pytest.approx(0.004, rel=0.25)
    assert found.noise.tau[6] == pytest.approx(1.0, rel=0.4)
    assert (found.noise.disturbance[:3] < 0.1 * NO_CURRENT.disturbance[:3]).all()
    without = estimate_noise_model(_kernel(), seen, values, NO_CURRENT, rounds=60)
    assert without.noise.disturbance[1] > 0.3 * NO_CURRENT.disturbance[1]
    likelihoods = [sum(one.log_likelihood for one in way.passes) for way in (found, without)]
    assert likelihoods[0] - likelihoods[1] > 100.0


def test_random_forces_are_not_estimated_as_a_current() -> None:
    forces = np.array([2e-3, 3e-3, 3e-4])
    seen, values = _trials(_noise(forces, 1e-6), seed=4)
    found = estimate_noise_model(_kernel(), seen, values, _noise(0.5 * forces, 0.003), rounds=60)
    assert found.noise.disturbance[:3] == pytest.approx(forces, rel=0.5)
    assert (found.noise.disturbance[6:] < 0.001).all()


def test_a_filter_has_any_number_of_states() -> None:
    """Fin, lift lag and stall: 18 states, where a pass differences 15. Effects of negligible
    strength leave the likelihood and the motion's transitions as they are.
    """
    noise = _noise(NO_CURRENT.disturbance[:3], 0.003)
    seen, values = _trials(noise, seed=5)
    seen = [replace(one, mean=one.mean + 1e-6) for one in seen]
    slot = _kernel().system.parameter_index
    strengths = ("tail_fin_lift.lift_area", "lift_lag.lagging_share", "stall.lift_loss")
    more = [v.copy() for v in values]
    for v in more:
        v[[slot[name] for name in strengths]] = 1e-12
    few, many = (filter_all(_kernel(), seen, v, noise) for v in (values, more))
    own = slice(0, 14)
    for a, b in zip(few, many, strict=True):
        assert b.log_likelihood == pytest.approx(a.log_likelihood, abs=1e-4)
        assert b.transitions[:, own, own] == pytest.approx(a.transitions[:, own, own], abs=1e-6)
        assert np.count_nonzero(np.diagonal(b.transitions[1])) == 18
    linear = linearised_filter(_kernel(), seen, more, noise, many)
    assert linear.H.shape[-1] == 18
    assert log_likelihood(linear, noise) == pytest.approx(
        sum(one.log_likelihood for one in many), abs=0.5
    )

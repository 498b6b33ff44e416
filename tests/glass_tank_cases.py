"""Robots, trials, causes and forces of the glass tank's generator, for its tests."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from validation.generators.glass_tank import catalogue, laws_unlisted
from validation.generators.glass_tank.dynamics import Setting, loads
from validation.generators.glass_tank.form import Cause, Disturbance, Trials, give_rows
from validation.generators.glass_tank.robots import draw_robot

STILL = Disturbance(np.zeros((3, 1)), 0.0, 0.0)


def robot_of(seed, trials=6):
    rng = np.random.default_rng(seed)
    return rng, *draw_robot(rng, trials)


def cause_of(rng, robot, name, form, share=0.5):
    """A cause `share` of the way through the plausible range of its strength."""
    unlisted = name == "unlisted"
    family = laws_unlisted.unlisted_family(form, robot) if unlisted else catalogue.FAMILIES[name]
    cause = Cause(family, form, family.draw(rng, robot, form))
    low, high = catalogue.bounds(robot, cause)
    cause.strength = low * (high / low) ** share
    give_rows([cause])
    return cause


def trials_of(robot, phi, flap=1.0):
    n = len(phi)
    heads = np.full(n, robot.head_length)
    return Trials(robot.top_flap * flap * np.ones(n), phi, heads, np.zeros(n), np.zeros(n))


def random_states(rng, robot, n=40, memory=0):
    """States of motion in the pool, and their trials with the head at angles."""
    state = np.zeros((6 + memory, n))
    state[:2] = rng.uniform(0.1, 0.9, (2, n)) * np.array(robot.pool)[:, None]
    state[2] = rng.uniform(-3, 3, n)
    drift = np.exp(1j * (state[2] + rng.uniform(-0.6, 0.6, n)))
    velocity = robot.top_speed * rng.uniform(0.1, 1.2, n) * drift
    turn = robot.reference_yaw_rate * rng.uniform(-1.5, 1.5, n)
    state[3], state[4], state[5] = velocity.real, velocity.imag, turn
    state[6:] = rng.uniform(-0.3, 0.3, (memory, n))
    phi, flap = rng.choice([-0.7, -0.3, 0.3, 0.7], n), rng.uniform(0.5, 1, n)
    heading = state[2] - rng.choice([-1, 1], n) * rng.uniform(0, 14, n)
    trials = replace(trials_of(robot, phi, flap), heading=heading, session=rng.uniform(0, 1, n))
    return state, trials


def forces(state, trials, robot, coefficients, causes, t=3.0):
    parameters = [*coefficients, *(cause.strength for cause in causes)]
    setting = Setting(robot, trials, causes)
    return loads(np.full(state.shape[1], t), state, setting, parameters, STILL)

"""A roboticist's tank: keypoint studies with concealed physics or measurement errors.

Body-axes dynamics with quasi-steady forces, an adaptive embedded Runge-Kutta pair, a refracted
camera, Ornstein-Uhlenbeck tracking errors and uniform gusts of water.
"""

from validation.generators.quasi_steady.studies import generate

__all__ = ["generate"]

"""A rigid fish-like robot in a long basin, with hidden causes sized by an ideal detector.

The robot is one rigid body whose heading is that of the core; the head plate is the published one.
Laws are grouped by where they act: drive, head, body, place. Random accelerations of the water are
Ornstein-Uhlenbeck processes in core axes, and they are in the covariance of the detector
(`ideal`), together with correlated tracking errors and the error of the servo. The strength of a
hidden cause is set so that this detector sees it at 10 to 45 standard deviations.
"""

from .studies import generate

__all__ = ["generate"]

"""Studies of a fish-like robot swimming in still water of a wide flume, with hidden causes.

The state of motion is that of the centre of mass and the core direction; the head plate carries the
published forces. Water motion is a second-order filtered random acceleration in fixed axes.
The strength of a hidden cause is set with the Fisher information of a Kalman filter (`detector`).
"""

from .studies import generate

__all__ = ["generate"]

"""Studies of the flat-plate swimmer in a tank filmed from above, with hidden causes.

The motion is that of the published model with Kirchhoff's added mass where a cause asks for it,
integrated by Kutta's 3/8 rule. A cause acts at one or more places of the equations or of the
measurement (`form`). The strength of a hidden cause is set with the Fisher information of a Kalman
filter linearised about the true path (`detector`).
"""

from .study import generate

__all__ = ["generate"]

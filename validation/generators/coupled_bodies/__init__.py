"""Two rigid bodies, head and core with tail, joined by a servo hinge; studies with hidden content.

The head carries interpolated polars over the full circle of angles of attack; the published plate
is the default polar, so that a robot with nothing hidden swims as the published model. The water
is a sum of random Fourier modes, the camera casts rays through a flat surface, and tracking errors
are Gaussian processes with outliers, gaps and swapped labels.
"""

from .studies import generate

__all__ = ["generate"]

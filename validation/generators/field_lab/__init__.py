"""A tank of an untidy field laboratory: keypoint studies with concealed physics or faults.

Trials of unequal length and quality, water that has not come to rest, bursts of outliers,
swapped labels, frozen frames and a battery in varying state of charge. The dynamics are a
variational midpoint rule with 1 ms steps; the effects are engineering forms.
"""

from .studies import generate

__all__ = ["generate"]

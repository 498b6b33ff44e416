"""Keypoint studies with hidden causes, simulated from the momentum form of the flat-plate model."""

from .studies import generate

__all__ = ["generate"]

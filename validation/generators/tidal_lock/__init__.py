"""Synthetic studies of a fish-like robot filmed from above, with known hidden causes."""

from .study import generate

__all__ = ["generate"]

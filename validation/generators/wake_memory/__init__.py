"""Concealed keypoint studies of an unsteady, wake-remembering tank."""

from .studies import generate

__all__ = ["generate"]

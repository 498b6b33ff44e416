"""Momentum of body and fluid in body axes, a vortex-lattice fin, Newton-traced refraction."""

from .studies import generate

__all__ = ["generate"]

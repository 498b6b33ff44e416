"""Concealed keypoint studies from a towing-tank view of a robotic fish (MMG, Abkowitz)."""

from validation.generators.manoeuvring.studies import generate

__all__ = ["generate"]

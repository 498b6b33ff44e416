"""Concealed studies from a strip-theory tank: head plate as published, the rest by sections."""

from validation.generators.strip_theory.studies import generate

__all__ = ["generate"]

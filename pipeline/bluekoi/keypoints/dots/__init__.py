"""Coloured dots: where they are and how well that is known."""

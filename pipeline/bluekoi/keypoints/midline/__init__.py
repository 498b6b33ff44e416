"""Bending bodies: a midline with several joints fitted to the picture, and its parts."""

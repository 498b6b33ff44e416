"""Rendered footage of a robot whose laws are known, with its truth (shares no code with the analysis)."""

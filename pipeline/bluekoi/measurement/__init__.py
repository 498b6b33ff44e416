"""Faults of the measurement that look like physics: one file a cause, the folder is the list."""

"""Shared by several figures: style, grouping of trials, model sweeps, the pool, missing force."""

"""Balls dropped from a bridge: gravity alone, and what it leaves out."""

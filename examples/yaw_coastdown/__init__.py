"""A surface vessel that spins down: what damps its yaw, and what shifts it."""

"""A tail-driven robotic fish: the flat-plate model with tail bias and tail amplitude."""

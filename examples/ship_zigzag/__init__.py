"""A 7 m ship model in zigzags: what a symmetric, linear manoeuvring model leaves out."""

"""BlueKoi: overhead footage of a fish-like robot in, coefficients and left-out physics out."""

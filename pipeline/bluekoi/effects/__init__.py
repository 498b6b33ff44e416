"""Physics that the two-plate model leaves out: one file an effect, the folder is the list."""

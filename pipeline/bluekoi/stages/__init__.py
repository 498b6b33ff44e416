"""Files in, files out: one module a rule of the Snakefile, with a function of the same name."""

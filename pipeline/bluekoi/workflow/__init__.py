"""What the Snakefile calls: the plan of a run, its fingerprints, its processes, its progress."""

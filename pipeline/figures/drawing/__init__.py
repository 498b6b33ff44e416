"""What several figures share: look, grouping of trials, the model's sweeps, the pool."""

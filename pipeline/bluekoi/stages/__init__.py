"""Stages of the workflow: each rule of the Snakefile calls the function of one module here."""

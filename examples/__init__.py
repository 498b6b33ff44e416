"""Recordings made by others through the same engine, each with a small model of its own.

One folder a recording: `reading` (files to series), `model` (the simple model), `effects` (what may
have been left out), `__main__` (the command). `engine` is the one place where they meet
`pipeline.fitting` and `pipeline.mismatch`. What they show is in docs/evidence.md.
"""

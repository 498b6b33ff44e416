"""Recordings made by others through the same engine, each with a small model of its own.

One folder a recording: `reading` (files to series), `model` (the simple model and what may have
been left out), `picture` (its figure), `__main__` (the command). `engine` is the one place where
they meet `bluekoi.fitting` and `bluekoi.mismatch`; `randomness` has the random parts that all of
them need, `forecasting` predictions with their uncertainty, `where` what a missing force
depends on, `telling` and `drawing` tables and figures. The results are in docs/recordings.md.
"""

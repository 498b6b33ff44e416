"""A second tank, for concealed studies: compiled, pulsed thrust, forces strip by strip.

quantities -> water, drive, plates, extras -> motion

Shares no dynamics with the analysis nor with the first tank's solver (docs/challenge.md says what
it has that the model has not).
"""

"""Studies of the flat-plate robot in a small basin, with hidden causes.

Written from MODEL.md, STUDY.md and FINDER.md, without reading code of the finder or of another
generator. The page of the candidate causes (docs/effects.md) was read, so that the formulas of the
laws could differ from those there.

The motion is integrated in axes of the core for all trials at once, with the full added mass where
a law asks for it (`motion`). Laws of motor, water, head and body have two to four forms each
(`catalogue`); a fin has one of four (`robots`). The size of a law is set by the path error that
remains after the published model is refitted, over a floor that contains moving water and errors of
servo and frequency (`refit`, `design`). Sizes of measurement errors are prescribed (`faults`).
Heave, roll, waves, and recoil that changes the mean forces are left out.
"""

from .studies import generate

__all__ = ["generate"]

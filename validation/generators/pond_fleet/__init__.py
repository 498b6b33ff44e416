"""Studies of a fleet of robots of 0.2 to 1.2 m in pools in proportion, with hidden causes.

Written from MODEL.md, STUDY.md and the families in FINDER.md, without reading code or pages of the
finder, or the laws, motion, optics and noise of another generator.

robots, fins      robots in proportion to their length, and their fins
flow, law         what a law may depend on, and what it is
drag_laws, drive_laws, head_laws, water_laws, unlisted_laws      the hidden laws
dynamics          published model with the laws, Runge-Kutta in the head frame
trials, eddies    conditions and starts of a session, and its moving water
experiment, scatter, detector, sizing      how visible a cause is, and the size that makes it so
plan, hiding      which causes a study hides
camera, faults, tracker, filming           the recording and errors of measurement
writing, truth, studies                    files

Left out: roll, pitch and sinking, forces that accelerating water exerts on the body, the second
order of recoil, waves in the optics. The detector sees neither motor logs nor the core's direction.
"""

from .studies import generate

__all__ = ["generate"]

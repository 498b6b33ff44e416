"""A tank whose robot is written down in axes of its leading plate.

Written from MODEL.md (equations, conventions, sizes) and STUDY.md (files, meaning of the names of
causes) alone, with forms of laws from the literature: Polhamus's vortex lift, Wagner's function,
Kirchhoff's stall, Havelock's hump, Stribeck friction, Lamb and Oseen's vortex.

robots         dimensions, coefficients, fins, growth of disturbances of straight swimming
here           what a law sees and changes; settings of trials; laws and families
motion         equations of motion, adaptive simulation, advance over an interval
water          swirls and random torques
drive_laws, drag_laws, water_laws, unlisted_laws, registry    hidden laws and their forms
session        powers, angles, releases, motion of all trials
optics, sight  camera, refraction; errors of measurement and what a laboratory then sees
kalman, detect what an ideal detector makes of a law beside coefficients, noise and rival causes
hiding, plan   what a study hides and how large
tracker, filming, files    labels, tracking errors, shaft, the files of a study
truth, studies the truth; `generate`

The significance of a cause (`sigma`) is the length of its whitened signal outside the space of six
coefficients, fin and other hidden causes; water, tracking, servo and thrust errors are in the
whitening. `sigma_beside_best_rival` also leaves out the cause of the list that resembles it most;
for an unlisted force, the best pair of causes.

Left out: pitch, roll and heave other than sinking; recoil as dynamics (it is added to the labels);
forces of the turning head on the core; rolling shutter; videos. The detector ignores the lateness
of the head that is seen directly, and what a motor log shows of spin-up and sag.
"""

from .studies import generate

__all__ = ["generate"]

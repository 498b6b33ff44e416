"""Studies of robots of many sizes in pools in proportion, with hidden causes.

Written from MODEL.md, STUDY.md and the families in FINDER.md, without reading code or pages of the
finder, or the laws, motion and optics of another generator.

robots      scaled robots and their fins             body_laws, drive_laws, head_laws, water,
loads       published model, fin and hidden laws     unlisted_laws      the hidden laws
motion      impulses of body and water, 3/8 rule     form    what a law is
trials      schedule and starts                      plan    which causes a study hides
refit       how much a law matters; sizes            faults  errors of measurement
camera, labels, filming, writing, truth, studies     the recording and its files

Left out: roll, heave apart from sinking, second-order mean forces of recoil, forces of water that
accelerates about a body with added mass, and waves in the optics.
"""

from .studies import generate

__all__ = ["generate"]

"""BlueKoi: overhead footage of a fish-like robot in, coefficients and left-out physics out.

Modules in the order of the data flow:

    study         a study folder, read and checked at the door
    footage       frames with true timestamps from one recording
    keypoints     where the parts of the robot are, in pixels: one source a file
    camera        lens, pose and refraction: from pixels to metres
    motor         flapping frequency from the motor log
    pose          pose of the rigid parts, frame by frame
    smoothing     motion with its rates and their uncertainty
    steady        steady speed and turn of a trial
    integrate     compiled simulation of any state-space model
    fitting       fits on whole trajectories
    engine        the finder for any system: probabilities of the causes it left out
    explain       the finder for a model and recordings of your own
    effects       candidate physics: one effect a file
    measurement   candidate measurement errors: one a file
    observation   what camera and clock record of a motion
    model         the paper's equations, with effects added
    tuning        the paper's three steps and the joint fit
    design_space  other designs and manoeuvres of the fitted robot
    mismatch      the finder of the robot: mismatch.json
    campaign      a study and everything its run has written
    figures       one figure a file
    report        one self-contained page with all of it
    comparison    two runs side by side
    preparation   a study pre-filled, checked, previewed and set up in the browser
    synthetic     footage rendered from known truth; imports nothing that it tests

    data, files, errors    types that flow, files written whole, messages for mistakes in the input
    vector_width           the widest vectors of the processor, for compiled functions
    stages, workflow, cli  files in and files out, what Snakemake asks, what a person calls

Public names (`__all__`) are documented in docs/api.md; each module is imported when a name of it is
first used.
"""

from __future__ import annotations

from importlib import import_module

TYPE_CHECKING = False  # as type checkers know it; importing typing costs twenty modules

if TYPE_CHECKING:
    from .campaign import Campaign, load_campaign
    from .data import Track, read_track
    from .errors import InputError
    from .figures import draw
    from .model import Simulation, simulate
    from .study import Study, Trial, load_study

_MODULES = {
    "Campaign": "campaign",
    "InputError": "errors",
    "Simulation": "model",
    "Study": "study",
    "Track": "data",
    "Trial": "study",
    "draw": "figures",
    "load_campaign": "campaign",
    "load_study": "study",
    "read_track": "data",
    "simulate": "model",
}
"""Module of each public name."""

__all__ = [
    "Campaign",
    "InputError",
    "Simulation",
    "Study",
    "Track",
    "Trial",
    "draw",
    "load_campaign",
    "load_study",
    "read_track",
    "simulate",
]


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        raise AttributeError(f"module 'bluekoi' has no attribute {name!r}")
    return getattr(import_module(f".{_MODULES[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])

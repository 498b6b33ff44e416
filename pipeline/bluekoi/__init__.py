"""BlueKoi: overhead footage of a fish-like robot in, coefficients and left-out physics out.

Modules in the order of the data flow:

    study         reads and checks a study folder
    footage       frames with true timestamps from one recording
    keypoints     positions of the body parts in pixels: one source a file
    camera        lens, pose and refraction: from pixels to metres
    motor         flapping frequency from the motor log
    pose          pose of the rigid parts, frame by frame
    smoothing     motion with its rates and their uncertainty
    steady        steady speed and turn of a trial
    integrate     compiled simulation of any state-space model
    fitting       fits on whole trajectories
    engine        the finder for any system: probabilities of the causes it left out
    explain       the finder for a model and recordings of your own
    effects       candidate physical effects: one a file
    measurement   candidate measurement errors: one a file
    observation   observation model: what camera and clock record of a motion
    model         the paper's equations, with effects added
    tuning        the paper's three steps and the joint fit
    design_space  other designs and manoeuvres of the fitted robot
    mismatch      the finder of the robot: mismatch.json
    campaign      a study and all results of its run
    trial_warnings  what to check in the files and trials of a study
    figures       one figure a file
    report        one self-contained page with all results
    comparison    two runs side by side
    preparation   a study pre-filled, checked, previewed and set up in the browser
    synthetic     renders footage from known truth; imports nothing that it tests

    data, files, errors    data types, atomic file writing, messages for errors in the input
    numba_settings         settings of numba: vectors of the processor, folder of compiled code
    stages, workflow, cli  steps that read and write files, calls from Snakemake, commands

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

_MODULE_BY_PUBLIC_NAME = {
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
    if name not in _MODULE_BY_PUBLIC_NAME:
        raise AttributeError(f"module 'bluekoi' has no attribute {name!r}")
    return getattr(import_module(f".{_MODULE_BY_PUBLIC_NAME[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])

"""The observation model: what camera and clock record of a motion. The motion is independent of it.

view            numbers of the camera and of the keypoints that measurement errors depend on
equations       stages: rate of true time, recorded pose
tracking_error  random errors of tracking, present in every filter

Candidate measurement errors add to these stages: one file each in `measurement/`.
"""

from .equations import CLOCK_STAGE, OBSERVATION_STAGE, OBSERVED_QUANTITIES
from .trial_camera_errors import CameraErrorInputs, camera_error_constant_names, camera_error_inputs

"""Frames with true timestamps from one recording, and H.264 for the overlays.

open_recording(paths)  -> Recording     what is in the files, checked, with remarks
frames(recording)      -> Frame, ...    luma (and bgr) at the times the camera stamped
encode_h264(path, ...)                  an H.264 video that any browser plays
"""

from .frame_reading import frames
from .recording import open_recording
from .video_writing import encode_h264

__all__ = ["encode_h264", "frames", "open_recording"]

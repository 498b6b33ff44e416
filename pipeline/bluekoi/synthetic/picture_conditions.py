"""What makes footage easy or hard: light, noise, blur, compression, and things in the way."""

from collections.abc import Mapping
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class PictureConditions:
    """What decides how hard the pictures of a recording are to read: light, noise, blur, obstacles.

    noise, chroma_noise     rms of the sensor noise, grey levels of 255
    caustics                rms of the moving light on the floor, share of the brightness
    glare_spots, glare      lamps mirrored in the surface: how many, how bright (grey levels)
    contrast                1: the robot's own colours; below: nearer to the floor's
    exposure_s, sub_frames  shutter time, and how many poses are averaged over it
    mbit_s, codec, preset   stream: bit rate at this size, `h264` or `hevc`, encoder's preset
    shadow, markers         the robot's shadow on the floor; coloured dots on its keypoints
    occluder, hand, second_body   a bar across the pool; a hand reaching in; another moving body
    view_shift_m            camera aimed past the pool by this much: the robot leaves the picture
    nudge_at_s, nudge_deg   the camera is knocked then, by this angle
    """

    size_px: tuple[int, int] = (1920, 1080)
    codec: str = "h264"
    mbit_s: float = 45.0
    preset: str = "ultrafast"
    noise: float = 2.0
    chroma_noise: float = 1.0
    caustics: float = 0.06
    glare_spots: int = 2
    glare: float = 90.0
    contrast: float = 1.0
    exposure_s: float = 1 / 240
    sub_frames: int = 4
    shadow: bool = True
    markers: bool = False
    occluder: bool = False
    hand: bool = False
    second_body: bool = False
    view_shift_m: float = 0.0
    nudge_at_s: float | None = None
    nudge_deg: float = 0.25


CALM_PICTURE_CONDITIONS = PictureConditions(
    noise=1.0,
    chroma_noise=0.5,
    caustics=0.03,
    glare_spots=0,
    exposure_s=1 / 480,
    sub_frames=3,
    mbit_s=60.0,
)
MIDDLE_PICTURE_CONDITIONS = PictureConditions()
HARD_PICTURE_CONDITIONS = PictureConditions(
    noise=5.0,
    chroma_noise=2.5,
    caustics=0.16,
    glare_spots=4,
    glare=170.0,
    contrast=0.6,
    exposure_s=1 / 60,
    sub_frames=6,
    mbit_s=12.0,
    preset="superfast",
)

PICTURE_CONDITIONS_BY_NAME: Mapping[str, PictureConditions] = {
    "calm": CALM_PICTURE_CONDITIONS,
    "middle": MIDDLE_PICTURE_CONDITIONS,
    "hard": HARD_PICTURE_CONDITIONS,
    "noise": replace(MIDDLE_PICTURE_CONDITIONS, noise=6.0, chroma_noise=3.0),
    "glare": replace(MIDDLE_PICTURE_CONDITIONS, glare_spots=6, glare=200.0),
    "caustics": replace(MIDDLE_PICTURE_CONDITIONS, caustics=0.18),
    "blur": replace(MIDDLE_PICTURE_CONDITIONS, exposure_s=1 / 48, sub_frames=8),
    "compression": replace(MIDDLE_PICTURE_CONDITIONS, mbit_s=8.0),
    "occluder": replace(MIDDLE_PICTURE_CONDITIONS, occluder=True),
    "hand": replace(MIDDLE_PICTURE_CONDITIONS, hand=True),
    "second_body": replace(MIDDLE_PICTURE_CONDITIONS, second_body=True),
    "leaving": replace(MIDDLE_PICTURE_CONDITIONS, view_shift_m=1.2),
    "nudged": replace(MIDDLE_PICTURE_CONDITIONS, nudge_at_s=1.5),
    "markers": replace(MIDDLE_PICTURE_CONDITIONS, markers=True),
}

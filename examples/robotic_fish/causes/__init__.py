"""What the flat-plate model of the fish may have left out, by where it would sit."""

from . import camera, tail, water

CAUSES = (*water.CAUSES, *camera.CAUSES, *tail.CAUSES)

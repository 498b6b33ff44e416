"""The project's own generator: compiled tank with pulsed thrust and forces strip by strip.

quantities, water, drive, plates, extras -> swimmer     the tank
effects, faults, robots -> recipe, plan                 what is drawn
strength -> trials -> writing                           studies on disk
"""

from .studies import generate

__all__ = ["generate"]

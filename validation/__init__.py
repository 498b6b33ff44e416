"""How well the finder does on studies that it was not developed on; not part of the wheel.

generators  independent tanks, each a package that writes studies and their truths
running     studies -> measured tracks -> verdicts, resumable and in parallel
scoring     verdicts against truths, with intervals
"""

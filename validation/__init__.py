"""How well the finder does on studies that it was not developed on; not part of the wheel.

generators    tanks, each a package that writes studies and their truths
sealing       hashes of the truths, published before the analysis and checked after it
isolation     processes that cannot read the truths
running       studies -> measured tracks -> verdicts, resumable and in parallel
scoring       verdicts against truths, with intervals
tracking      keypoints as a tracker writes them, for studies without video
ground_truth  the truth of one study beside its results, as a page
"""

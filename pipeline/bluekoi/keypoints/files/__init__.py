"""Readers of keypoint files: DeepLabCut csv and h5, SLEAP analysis h5."""

"""Footage of a robot whose laws are known, with its truth; shares no code with the analysis.

water -> laws -> tank             what moves the robot
optics                            from the pool to the pixel
body, raster, scene, glare, distractors, picture, film, encode    what the camera records
motor_log, tracking               what potentiometer and tracker would have written
design, trial, campaign           whole studies on disk
"""

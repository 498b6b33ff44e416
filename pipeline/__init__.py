"""BlueKoi: overhead footage of a fish-like robot in, coefficients and left-out physics out.

The way through the house, in the order in which the data flow:

    study         a study folder, read and checked at the door
    footage       frames with true timestamps from one recording
    keypoints     where the parts of the robot are, in pixels: one source a file
    camera        lens, pose and refraction: from pixels to metres
    motor         flapping frequency from the motor log
    pose          pose of the rigid parts, frame by frame
    smoothing     motion with its rates and their uncertainty
    steady        steady speed and turn of a trial
    integrate     compiled simulation of any state-space model
    fitting       fits on whole trajectories
    effects       candidate physics: one effect a file
    measurement   candidate faults of the measurement: one a file
    model         the paper's equations, with effects added
    tuning        the paper's three steps and the joint fit
    design_space  other designs and manoeuvres of the fitted robot
    mismatch      what was left out: is there anything, where, what
    campaign      a study and everything its run has written
    figures       one figure a file
    report        one self-contained page with all of it
    challenge     concealed studies made, analysed without their truth, scored
    synthetic     footage rendered from known truth; imports nothing that it tests

    data, files, faults    types that flow, files written whole, mistakes told in words
    stages, workflow, cli  files in and files out, what Snakemake asks, what a person calls
"""

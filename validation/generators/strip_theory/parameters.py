"""Layout of the parameter vector `P` that every compiled force reads: name and unit by index.

A value of zero switches an effect off. `*_FORM` entries choose the functional form.
"""

from collections import namedtuple

PARAMETERS = (
    # base model and geometry
    *(("RHO", "kg/m3"), ("MASS", "kg"), ("INERTIA", "kg m2"), ("AREA", "m2"), ("ARM", "m")),
    *(("C_T", "m2"), ("C_LA", "1"), ("C_DA", "1"), ("C_D0", "1"), ("C_MA", "m"), ("C_MD", "kg m2")),
    *(("HEAD", "m"), ("HINGE", "m"), ("AFT", "m"), ("TAIL", "m"), ("SPAN", "m"), ("BODY", "m")),
    *(("POOL_L", "m"), ("POOL_W", "m"), ("AREA_1X", "m2"), ("PHI_NOW", "rad"), ("HEAD_1X", "m")),
    # body and sections
    *(("FIN_FORM", ""), ("FIN_AREA", "m2"), ("FIN_ASPECT", "1"), ("FIN_VORTEX", "1")),
    *(("AM_FORM", ""), ("AM_SHARE", "1"), ("CROSS_FORM", ""), ("CROSS_CD", "1")),
    *(("COM_FORM", ""), ("COM_SHIFT", "m"), ("ASYM_FORM", ""), ("ASYM", "1")),
    # drag, damping and thrust
    *(("VISC_FORM", ""), ("VISC", "N s/m"), ("WAVE_FORM", ""), ("WAVE", "N"), ("WAVE_V", "m/s")),
    *(("COUL_FORM", ""), ("COUL", "N"), ("COUL_V", "m/s"), ("YAW_FORM", ""), ("YAW_LIN", "N m s")),
    *(("LOSS_FORM", ""), ("LOSS", "1"), ("LOSS_V", "m/s"), ("LINE_FORM", ""), ("LINE", "m")),
    *(("TAREA_FORM", ""), ("TAREA", "1"), ("TRIM_FORM", ""), ("TRIM", "N m")),
    # unsteady head plate
    *(("STALL_FORM", ""), ("STALL", "1"), ("STALL_A", "rad"), ("STALL_W", "rad")),
    *(("LAG_FORM", ""), ("LAG", "s")),
    # water and pool
    *(("CUR_FORM", ""), ("CUR", "m/s"), ("CUR_DIR", "rad"), ("CUR_NOW", "1")),
    *(("GYRE_FORM", ""), ("GYRE", "m/s"), ("GYRE_X", "m"), ("GYRE_Y", "m"), ("GYRE_R", "m")),
    *(("WALL_FORM", ""), ("WALL", "1"), ("WALL_D", "m")),
    *(("WAKE_FORM", ""), ("WAKE", "m/s"), ("WAKE_W", "m"), ("WAKE_TAU", "s")),
    # actuators
    *(("SERVO_FORM", ""), ("SERVO", "s"), ("OFF_FORM", ""), ("OFF", "rad")),
    *(("SPIN_FORM", ""), ("SPIN", "s"), ("SAG_FORM", ""), ("SAG", "1"), ("SAG_TAU", "s")),
    # unlisted forces
    *(("U_FORM", ""), ("U_FORCE", "N"), ("U_MOMENT", "N m"), ("U_A", ""), ("U_B", "")),
    # measurement
    *(("SINK_FORM", ""), ("SINK", "m/s"), ("SCALE_FORM", ""), ("SCALE", "1")),
    *(("CLOCK_FORM", ""), ("CLOCK", "1"), ("SHIFT_FORM", ""), ("SHIFT", "rad"), ("SHIFT_B", "rad")),
    *(("REFR_FORM", ""), ("REFR", "1"), ("LENS_FORM", ""), ("LENS", "1")),
    *(("TIME_FORM", ""), ("TIME", "s"), ("BIAS_FORM", ""), ("BIAS", "m")),
)
NAMES = tuple(name for name, _ in PARAMETERS)
UNITS = dict(PARAMETERS)
INDEX = {name: index for index, name in enumerate(NAMES)}
KEYS = namedtuple("Keys", NAMES)(*range(len(NAMES)))  # compiled code reads P[K.MASS]
COEFFICIENTS = ("C_T", "C_LA", "C_DA", "C_D0", "C_MA", "C_MD")

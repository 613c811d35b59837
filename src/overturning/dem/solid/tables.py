"""What goes into the kernel in space and what comes out of it: the columns of its tables."""

from typing import Final

# Columns of the case table that `run_queue` takes.
(P_BODY, P_STIFFNESS, P_TANGENTIAL, P_DASHPOT, P_FRICTION, P_AMPLITUDE, P_FIRST, P_CALM, P_AFTER, P_FINEST, P_DWELL) = (
    range(11)
)
P_START: Final = 11
"""First of the columns with place, quaternion, velocity and angular velocity at the start."""
START: Final = 13
PARAMETERS: Final = P_START + START

# Columns of the table of bodies.
(B_IXX, B_IYY, B_IZZ, B_IXY, B_IXZ, B_IYZ, B_FOOT, B_RADIUS, B_REACH, B_CRITICAL, B_FALLEN, B_DEEPEST, B_ENDS) = range(
    13
)
B_INERTIA: Final = 13
BODY: Final = 19

# Columns of its results.
(R_STATUS, R_FALLEN, R_TIME, R_LEAN, R_SLIP, R_SLIP_X, R_SLIP_Y, R_DEPTH, R_ENERGY, R_SPIN, R_STEPS) = range(11)
R_QUATERNION: Final = 11
"""First of the columns with the quaternion at the end."""
RESULTS: Final = 15

# Columns of a trajectory: time, place, quaternion, velocity, angular velocity, ground.
(T_TIME, T_X, T_QUATERNION, T_V, T_W, T_GROUND) = (0, 1, 4, 8, 11, 14)
TRAJECTORY: Final = 17

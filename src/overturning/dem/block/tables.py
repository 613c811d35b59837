"""What goes into the kernel of one block and what comes out of it: the columns of its tables."""

from typing import Final

# Columns of the case table that `run_queue` takes.
(P_WIDTH, P_HEIGHT, P_STIFFNESS, P_TANGENTIAL, P_DASHPOT, P_ALPHA, P_AMPLITUDE) = range(7)
(P_TILT_COS, P_TILT_SIN, P_TILT, P_FIRST, P_CALM, P_AFTER, P_FINEST, P_DWELL, P_SETTLED, P_GENTLE, P_STANDING) = range(
    7, 18
)
PARAMETERS: Final = 18

# Columns of its results.
(R_STATUS, R_SIDE, R_TIME, R_ANGLE, R_SLIP, R_RESIDUAL, R_DEPTH, R_ENERGY, R_STEPS) = range(9)
RESULTS: Final = 9

# Columns of a trajectory.
(T_TIME, T_X, T_Z, T_ANGLE, T_VX, T_VZ, T_VW, T_BASE_SLIP, T_DEPTH_L, T_DEPTH_R, T_GROUND) = range(11)
TRAJECTORY: Final = 11

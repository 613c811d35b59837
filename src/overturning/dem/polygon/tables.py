"""What goes into the general kernel and what comes out of it: the columns of its tables."""

from typing import Final

# Columns of an element's rules: whether it is free, angle at which it has fallen for good, angles from which it cannot come
# back towards −x and +x, what it stands on, and the energy that its overturning takes.
(IS_FREE, FALL_ANGLE, TIPS_BACK, TIPS_ON, SUPPORT, BARRIER) = range(6)
RULES: Final = 6
# Columns of a scene's limits: deepest penetration, kinetic energy at rest, least barrier, and the least energy that an error
# is a share of.
DEEPEST_ALLOWED, REST_ENERGY, LEAST_BARRIER, LEAST_SCALE = range(4)
LIMITS: Final = 4
# Columns of the case table.
(P_AMPLITUDE, P_FRICTION, P_DAMPING, P_FIRST, P_CALM, P_AFTER, P_FINEST, P_DWELL) = range(8)
PARAMETERS: Final = 8  # and of each part that can move as one, from which sample on it stands for good
# Results of a case, and of each element.
(R_STATUS, R_DEPTH, R_ENERGY, R_STEPS) = range(4)
RESULTS: Final = 4
(E_SIDE, E_TIME, E_ANGLE, E_SLIP, E_RESIDUAL) = range(5)
ELEMENT_RESULTS: Final = 5
# A trajectory's columns: time and ground acceleration, then six for each element,
(T_TIME, T_GROUND) = range(2)
(T_X, T_Z, T_ANGLE, T_VX, T_VZ, T_VW) = range(6)
# and, where forces are asked for, five for both ends of each pair: mean force on its first element from this sample to the
# next, mean normal force, and that times the place.
(T_FX, T_FZ, T_LOAD, T_LOAD_X, T_LOAD_Z) = range(5)
FORCE_COLUMNS: Final = 5

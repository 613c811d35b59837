"""Columns of the kernel's tables: cases, bodies, results and trajectories."""

from typing import Final, NamedTuple

import numpy as np

from overturning.dem.kernel.clock import Clock
from overturning.dem.kernel.tuples import dtype_of


class StartColumns(NamedTuple):
    """Columns of an initial pose and its velocities."""

    x: float
    """Place of the centre, m: east,"""
    y: float
    """north,"""
    z: float
    """and up."""
    qw: float
    """Quaternion of the rotation from the pose at rest."""
    qx: float
    qy: float
    qz: float
    vx: float
    """Velocity, m/s."""
    vy: float
    vz: float
    wx: float
    """Angular velocity in the frame of the body, rad/s."""
    wy: float
    wz: float


class CaseColumns(NamedTuple):
    """Columns of the table of cases, after the row in the table of bodies, and followed by those of `Clock`."""

    stiffness: float
    """Normal stiffness of a point over the mass, 1/s²."""
    tangential: float
    """Tangential stiffness over the mass, 1/s²."""
    dashpot: float
    """Dashpot of a point over the mass, 1/s."""
    friction: float
    """Coefficient of friction."""
    amplitude: float
    """Factor on the motion."""
    bears: float
    """Horizontal acceleration over g that leaves the body at rest."""
    steady: float
    """Change of the ground acceleration below which steps longer than a sample are allowed, over g."""
    first: float
    """First sample that is computed."""
    calm: float
    """Sample from which the body can come to rest for good."""
    after: float
    """Sample at which the case is undecided."""


class BodyColumns(NamedTuple):
    """Columns of the table of bodies."""

    ixx: float
    """Tensor of inertia about the centre over the mass, m²."""
    iyy: float
    izz: float
    ixy: float
    ixz: float
    iyz: float
    axx: float
    """Inverse of that tensor, 1/m²."""
    ayy: float
    azz: float
    axy: float
    axz: float
    ayz: float
    foot: float
    """Height of the centre above the base, m."""
    radius: float
    """Radius of a round base, m, else 0."""
    reach: float
    """Least horizontal distance of the centre from an edge of the base, m."""
    critical: float
    """sin² of the tilt beyond which the body falls over its nearest edge."""
    fallen: float
    """Cosine of the tilt from which the body has fallen."""
    deepest: float
    """Penetration beyond which a case has failed, m."""
    ends: float
    """Share of the rise from the lowest to the highest vertex of the base within which vertices belong to its ends."""


class ResultColumns(NamedTuple):
    """Columns of the table of results."""

    status: float
    """`Status` as a number."""
    fallen: float
    """1 if the body has fallen."""
    overturning_time: float
    """Time of the fall, s."""
    lean: float
    """Largest lean: sin² of the tilt up to 90°, 2 − sin² beyond."""
    peak_slip: float
    """Largest slip of the base, m."""
    slip_x: float
    """Slip of the base at the end, m."""
    slip_y: float
    peak_penetration: float
    """Largest penetration, m."""
    energy_error: float
    """Error of the energy balance as a share of the input."""
    angular_momentum_error: float
    """Error of the angular momentum about the vertical, over that of a free swing."""
    block_steps: float
    """Number of steps."""
    samples_left_out: float
    """Number of samples that were left out."""
    qw: float
    """Quaternion at the end."""
    qx: float
    qy: float
    qz: float


class GroundColumns(NamedTuple):
    """Columns of the ground acceleration in a trajectory, m/s²."""

    ground_x: float
    ground_y: float
    ground_z: float


START: Final = dtype_of(StartColumns)
CASE: Final = np.dtype([("body", "i8"), *dtype_of(CaseColumns, Clock).descr, ("start", START)])
BODY: Final = dtype_of(BodyColumns)
RESULT: Final = dtype_of(ResultColumns)
ROW: Final = np.dtype([("time", "f8"), *dtype_of(StartColumns, GroundColumns).descr])

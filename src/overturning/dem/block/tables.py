"""Columns of the kernel's tables: cases, results and trajectories."""

from typing import Final, NamedTuple

from overturning.dem.kernel.clock import Clock
from overturning.dem.kernel.tuples import dtype_of


class CaseColumns(NamedTuple):
    """Columns of the table of cases, followed by those of `Clock`."""

    width: float
    """Width, m."""
    height: float
    """Height, m."""
    stiffness: float
    """Normal stiffness of a corner over the mass, 1/s²."""
    tangential: float
    """Tangential stiffness over the mass, 1/s²."""
    dashpot: float
    """Dashpot of a corner over the mass, 1/s."""
    friction: float
    """Coefficient of friction."""
    alpha: float
    """Angle from the vertical of the line from a corner to the centre of mass, rad."""
    amplitude: float
    """Factor on the motion."""
    tilt: float
    """Initial rotation, rad, positive towards the azimuth."""
    tilt_cos: float
    """Its cosine."""
    tilt_sin: float
    """Its sine."""
    first: float
    """First sample that is computed."""
    calm: float
    """Sample from which the block can come to rest for good."""
    after: float
    """Sample at which the case is undecided."""
    gentle: float
    """Largest motion of a corner, m, in a step that is not the finest and in which the corner opens or closes."""
    bears: float
    """Horizontal acceleration over g that leaves the block at rest."""


class ResultColumns(NamedTuple):
    """Columns of the table of results."""

    status: float
    """`Status` as a number."""
    overturned: float
    """Side of the fall: 1 towards the azimuth, −1 away from it, 0 standing."""
    overturning_time: float
    """Time of the fall, s."""
    peak_rotation: float
    """Largest rotation over α."""
    peak_slip: float
    """Largest slip of the base, m."""
    residual_slip: float
    """Slip of the base at the end, m."""
    peak_penetration: float
    """Largest penetration, m."""
    energy_error: float
    """Error of the energy balance as a share of the input."""
    block_steps: float
    """Number of steps."""
    samples_left_out: float
    """Number of samples that were left out."""


class PathColumns(NamedTuple):
    """Columns of a trajectory."""

    time: float
    """Time since the first sample, s."""
    x: float
    """Horizontal displacement of the centre, m, in the frame of the base."""
    z: float
    """Height of the centre, m."""
    angle: float
    """Rotation, rad."""
    vx: float
    """Horizontal velocity, m/s."""
    vz: float
    """Vertical velocity, m/s."""
    vw: float
    """Angular velocity, rad/s."""
    ground: float
    """Ground acceleration, m/s²."""


CASE: Final = dtype_of(CaseColumns, Clock)
RESULT: Final = dtype_of(ResultColumns)
ROW: Final = dtype_of(PathColumns)

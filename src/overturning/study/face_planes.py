"""What the vertical planes of its two pairs of faces say of a rectangular stone in space."""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.dem.contact import Contact
from overturning.dem.grid import Grid
from overturning.dem.numerics import Numerics
from overturning.dem.scene import gravestone
from overturning.dem.simulate import simulate_grid
from overturning.dem.solid.grid import SpaceGrid
from overturning.dem.time_step import DEFAULT_SCHEME
from overturning.dem.variables import INT8_MISSING, Variable
from overturning.model.edges import first_edge
from overturning.motion.motion import Motion
from overturning.study.sections import ContactSettings

PLANE_VARIABLES: Final = (
    Variable(
        "plane_overturned", "i1", "whether the block falls in the vertical plane of either pair of faces",
        attributes={"flag_values": np.array([0, 1], dtype=np.int8), "flag_meanings": "stands falls"},
    ),
    Variable(
        "plane_fall_azimuth", "f4",
        "azimuth to which it falls in that plane, of two the one that passes no return first", "degree",
    ),
)  # fmt: skip
"""What the planes of a rectangle's faces predict of it, beside its outcome in space."""


def face_planes(
    motion: Motion, grid: SpaceGrid, contact: ContactSettings, numerics: Numerics
) -> tuple[dict[str, NDArray[np.generic]], NDArray[np.int64]]:
    """Simulate the block in the planes of its faces: along its orientation B/H wide, across it D/H.

    Where it would fall in both, `first_edge` decides.

    Returns
    -------
    arrays : dict of ndarray, shape of the grid
        `PLANE_VARIABLES` by name.
    block_steps : ndarray of int, shape of the grid
        Work done.
    """
    law = Contact(stiffness_ratio=contact.stiffness_ratio, damping_ratio=contact.damping_ratio)
    options = replace(numerics, scheme=DEFAULT_SCHEME, time_step="auto", progress=None)
    flags, times, towards = (np.zeros((2, *grid.shape)) for _ in range(3))
    steps = np.zeros(grid.shape, np.int64)
    for index, aspect in enumerate(grid.aspect):
        for face, (turn, ratio) in enumerate(((0.0, 1.0), (90.0, float(aspect)))):
            azimuth = grid.orientation.astype(np.float64) + turn
            plane = Grid(azimuth, grid.height, grid.b_over_h * ratio, grid.friction)
            found = simulate_grid(gravestone(law), motion, plane, options)
            at = (face, slice(None), slice(None), slice(None), index)
            side = found["overturned"].astype(np.float64)
            flags[at] = np.where(side == INT8_MISSING, np.nan, np.abs(side))
            times[at] = found["overturning_time"]
            towards[at] = np.mod(azimuth[:, None, None, None] + np.where(side < 0, 180.0, 0.0), 360.0)
            steps[:, :, :, index] += found["block_steps"]
    falls, azimuth = first_edge(flags, times, towards)
    return {
        "plane_overturned": np.nan_to_num(falls, nan=INT8_MISSING).astype(np.int8),
        "plane_fall_azimuth": azimuth,
    }, steps

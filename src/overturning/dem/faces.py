"""2-D outcomes of a rectangular block in the vertical planes of its faces, next to its 3-D outcome."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overturning.dem.numerics import NumericalOptions
from overturning.dem.simulate import simulate_grid
from overturning.dem.time_step import DEFAULT_SCHEME
from overturning.model.body import Body
from overturning.model.contact import Contact
from overturning.model.edges import fall_flag_and_azimuth_from_planes
from overturning.model.grid import CaseGrid
from overturning.model.model import Model
from overturning.model.planes import PlanarModel
from overturning.model.scene import gravestone
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion


def simulate_grid_and_2d_face_planes_of_rectangle(
    model: Model, motion: Motion, grid: CaseGrid, numerics: NumericalOptions
) -> dict[str, NDArray[Any]]:
    """Simulate a grid of cases; if the body is a rectangle in 3-D, also in the vertical planes of its faces.

    Return the arrays of `simulate_grid`. For a rectangle they include the model's variables
    `outcome_variables_of_2d_runs_in_face_planes`: outcomes of the 2-D model with B/H in the plane along the orientation
    and with D/H in the plane across it. If the rectangle falls in both planes, `fall_flag_and_azimuth_from_planes`
    decides. ``block_steps`` includes the steps of the 2-D simulations.
    """
    arrays = simulate_grid(model, motion, grid, numerics)
    if not isinstance(model, Body) or not model.depth_over_width_is_parameter:
        return arrays
    law = Contact(stiffness_ratio=model.contact.stiffness_ratio, damping_ratio=model.contact.damping_ratio)
    planes, options = (
        PlanarModel(gravestone(law)),
        replace(numerics, scheme=DEFAULT_SCHEME, time_step="auto", progress=None),
    )
    flags, times, towards = (np.zeros((2, *grid.shape)) for _ in range(3))
    for index, aspect in enumerate(grid["aspect"]):
        for face, (turn, ratio) in enumerate(((0.0, 1.0), (90.0, float(aspect)))):
            azimuth = grid.direction_values_deg + turn
            rows = {
                "azimuth": azimuth,
                "height": grid["height"],
                "b_over_h": grid["b_over_h"] * ratio,
                "friction": grid["friction"],
            }
            outcome = simulate_grid(planes, motion, CaseGrid(rows), options)
            at = (face, slice(None), slice(None), slice(None), index)
            side = outcome["overturned"].astype(np.float64)
            flags[at] = np.where(side == INT8_MISSING, np.nan, np.abs(side))
            times[at] = outcome["overturning_time"]
            towards[at] = np.mod(azimuth[:, None, None, None] + np.where(side < 0, 180.0, 0.0), 360.0)
            arrays["block_steps"][:, :, :, index] += outcome["block_steps"]
    falls, fall_azimuth = fall_flag_and_azimuth_from_planes(flags, times, towards)
    overturned = np.nan_to_num(falls, nan=INT8_MISSING).astype(np.int8)
    return arrays | {"plane_overturned": overturned, "plane_fall_azimuth": fall_azimuth}

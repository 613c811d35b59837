"""A study of a free body in space: what it simulates, what the planes of a rectangle's faces say of it, its ensemble."""

from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.body.cases import SpaceCases
from overturning.dem.body.grid import SpaceGrid, periods_of
from overturning.dem.body.results import SpaceResults
from overturning.dem.body.run import run_in_space
from overturning.dem.body.simulate import simulate_in_space_arrays
from overturning.dem.numerics import Numerics
from overturning.dem.simulate import simulate_grid
from overturning.dem.time_step import DEFAULT_SCHEME
from overturning.model.contact import BODY_STATIC_PENETRATION, DAMPING_RATIO, Contact, VertexContact
from overturning.model.edges import first_edge
from overturning.model.grid import Grid
from overturning.model.scene import gravestone
from overturning.model.shapes import Shape
from overturning.model.variables import INT8_MISSING, SPACE_VARIABLES, Variable
from overturning.motion.motion import Motion
from overturning.study.ensemble import Arrays, PlaneEnsemble
from overturning.study.grid import representatives_of
from overturning.study.schema import Study
from overturning.study.sections import BodySettings, ContactSettings

REPEATED: Final = Variable("repeated", "i1", "cell is the same case as one at a smaller orientation", attributes={
    "flag_values": np.array([0, 1], dtype=np.int8), "flag_meanings": "computed repeated",
})  # fmt: skip

OUTCOME: Final = (*SPACE_VARIABLES, REPEATED)
"""The variables of a cube in space, besides those of the ensemble and of the planes."""

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

_NEIGHBOURHOOD: Final = {
    "comment": "over the neighbourhood stated in the study; missing where the ensemble was not run"
}

SPACE_ENSEMBLE_VARIABLES: Final = (
    Variable("probability_falls", "f4", "share of ensemble members that fall", attributes=_NEIGHBOURHOOD),
    *(
        Variable(
            name, "f4", f"mean over members of the {what} of the fall, 0 where it stands", attributes=_NEIGHBOURHOOD
        )
        for name, what in (
            ("fall_north", "northward component of the direction"),
            ("fall_east", "eastward component of the direction"),
            ("fall_axis_cosine", "cosine of twice the azimuth"), ("fall_axis_sine", "sine of twice the azimuth"),
        )
    ),
    Variable("scramble_difference", "f4", "probability_falls of the first scramble minus that of the second"),
    Variable("members", "i2", "ensemble members with an outcome"),
)  # fmt: skip
"""What an ensemble in space finds."""


def body_of(study: Study) -> BodySettings:
    """The body of a study that has one."""
    assert study.body is not None
    return study.body


def variables_in_space(study: Study) -> tuple[Variable, ...]:
    """The outcome, and what the planes of its faces would have said of a rectangle."""
    return (*OUTCOME, *PLANE_VARIABLES) if body_of(study).shape().oblong else OUTCOME


def vertex_contact(settings: ContactSettings, stiffer: float = 1.0) -> VertexContact:
    """The contact of a study in space, perhaps with stiffer springs."""
    ratio = DAMPING_RATIO if settings.damping_ratio is None else settings.damping_ratio
    return VertexContact(BODY_STATIC_PENETRATION / stiffer, settings.stiffness_ratio, ratio)


def simulate_space(
    study: Study, settings: ContactSettings, motion: Motion, grid: SpaceGrid, numerics: Numerics
) -> Arrays:
    """Simulate a study's body on its grid, or on a piece of it: arrays of all of its outcome variables."""
    shape = body_of(study).shape()
    arrays = simulate_in_space_arrays(
        motion, orientation_deg=grid.orientation.astype(np.float64), height=grid.height,
        b_over_h=grid.b_over_h if shape.sized else None, friction=grid.friction, aspect=grid.aspect, body=shape,
        contact=vertex_contact(settings), **vars(numerics),
    )  # fmt: skip
    again = (
        representatives_of(study, grid).cell != np.arange(grid.orientation.size)[:, None]
    ) & study.simulation.leave_out
    arrays["repeated"] = np.broadcast_to(again[:, None, None, :, None], grid.shape).astype(np.int8)
    if shape.oblong:
        predicted, steps = face_planes(motion, grid, settings, numerics)
        arrays |= predicted
        arrays["block_steps"] = arrays["block_steps"] + steps
    return arrays


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


def run_space(
    study: Study,
    settings: ContactSettings,
    motion: Motion,
    cases: SpaceCases,
    numerics: Numerics,
    stiffer: float = 1.0,
) -> SpaceResults:
    """Run cases of a study's body, perhaps with stiffer springs."""
    return run_in_space(body_of(study).shape(), motion, cases, numerics, vertex_contact(settings, stiffer))


@dataclass(frozen=True)
class SpaceEnsemble(PlaneEnsemble):
    """The ensemble of a study of a body in space."""

    shape: Shape = field(kw_only=True)

    variables = SPACE_ENSEMBLE_VARIABLES
    marked = "repeated"
    case_type = SpaceCases

    def period(self, grid: SpaceGrid) -> FloatArray:
        """Turn after which the body of each aspect looks the same, degrees."""
        return periods_of(self.shape, grid.aspect)

    def count(self, arrays: Arrays, cells: NDArray[np.int64], flags: NDArray[np.int8], azimuth: FloatArray) -> None:
        """Put means over these cells' members into the variables."""
        where, members = tuple(cells.T), self.members
        known, fell = flags != INT8_MISSING, flags == 1
        angle = np.radians(azimuth - members.azimuth_deg)
        arrays["members"][where] = known.sum(axis=1)

        def mean(values: Any, chosen: Any = True) -> Any:
            count = (known & chosen).sum(axis=1)
            # Rounded: cosines differ in the last digit between processors.
            total = np.round(np.where(fell & chosen, values, 0.0), 9).sum(axis=1)
            return np.where(count > 0, total / np.maximum(count, 1), np.nan)

        for name, values in (
            ("probability_falls", 1.0), ("fall_north", np.cos(angle)), ("fall_east", np.sin(angle)),
            ("fall_axis_cosine", np.cos(2 * angle)), ("fall_axis_sine", np.sin(2 * angle)),
        ):  # fmt: skip
            arrays[name][where] = mean(values)
        arrays["scramble_difference"][where] = mean(1.0, members.scramble == 0) - mean(1.0, members.scramble == 1)

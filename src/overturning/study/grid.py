"""The cases of a study: azimuth × height × slenderness × friction, in space orientation × … × aspect × friction."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.dem.body.grid import SpaceGrid, periods_of
from overturning.model.geometry import plane_period
from overturning.model.grid import Axes, Grid
from overturning.model.symmetry import Sources, representatives
from overturning.study.scenes import NOMINAL, scene_of
from overturning.study.schema import Study


def grid_of(study: Study, variant: str = NOMINAL) -> Axes:
    """The grid of a study, or of a variant; directions ascending, int16 where all are whole, float64 otherwise."""
    if study.body is not None:
        return space_grid(study)
    return plane_grid(study, variant)


def plane_grid(study: Study, variant: str = NOMINAL) -> Grid:
    """The grid of a study in planes."""
    free = scene_of(study, variant).free
    height, b_over_h, friction = (np.array(row, np.float64) for row in (study.height, study.b_over_h, study.friction))
    element = free if len(free) > 1 else ()
    return Grid(_directions(study.azimuth.values()), height, b_over_h, friction, element, _factors(study))


def space_grid(study: Study) -> SpaceGrid:
    """The grid of a study in space."""
    body = study.body
    assert body is not None
    rows = (study.height, study.b_over_h, body.aspect, study.friction)
    height, b_over_h, aspect, friction = (np.array(row, np.float64) for row in rows)
    orientation = _directions(study.orientation.values(body))
    return SpaceGrid(orientation, height, b_over_h, aspect, friction, amplitude=_factors(study))


def _directions(values: Sequence[float]) -> NDArray[Any]:
    """Directions as int16 where all are whole, float64 otherwise."""
    directions = np.array(values, np.float64)
    return directions.astype(np.int16) if np.array_equal(directions, np.round(directions)) else directions


def _factors(study: Study) -> tuple[float, ...]:
    """Factors on each motion; none where a study has it as recorded only."""
    return study.amplitude if len(study.amplitude) > 1 else ()


def representatives_of(study: Study, grid: Axes, variant: str = NOMINAL) -> Sources:
    """Which direction of a grid of a study answers for each; shape (directions, aspects), of planes (…, 1)."""
    period: ArrayLike
    if study.body is None:
        period = plane_period(scene_of(study, variant))
    else:
        period = periods_of(study.body.shape(), grid.coordinates()["aspect"])
    return representatives(getattr(grid, grid.names[0]), period)

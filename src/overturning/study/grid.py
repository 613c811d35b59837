"""The cases of a study: azimuth × height × slenderness × friction, in space orientation × … × aspect × friction."""

import numpy as np

from overturning.dem.grid import Axes, Grid
from overturning.dem.solid.grid import SpaceGrid, periods_of
from overturning.model.symmetry import PLANE_PERIOD, Sources, representatives
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
    azimuth = np.array(study.azimuth.values(), dtype=np.float64)
    whole = np.array_equal(azimuth, np.round(azimuth))
    return Grid(
        azimuth.astype(np.int16) if whole else azimuth,
        np.array(study.height, dtype=np.float64),
        np.array(study.b_over_h, dtype=np.float64),
        np.array(study.friction, dtype=np.float64),
        free if len(free) > 1 else (),
        factors(study),
    )


def space_grid(study: Study) -> SpaceGrid:
    """The grid of a study in space; orientations int16 where all are whole, float64 otherwise."""
    body = study.body
    assert body is not None
    orientation = np.array(study.orientation.values(body), np.float64)
    whole = np.array_equal(orientation, np.round(orientation))
    return SpaceGrid(
        orientation.astype(np.int16) if whole else orientation,
        np.array(study.height, np.float64),
        np.array(study.b_over_h, np.float64),
        np.array(body.aspect, np.float64),
        np.array(study.friction, np.float64),
        amplitude=factors(study),
    )


def factors(study: Study) -> tuple[float, ...]:
    """Factors on each motion; none where a study has it as recorded only."""
    return study.amplitude if len(study.amplitude) > 1 else ()


def representatives_of(study: Study, grid: Axes) -> Sources:
    """Which direction of a grid of a study answers for each; shape (directions, aspects), of planes (…, 1)."""
    period = PLANE_PERIOD if study.body is None else periods_of(study.body.shape(), grid.coordinates()["aspect"])
    return representatives(getattr(grid, grid.names[0]), period)

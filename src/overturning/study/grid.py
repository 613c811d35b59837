"""The cases of a study: every azimuth × height × slenderness × friction, in space every orientation × … × aspect × friction."""

import numpy as np

from overturning.dem.grid import Axes, Grid
from overturning.study.config import Study
from overturning.study.scenes import NOMINAL, scene_of


def grid_of(study: Study, variant: str = NOMINAL) -> Axes:
    """The grid of a study, or of one of its variants; directions ascending, int16 where all are whole, float64 otherwise."""
    if study.body is not None:
        # Imported here: a study in planes does without.
        from overturning.study.space import space_grid

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
    )

"""The cases of a study: every azimuth × height × slenderness × friction."""

import numpy as np

from overturning.dem.grid import Grid
from overturning.study.config import Study
from overturning.study.scenes import NOMINAL, scene_of


def grid_of(study: Study, variant: str = NOMINAL) -> Grid:
    """The grid of a study, or of one of its variants; azimuths ascending, int16 where all are whole, float64 otherwise."""
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

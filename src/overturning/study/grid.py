"""The cases of a study: its directions × height × slenderness (× aspect) × friction."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overturning.model.grid import Grid
from overturning.study.scenes import NOMINAL, model_for
from overturning.study.schema import Study


def grid_of(study: Study, variant: str = NOMINAL) -> Grid:
    """The grid of a study, or of a variant; directions ascending, int16 where all are whole, float64 otherwise."""
    model = model_for(study, variant)
    values = {
        "height": study.height, "b_over_h": study.b_over_h, "aspect": study.aspects, "friction": study.friction,
    }  # fmt: skip
    rows = {name: np.array(values[name], np.float64) for name in model.case_dims}
    element = model.elements if len(model.elements) > 1 else ()
    amplitude = study.amplitude if len(study.amplitude) > 1 else ()
    return Grid({model.direction: directions(study.directions)} | rows, element, amplitude)


def directions(values: Sequence[float]) -> NDArray[Any]:
    """Directions as int16 where all are whole, float64 otherwise."""
    given = np.array(values, np.float64)
    return given.astype(np.int16) if np.array_equal(given, np.round(given)) else given

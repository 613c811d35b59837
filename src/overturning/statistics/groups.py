"""Groups of records that are compared."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray


def record_groups(cube: xr.Dataset) -> dict[str, NDArray[np.bool_]]:
    """Members by name of the group: pulse records against the control where a study has both, otherwise all records.

    By ``pulse(record)`` of the cube, 1 or 0; a record where it is missing is in neither of two groups.
    """
    pulse = np.atleast_1d(cube["pulse"].to_numpy()).astype(np.float64)
    if (pulse == 1).any() and (pulse == 0).any():
        return {"with a velocity pulse": pulse == 1, "without (control)": pulse == 0}
    return {"all records": np.ones(pulse.size, dtype=bool)}

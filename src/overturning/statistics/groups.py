"""Groups of records that are compared."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray


def record_groups(cube: xr.Dataset) -> dict[str, NDArray[np.bool_]]:
    """Pulse records against the control where a study has both, otherwise all records.

    Parameters
    ----------
    cube : Dataset
        With ``pulse(record)``: 1, 0, or missing where it is not known.

    Returns
    -------
    dict of ndarray of bool, shape (records,)
        Members by name of the group; a record of unknown kind is in neither of two groups.
    """
    pulse = np.atleast_1d(cube["pulse"].to_numpy()).astype(np.float64)
    if (pulse == 1).any() and (pulse == 0).any():
        return {"with a velocity pulse": pulse == 1, "without (control)": pulse == 0}
    return {"all records": np.ones(pulse.size, dtype=bool)}
